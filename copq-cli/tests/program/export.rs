//! Policies that leave their run, and runs that begin with them.

use std::path::Path;
use std::process::Output;

use copq::State;
use copq_experiments::read_policy;

use crate::common::{TINY, assert_well, copq, words};

/// A tiny run, with a few words more.
fn train(out: &Path, more: &[&str]) -> Output {
    let mut command = copq();
    command.arg("train").args(TINY.split(' ')).args(["--steps", "120", "--out"]).arg(out);
    command.args(more).output().unwrap()
}

fn export(from: &Path, more: &[&str]) -> Output {
    copq().arg("export").arg(from).args(more).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A run's checkpoint, its best policy or its rows under a policy or a table would be lost.
#[test]
fn what_a_run_has_is_not_written_over() {
    let temporary = tempfile::tempdir().unwrap();
    let run = temporary.path().join("run");
    assert_well(&train(&run, &[]));
    let refused = |name: &str, write: &dyn Fn(&Path) -> Output| {
        let file = run.join(name);
        let before = std::fs::read(&file).unwrap();
        let output = write(&file);
        let wanted = "wanted a new file, or one outside a run, got one of a run";
        assert!(words(&output).contains(wanted), "{name}: {}", words(&output));
        assert!(before == std::fs::read(&file).unwrap(), "{name}");
    };
    for name in ["checkpoint.safetensors", "policy-best.safetensors", "config.toml"] {
        refused(name, &|file| export(&run, &["--out", text(file)]));
    }
    let labelled = format!("a={}", run.display());
    refused("evaluations.csv", &|file| {
        copq().arg("plot").arg("--table").arg(file).arg(&labelled).output().unwrap()
    });
}

#[test]
fn both_formats_hold_the_same_policy() {
    let temporary = tempfile::tempdir().unwrap();
    let path = |name: &str| temporary.path().join(name);
    let run = path("run");
    assert_well(&train(&run, &[]));

    // In the run's folder, unless said otherwise.
    let learned = std::fs::read(run.join("policy.safetensors")).unwrap();
    std::fs::remove_file(run.join("policy.safetensors")).unwrap();
    assert_well(&export(&run, &[]));
    assert!(learned == std::fs::read(run.join("policy.safetensors")).unwrap(), "as the run's own");
    assert_well(&export(&run, &["--format", "onnx"]));
    let state = State::read_file(run.join("policy.safetensors")).unwrap();
    assert_eq!(read_policy(run.join("policy.onnx")).unwrap(), state);
    let about = state.child("policy").unwrap();
    assert_eq!(about.get_text("method").unwrap(), "cop-td3");
    assert_eq!(about.get_text("objectives").unwrap(), "safety\nvelocity\ncontrol");

    // The name says the format, and may not say another one.
    let robot = path("robot.onnx");
    assert_well(&export(&run, &["--out", text(&robot)]));
    assert_eq!(read_policy(&robot).unwrap(), state);
    assert_well(&export(&run, &["--format", "safetensors", "--out", text(&path("robot.bin"))]));
    assert_eq!(State::read_file(path("robot.bin")).unwrap(), state);
    let output = export(&run, &["--format", "safetensors", "--out", text(&robot)]);
    let wanted = "--format safetensors: wanted an --out that ends in .safetensors, got ";
    assert!(words(&output).contains(wanted), "{}", words(&output));
    assert_eq!(read_policy(&robot).unwrap(), state, "the file is as it was");

    // A policy's file to the other format, and back.
    assert_well(&export(&run.join("policy-best.safetensors"), &["--format", "onnx"]));
    let best = State::read_file(run.join("policy-best.safetensors")).unwrap();
    assert_eq!(read_policy(run.join("policy-best.onnx")).unwrap(), best);
    let back = path("back.safetensors");
    assert_well(&export(&run.join("policy-best.onnx"), &["--out", text(&back)]));
    assert_eq!(State::read_file(&back).unwrap(), best);
    let output = export(&back, &[]);
    assert!(
        words(&output).contains("wanted a new file (--out), got one that exists"),
        "{}",
        words(&output)
    );
}

#[test]
fn a_run_begins_with_an_onnx_file_as_with_the_other() {
    let temporary = tempfile::tempdir().unwrap();
    let path = |name: &str| temporary.path().join(name);
    assert_well(&train(&path("teacher"), &[]));
    assert_well(&export(&path("teacher"), &["--format", "onnx"]));
    for format in ["safetensors", "onnx"] {
        let policy = path("teacher").join("policy").with_extension(format);
        assert_well(&train(&path(format), &["--seed", "5", "--init-from", text(&policy)]));
    }
    for name in ["policy-init.safetensors", "evaluations.csv", "checkpoint.safetensors"] {
        let read = |format: &str| std::fs::read(path(format).join(name)).unwrap();
        assert!(read("safetensors") == read("onnx"), "{name}");
    }
    // It goes on without its teacher.
    std::fs::remove_dir_all(path("teacher")).unwrap();
    let mut resume = copq();
    assert_well(&resume.arg("resume").arg(path("onnx")).args(["--steps", "130"]).output().unwrap());
}

#[test]
fn a_damaged_or_foreign_file_begins_nothing() {
    let temporary = tempfile::tempdir().unwrap();
    let path = |name: &str| temporary.path().join(name);
    assert_well(&train(&path("teacher"), &[]));
    assert_well(&export(&path("teacher"), &["--out", text(&path("sound.onnx"))]));
    let sound = std::fs::read(path("sound.onnx")).unwrap();
    let mut damaged = sound.clone();
    damaged[sound.len() / 2] ^= 1;
    // ONNX's field of the producer, as another program writes it.
    let foreign = b"\x08\x08\x12\x07pytorch";
    for (name, bytes, wanted) in [
        ("damaged.onnx", damaged.as_slice(), "wanted the bytes that copq wrote, got different"),
        ("cut.onnx", &sound[..sound.len() / 2], "as ONNX (is it damaged?)"),
        ("foreign.onnx", foreign, "wanted copq (only its own policies can be read back), got"),
        ("noise.safetensors", b"words of somebody's", "as a policy file (safetensors or ONNX)"),
    ] {
        std::fs::write(path(name), bytes).unwrap();
        let output = train(&path("pupil"), &["--init-from", text(&path(name))]);
        let said = words(&output);
        assert!(!output.status.success() && said.contains(wanted), "{name}: {said}");
        assert!(said.contains(name) && !said.contains("panicked"), "{name}: {said}");
        assert!(!path("pupil").exists(), "{name}");
    }
    let checkpoint = path("teacher").join("checkpoint.safetensors");
    let output = train(&path("pupil"), &["--init-from", text(&checkpoint)]);
    assert!(words(&output).contains("got a checkpoint"), "{}", words(&output));
    // One that is sound but does not fit.
    let mut wrong = copq();
    wrong.args(["train", "sac", "--init-from"]).arg(path("sound.onnx"));
    let output = wrong.arg("--out").arg(path("x")).output().unwrap();
    assert!(words(&output).contains("the policy to begin with: wanted"), "{}", words(&output));
}
