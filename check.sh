#!/usr/bin/env bash
# Everything that must hold before a change lands, cheapest first. Needs a Rust toolchain and
# crates.io; for MuJoCo's part also python3 with pip, or an installed MuJoCo: what is skipped is said at the end.
set -euo pipefail
cd "$(dirname "$0")"

run() { printf '\n== %s\n' "$*"; "$@"; }

run cargo fmt --all --check
# First with nothing installed, then with MuJoCo 3.17.0, which a script fetches.
run cargo clippy --workspace --all-targets --locked -- -D warnings
skipped=()
mujoco=()
if run scripts/fetch-mujoco.sh; then
    mujoco=(--features copq-envs-mujoco/mujoco-rs,copq-tests/mujoco-rs,copq-examples/mujoco,copq-bench/mujoco)
    run cargo clippy --workspace "${mujoco[@]}" --all-targets --locked -- -D warnings
else
    skipped+=("mujoco-rs: MuJoCo 3.17.0 could not be fetched")
fi
RUSTDOCFLAGS="-D warnings" run cargo doc --workspace "${mujoco[@]}" --no-deps --locked
run cargo package --workspace --no-verify --allow-dirty --quiet --locked
run cargo test --workspace "${mujoco[@]}" --locked

# The README's training command, cut short: a real robot, real networks, every file of a run folder.
smoke=$(mktemp -d)
trap 'rm -rf "$smoke"' EXIT
run cargo run --locked --example td3 -- --steps 600 --start-steps 300 --eval-every 300 --eval-episodes 2 --out "$smoke/run"
for file in config.toml metrics.csv evaluations.csv timings.csv curve.svg curve.png checkpoint.safetensors; do
    test -s "$smoke/run/$file" || { echo "the run folder has no $file" >&2; exit 1; }
done

# Its policy in pictures.
run cargo run --locked --example rollout -- "$smoke/run" --out "$smoke/rollout.gif" --png "$smoke/frames"
test -s "$smoke/rollout.gif" && test -s "$smoke/frames/frame-00000.png"

if test ${#mujoco[@]} -gt 0; then
    run cargo run --locked "${mujoco[@]}" --example td3 -- --engine mujoco --preset paper \
        --steps 400 --start-steps 300 --eval-every 400 --eval-episodes 2 --out "$smoke/mujoco"
fi

# The MuJoCo that is installed, by itself: one process should hold one MuJoCo.
if exports=$(scripts/system-mujoco.sh); then
    eval "$exports"
    run cargo clippy -p copq-envs-mujoco --all-targets --features system --locked -- -D warnings
    run cargo test -p copq-envs-mujoco --features system --locked
    run cargo test -p copq-tests --features system --test engines --locked
else
    skipped+=("system: no MuJoCo is installed (Debian: apt-get install libmujoco-dev)")
fi

# A crate outside the workspace writes its own projection and trains with it, in under 40 lines.
test "$(wc -l < tests/foreign/src/main.rs)" -lt 40
run cargo run --locked --manifest-path tests/foreign/Cargo.toml --target-dir target/foreign
printf '\nall checks passed\n'
for what in "${skipped[@]}"; do printf 'SKIPPED %s\n' "$what"; done
