//! Lets the program find the linked MuJoCo when it is started without cargo.

const MUJOCO: &str = "MUJOCO_DYNAMIC_LINK_DIR";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={MUJOCO}");
    // Where this build has put it, and where it was: a build's folder may be gone once the program
    // is installed.
    let built = std::env::var("DEP_COPQ_MUJOCO_LIB_DIR").ok();
    let own = std::env::var(MUJOCO).ok().filter(|_| built.is_some());
    for folder in built.into_iter().chain(own) {
        println!("cargo::rustc-link-arg-bins=-Wl,-rpath,{folder}");
    }
}
