//! The doctor finds what this build has.

use std::process::Command;

#[test]
fn it_says_what_to_do_next() {
    let doctor = Command::new(env!("CARGO_BIN_EXE_mujoco-doctor")).output().unwrap();
    let said = String::from_utf8_lossy(&doctor.stdout);
    let on = [cfg!(feature = "mujoco-rs"), cfg!(feature = "system")];
    for (feature, on) in ["mujoco-rs", "system"].into_iter().zip(on) {
        let wanted = if on { format!("feature {feature}: MuJoCo ") } else { format!("feature {feature}: off") };
        assert!(said.contains(&wanted), "{said}");
    }
    // On a machine without EGL there is something to do.
    if cfg!(feature = "render") && !said.contains("feature render: draws without a window") {
        assert!(said.contains("apt-get install libegl1") && !doctor.status.success(), "{said}");
        return;
    }
    let next = if on == [false; 2] { "--features mujoco-rs" } else { "next: nothing, it works" };
    assert!(said.contains(next), "{said}");
    assert_eq!(doctor.status.success(), on != [false; 2], "{said}");
}
