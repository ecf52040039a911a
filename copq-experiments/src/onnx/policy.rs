//! A policy's graph: normaliser, network, and the environment's own action.

use copq::{Normaliser, Result, State};

use super::layers::Layers;
use super::messages::{DOUBLE, FLOAT, Graph};

/// Bounds of a squashed Gaussian's log std, as in SAC's networks.
const LOG_STD: [f32; 2] = [-20.0, 2.0];

/// The graph of a policy, from its file's content. An error for a network that is not copq's own.
pub fn graph(policy: &State) -> Result<Graph> {
    let layers = Layers::of(policy)?;
    let mut graph = Graph { name: "policy".to_owned(), ..Graph::default() };
    graph.input("obs", layers.obs_len(), &observations(policy, layers.obs_len()));
    let seen = normalised(&mut graph, policy, layers.obs_len())?;
    network(&mut graph, policy.child("actor")?, &layers, seen)?;
    match layers.kind.as_str() {
        "gaussian" => gaussian(&mut graph, layers.action_len),
        "normal" => normal(&mut graph, policy.child("actor")?)?,
        _ => squash(&mut graph, "network"),
    }
    scaled(&mut graph, policy.child("policy")?)?;
    outputs(&mut graph, &layers);
    Ok(graph)
}

/// What an observation is, in words.
fn observations(policy: &State, obs_len: usize) -> String {
    let raw = policy.child("normaliser").and_then(|saved| saved.get_one::<u64>("raw")).unwrap_or(0);
    let own = obs_len.saturating_sub(raw as usize);
    let mut words = format!("Observations as the environment gives them, {own} numbers");
    if raw > 0 {
        words += &format!(
            "; then {raw} of what is left of each cost's budget, from 1 down (Saute: settings.saute \
             in the run's config.toml)"
        );
    }
    words + "."
}

/// From `obs` to what the network sees, whose name it returns. It works in f64, as copq does, and
/// stores all that the normaliser holds.
fn normalised(graph: &mut Graph, policy: &State, obs_len: usize) -> Result<&'static str> {
    let Ok(normaliser) = policy.child("normaliser") else { return Ok("obs") };
    let count: u64 = normaliser.get_one("count")?;
    let mean: &[f64] = normaliser.get("mean")?;
    let squares: &[f64] = normaliser.get("squares")?;
    graph.count("normaliser/count", count);
    graph.doubles("normaliser/mean", &[mean.len()], mean);
    graph.doubles("normaliser/squares", &[squares.len()], squares);
    if count < 2 || mean.is_empty() {
        return Ok("obs"); // Nothing has a deviation yet.
    }
    let raw = obs_len.saturating_sub(mean.len());
    if raw == 0 {
        in_deviations(graph, "obs", "normalised");
        return Ok("normalised");
    }
    graph.lengths("constant/lengths", [mean.len(), raw]);
    let parts = ["measured", "raw"];
    graph.node_with("Split", &["obs", "constant/lengths"], &parts, &[("axis", 1)]);
    in_deviations(graph, "measured", "in_deviations");
    graph.node_with("Concat", &["in_deviations", "raw"], &["normalised"], &[("axis", 1)]);
    Ok("normalised")
}

/// `clip((x - mean) / max(sqrt(squares / (count - 1)), smallest))`
fn in_deviations(graph: &mut Graph, x: &str, output: &str) {
    let to_f64 = [("to", i64::from(DOUBLE))];
    graph.doubles("constant/one_f64", &[], &[1.0]);
    graph.doubles("constant/smallest_std", &[], &[Normaliser::SMALLEST_STD]);
    graph.doubles("constant/clip_low", &[], &[-Normaliser::CLIP]);
    graph.doubles("constant/clip_high", &[], &[Normaliser::CLIP]);
    graph.node_with("Cast", &["normaliser/count"], &["count"], &to_f64);
    graph.node("Sub", &["count", "constant/one_f64"], "count_less_one");
    graph.node("Div", &["normaliser/squares", "count_less_one"], "variance");
    graph.node("Sqrt", &["variance"], "deviation");
    graph.node("Max", &["deviation", "constant/smallest_std"], "divisor");
    graph.node("Reciprocal", &["divisor"], "factor");
    graph.node_with("Cast", &[x], &["exact"], &to_f64);
    graph.node("Sub", &["exact", "normaliser/mean"], "centred");
    graph.node("Mul", &["centred", "factor"], "multiple");
    graph.node("Clip", &["multiple", "constant/clip_low", "constant/clip_high"], "clipped");
    graph.node_with("Cast", &["clipped"], &[output], &[("to", i64::from(FLOAT))]);
}

