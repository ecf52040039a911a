//! Prints the hopper as MJCF: `cargo run -p copq-envs --example mjcf > hopper.xml`.

fn main() {
    print!("{}", copq_envs::robot::hopper().mjcf(3017000));
}
