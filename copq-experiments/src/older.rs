//! `config.toml` files of runs from before a method was a value, in today's form.

use copq::{Ensemble, Method, projection};
use toml::{Table, Value};

/// The configuration in today's form; none if it already has that form, or is not a configuration.
///
/// The old ones named a `program`, in which `projection` was the target's bound or, for REDQ, the
/// one for exploration. The discount was there twice, and FAMO balanced separate critics wherever
/// it was on.
pub(crate) fn modernised(text: &str) -> Option<Table> {
    let mut table: Table = text.parse().ok()?;
    let plan = table.get_mut("plan")?.as_table_mut()?;
    let program = plan.remove("program")?.as_str()?.to_owned();
    let old_method = plan.remove("method").and_then(|method| Some(method.as_str()?.to_owned()));
    let projection = plan.remove("projection")?.as_str()?.to_owned();
    if let Some(run) = plan.get_mut("run").and_then(Value::as_table_mut) {
        run.remove("discount");
    }
    let settings = table.get_mut("settings")?.as_table_mut()?;
    let optimism = settings.get_mut("optimism").and_then(Value::as_table_mut);
    let explores = optimism.is_some();
    let redq = program.starts_with("redq");
    if let Some(optimism) = optimism.filter(|_| redq) {
        optimism.entry("projection").or_insert_with(|| projection.clone().into());
    }
    let method = method(&program, old_method.as_deref(), explores);
    let bound = match projection.as_str() {
        _ if redq => "scalarised-min",
        "conservative" => "mean-std",
        name => name,
    };
    let critics = critics(&method, bound);
    if let Some(famo) = settings.get_mut("famo").and_then(Value::as_table_mut) {
        let separate = matches!(critics, Ensemble::Separate { .. });
        let presets = Method::by_name(&method).ok().and_then(|method| method.config.famo);
        let separate = separate || presets.is_some_and(|famo| famo.separate);
        famo.entry("separate").or_insert(separate.into());
    }
    let plan = table.get_mut("plan")?.as_table_mut()?;
    plan.insert("method".to_owned(), method.into());
    plan.insert("bound".to_owned(), bound.into());
    plan.insert("critics".to_owned(), Value::try_from(critics).ok()?);
    Some(table)
}

/// Today's name for what an old program did.
fn method(program: &str, method: Option<&str>, explores: bool) -> String {
    let oac = if explores { "-oac" } else { "" };
    match (program, method) {
        ("redq" | "redq-gaussian", method) => {
            let sac = if method.is_some_and(|method| method.contains("sac")) { "-sac" } else { "" };
            ["redq", sac, oac].concat()
        }
        // At first these programs had only one method, without a name, and `cop-td3` explored by
        // OAC.
        ("td3", None | Some("cop-td3" | "cop-td3-oac" | "cop-td3-gaussian"))
        | ("swap_projection", _) => ["cop-td3", oac].concat(),
        ("td3", Some("td3")) if explores => "cop-td3-oac".to_owned(),
        ("sac_lagrangian", None) => "cop-cal".to_owned(),
        (_, Some(method)) => method.to_owned(),
        (program, None) => program.to_owned(),
    }
}

/// The critics of a method with this bound.
fn critics(method: &str, bound: &str) -> Ensemble {
    match (Method::by_name(method), projection::by_name(bound)) {
        (Ok(method), _) if method.bound.name() == bound => method.critics,
        (_, Ok(bound)) => bound.ensemble(),
        _ => Ensemble::Spanning,
    }
}
