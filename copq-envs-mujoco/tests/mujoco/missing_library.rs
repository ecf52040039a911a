//! A library that is not there, or not the right one, is an error at run time that says what to do.

use std::process::Command;

use copq_envs::robot::{Preset, hopper};
use copq_envs_mujoco::system;

/// What a process says whose `COPQ_MUJOCO_LIBRARY` is this.
fn answer(library: &str) -> String {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "missing_library::child", "--ignored", "--nocapture"])
        .env("COPQ_MUJOCO_LIBRARY", library)
        .output()
        .unwrap();
    assert!(child.status.success());
    String::from_utf8_lossy(&child.stdout).into_owned()
}

#[test]
fn absent() {
    let said = answer("/nowhere/libmujoco.so");
    let words = match system::header() {
        Some(_) => ["was not found", "/nowhere/libmujoco.so", "COPQ_MUJOCO_LIBRARY"],
        None => ["built without MuJoCo's headers", "build again", "COPQ_MUJOCO_DIR"],
    };
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
    assert!(said.contains("apt-get install libmujoco-dev"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn another_library() {
    let said = answer("libm.so.6");
    assert!(said.contains("mj_version") || system::header().is_none(), "{said}");
}

#[test]
#[ignore = "the process that answers"]
fn child() {
    println!("{}", system::physics(&hopper(Preset::GymV5)).unwrap_err());
}
