//! The Python examples run, on a run's folder as it is.

use copq::{Agent, Learner, Method, Policy, Trainer};
use copq_candle::Candle;
use copq_experiments::{Plan, Run, RunFolder, RunSettings, write_onnx};

use crate::python::{python, run, workspace};

/// The numbers in what is printed, below its first line.
fn numbers(printed: &str) -> Vec<f64> {
    let words = printed.lines().skip(1).flat_map(|line| line.split(['[', ']', ' ']));
    words.filter(|word| !word.is_empty()).map(|word| word.parse().unwrap()).collect()
}

#[test]
fn python_reads_a_run_and_acts_by_its_policy() {
    let Some(python) = python("the Python examples") else { return };
    let temporary = tempfile::tempdir().unwrap();
    let path = temporary.path().join("run");
    let env = || copq_envs_rapier::make("a/hopper").unwrap();
    let mut method = Method::cop_td3().warm_up(100);
    method.config.networks.hidden = vec![16, 16];
    method.config.batch = 16;
    let mut plan = Plan::new(&method);
    plan.run = RunSettings { steps: 200, eval_every: 100, eval_episodes: 1, ..plan.run };
    let folder = RunFolder::create(&path, &plan, &method.config).unwrap();
    let learner = Learner::new(method, env().spec(), &Candle::default(), 0).unwrap();
    let agent: Box<dyn Agent> = Box::new(learner);
    let trainer = Trainer::new(env(), agent).unwrap();
    let training = Run::new(trainer, Some(Box::new(env())), folder, plan.run).unwrap();
    training.silent().train().unwrap();

    let examples = workspace().join("examples/python");
    let said = run(&python, &examples.join("read_run.py"), &path);
    for words in [
        "cop-td3 on a/hopper seed 0",
        "metrics: 1 rows to step 200",
        "return/velocity/mean",
        "objectives: safety, velocity, control",
        "actor/layer.0.weight (16, 11)",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }

    let file = path.join("policy.safetensors");
    let onnx = path.join("policy.onnx");
    let policy = Policy::read(&file, &Candle::default()).unwrap();
    write_onnx(&policy, &onnx).unwrap();
    let by_onnx = run(&python, &examples.join("act_onnx.py"), &onnx);
    let by_numpy = run(&python, &examples.join("act_numpy.py"), &file);
    assert!(by_onnx.starts_with("deterministic policy for a/hopper by cop-td3\n"), "{by_onnx}");
    assert!(by_numpy.starts_with("deterministic policy for a/hopper\n"), "{by_numpy}");
    let both = [numbers(&by_onnx), numbers(&by_numpy)];
    assert_eq!(both.each_ref().map(Vec::len), [12, 12], "{by_onnx}{by_numpy}");
    for (one, other) in both[0].iter().zip(&both[1]) {
        assert!((one - other).abs() < 2e-4, "{by_onnx}{by_numpy}");
    }
}
