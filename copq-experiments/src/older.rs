//! `config.toml` files of runs from before a method was a value, as today's.

use copq::{Ensemble, Method, projection};
use toml::{Table, Value};

/// The configuration in today's words; none if it has them already, or is no configuration.
///
/// The old ones named a `program`, in which `projection` was the target's bound or, for REDQ, the exploring one; the discount
/// stood twice.
pub(crate) fn modernised(text: &str) -> Option<Table> {
    let mut table: Table = text.parse().ok()?;
    let optimism = table.get("settings")?.get("optimism").is_some();
    let plan = table.get_mut("plan")?.as_table_mut()?;
    let program = plan.remove("program")?.as_str()?.to_owned();
    let method = plan.remove("method").and_then(|method| Some(method.as_str()?.to_owned())).unwrap_or(program.clone());
    let method = match program.as_str() {
        "redq" => {
            ["redq", if method.contains("sac") { "-sac" } else { "" }, if optimism { "-oac" } else { "" }].concat()
        }
        "swap_projection" => "cop-td3".to_owned(),
        // The first programs had no name for their method.
        "td3" if method == "td3" && plan.get("task")?.as_str()?.starts_with("a/") => {
            if optimism { "cop-td3-oac" } else { "cop-td3" }.to_owned()
        }
        _ => method,
    };
    let known = Method::by_name(&method).ok();
    let projection = match plan.remove("projection")?.as_str()? {
        "conservative" => "mean-std".to_owned(),
        name => name.to_owned(),
    };
    let bound = if program == "redq" { "scalarised-min".to_owned() } else { projection };
    let critics = match (known, projection::by_name(&bound)) {
        (Some(known), _) if known.bound.name() == bound => known.critics,
        (_, Ok(bound)) => bound.ensemble(),
        _ => Ensemble::Spanning,
    };
    if let Some(run) = plan.get_mut("run").and_then(Value::as_table_mut) {
        run.remove("discount");
    }
    plan.insert("method".to_owned(), method.into());
    plan.insert("bound".to_owned(), bound.into());
    plan.insert("critics".to_owned(), Value::try_from(critics).ok()?);
    Some(table)
}