/// From what the network sees to `network`.
fn network(graph: &mut Graph, actor: &State, layers: &Layers, seen: &str) -> Result<()> {
    let mut input = seen.to_owned();
    for layer in 0..layers.count() {
        let names = ["weight", "bias"].map(|part| format!("layer.{layer}.{part}"));
        let [weight, bias] = [&names[0], &names[1]].map(|name| format!("actor/{name}"));
        let dims = layers.weight(layer);
        graph.floats(&weight, &dims, actor.get(&names[0])?);
        graph.floats(&bias, &dims[..1], actor.get(&names[1])?);
        let is_last = layer + 1 == layers.count();
        let sum = if is_last { "network".to_owned() } else { format!("layer.{layer}") };
        let inputs = [input.as_str(), weight.as_str(), bias.as_str()];
        graph.node_with("Gemm", &inputs, &[sum.as_str()], &[("transB", 1)]);
        if !is_last {
            input = format!("hidden.{layer}");
            activate(graph, &layers.activation, &sum, &input);
        }
    }
    Ok(())
}

fn activate(graph: &mut Graph, activation: &str, input: &str, output: &str) {
    match activation {
        "tanh" => graph.node("Tanh", &[input], output),
        "silu" => {
            let gate = format!("{output}.gate");
            graph.node("Sigmoid", &[input], &gate);
            graph.node("Mul", &[input, &gate], output);
        }
        _ => graph.node("Relu", &[input], output),
    }
}

/// From `network`, means and log stds, to `mean`, `std` and `unit`, the squashed mean.
fn gaussian(graph: &mut Graph, action_len: usize) {
    graph.lengths("constant/halves", [action_len, action_len]);
    let parts = ["mean", "free_log_std"];
    graph.node_with("Split", &["network", "constant/halves"], &parts, &[("axis", 1)]);
    graph.floats("constant/lowest_log_std", &[], &LOG_STD[..1]);
    graph.floats("constant/highest_log_std", &[], &LOG_STD[1..]);
    let bounds = ["free_log_std", "constant/lowest_log_std", "constant/highest_log_std"];
    graph.node("Clip", &bounds, "log_std");
    graph.node("Exp", &["log_std"], "std");
    squash(graph, "mean");
}

/// `unit`, the tanh of an input. It is in f64, because runtimes' f32 is inaccurate near its ends,
/// where actions reach their bounds (onnxruntime's exceeds 1).
fn squash(graph: &mut Graph, input: &str) {
    graph.node_with("Cast", &[input], &["exact_input"], &[("to", i64::from(DOUBLE))]);
    graph.node("Tanh", &["exact_input"], "exact_unit");
    graph.node_with("Cast", &["exact_unit"], &["unit"], &[("to", i64::from(FLOAT))]);
}

/// From `network`, the means, to `mean`, `std` (the same in every row) and `unit`, the clamped
/// mean.
fn normal(graph: &mut Graph, actor: &State) -> Result<()> {
    let log_std: &[f32] = actor.get("log_std")?;
    graph.floats("actor/log_std", &[log_std.len()], log_std);
    graph.node("Identity", &["network"], "mean");
    graph.node("Exp", &["actor/log_std"], "std_of_all");
    graph.node("Shape", &["mean"], "rows");
    graph.node("Expand", &["std_of_all", "rows"], "std");
    graph.node("Clip", &["mean", "constant/minus_one", "constant/one"], "unit");
    Ok(())
}

/// From `unit`, in [-1, 1], to `action` between its bounds: `EnvSpec::scale_action`, operation by
/// operation, so that it ends exactly at the bounds and never beyond.
fn scaled(graph: &mut Graph, about: &State) -> Result<()> {
    for (name, constant) in
        [("constant/half", 0.5), ("constant/one", 1.0), ("constant/minus_one", -1.0)]
    {
        graph.floats(name, &[], &[constant]);
    }
    for name in ["action_low", "action_high"] {
        let bound: &[f32] = about.get(name)?;
        graph.floats(&format!("policy/{name}"), &[bound.len()], bound);
    }
    let [low, high] = ["policy/action_low", "policy/action_high"];
    graph.node("Mul", &[low, "constant/half"], "half_low");
    graph.node("Mul", &[high, "constant/half"], "half_high");
    graph.node("Add", &["half_low", "half_high"], "centre");
    graph.node("Sub", &["half_high", "half_low"], "half_range");
    graph.node("Mul", &["half_range", "unit"], "from_centre");
    graph.node("Add", &["centre", "from_centre"], "free_action");
    graph.node("Max", &["free_action", low], "not_below");
    graph.node("Min", &["not_below", high], "between");
    graph.node("Equal", &["unit", "constant/one"], "is_highest");
    graph.node("Equal", &["unit", "constant/minus_one"], "is_lowest");
    graph.node("Where", &["is_highest", high, "between"], "or_highest");
    graph.node("Where", &["is_lowest", low, "or_highest"], "action");
    Ok(())
}

fn outputs(graph: &mut Graph, layers: &Layers) {
    let action_len = layers.action_len;
    graph.output("action", action_len, "The best guess, in the environment's units and bounds.");
    let before = match layers.kind.as_str() {
        "gaussian" => "before the tanh",
        "normal" => "before the clamp to [-1, 1]",
        _ => return,
    };
    for (name, what) in [("mean", "Mean"), ("std", "Standard deviation")] {
        let doc = format!("{what} of the Gaussian, {before} and the scaling to the bounds.");
        graph.output(name, action_len, &doc);
    }
}
