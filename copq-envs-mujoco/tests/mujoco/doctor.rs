//! The doctor finds what this build has.

use copq_envs_mujoco::doctor;

#[test]
fn it_says_what_to_do_next() {
    let report = doctor();
    let said = report.lines.join("\n");
    let on = [cfg!(feature = "mujoco-rs"), cfg!(feature = "system")];
    for (feature, on) in ["mujoco-rs", "system"].into_iter().zip(on) {
        let wanted = if on {
            format!("feature {feature}: MuJoCo ")
        } else {
            format!("feature {feature}: off")
        };
        assert!(said.contains(&wanted), "{said}");
    }
    // On a machine without EGL there is something to do.
    if cfg!(feature = "render") && !said.contains("feature render: draws without a window") {
        assert!(report.next.is_some_and(|next| next.contains("apt-get install libegl1")), "{said}");
    } else if on == [false; 2] {
        assert!(report.next.is_some_and(|next| next.contains("--features mujoco-rs")), "{said}");
    } else {
        assert_eq!(report.next, None, "{said}");
    }
}
