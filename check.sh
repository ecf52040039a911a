#!/usr/bin/env bash
# Everything that must hold before a change lands, cheapest first. Needs Rust, a C compiler, python3 with pip and venv, crates.io and PyPI.
# `./check.sh quick` is for use between edits: no MuJoCo, no documentation, and only the tests that train little.
set -euo pipefail
cd "$(dirname "$0")"
export CARGO_TARGET_DIR=$PWD/target

run() {
    printf '\n== %s\n' "$*"
    local began=$SECONDS
    "$@"
    printf '== %s s\n' $((SECONDS - began))
}
# The MuJoCo 3.17.0 engine and its renderer, in every crate that can have them.
mujoco=copq-envs-mujoco/render,copq-tests/mujoco-rs,copq-cli/render,copq-bench/mujoco

run cargo fmt --all --check
# tests/foreign has its own lock file, as a user's workspace would. It is run last.
cargo metadata --locked --format-version 1 --manifest-path tests/foreign/Cargo.toml > /dev/null
run cargo clippy --workspace --all-targets --locked -- -D warnings
if test "${1:-}" = quick; then
    # As part of the workspace, so that nothing is compiled twice.
    run cargo test --workspace --lib --test all --test animation --locked
    printf '\nquick checks passed\n'
    exit
fi
RUSTDOCFLAGS="-D warnings" run cargo doc --workspace --no-deps --locked
run scripts/fetch-mujoco.sh
run scripts/python-worlds.sh
run cargo clippy --workspace --all-targets --features "$mujoco",copq-envs-mujoco/system --locked -- -D warnings
run scripts/check-packages.sh
run cargo test --workspace --features "$mujoco" --locked

# The README's training command, cut short: a real robot, real networks, and every file of a run folder. The tests have built the program.
copq=target/debug/copq
smoke=$(mktemp -d)
trap 'rm -rf "$smoke"' EXIT
run $copq train \
    --steps 600 --set start_steps=300 --eval-every 300 --eval-episodes 2 --out "$smoke/run"
for file in config.toml metrics.csv evaluations.csv timings.csv curve.svg curve.png checkpoint.safetensors; do
    test -s "$smoke/run/$file" || { echo "the run folder has no $file" >&2; exit 1; }
done

# The bits of two methods, which cover most of an update. The other lines of scripts/bits.txt take a quarter of an hour.
run scripts/bits.sh $copq ' cop-cal .*rapier\| cop-td3-oac .*rapier'

# The run's policy evaluated, exported and filmed, and the paper's hopper on MuJoCo.
run $copq evaluate "$smoke/run" --episodes 2
run $copq export "$smoke/run"
test -s "$smoke/run/policy.safetensors"
run $copq rollout "$smoke/run" --out "$smoke/rollout.gif" --png "$smoke/frames"
test -s "$smoke/rollout.gif"
test -s "$smoke/frames/frame-00000.png"
if PATH="$PATH:/sbin" ldconfig -p 2> /dev/null | grep 'libEGL\.so\.1' > /dev/null; then
    run $copq rollout "$smoke/run" --steps 20 --view mujoco --out "$smoke/mujoco.gif"
    test -s "$smoke/mujoco.gif"
else
    printf '\n!! SKIPPED: feature `render` of copq-envs-mujoco, for there is no EGL (Debian: apt-get install libegl1 libgl1-mesa-dri)\n'
fi
run $copq train --engine mujoco --preset paper \
    --steps 400 --set start_steps=300 --eval-every 400 --eval-episodes 2 --out "$smoke/mujoco"

# The report's page in a browser, and a sweep on a private cluster, where these are installed.
run python3 scripts/page-test.py $copq
run scripts/slurm-test.sh $copq

# A few killed runs and a few disk faults; the whole of scripts/torture.sh takes more than an hour.
run scripts/torture.sh $copq 6

# The other way to MuJoCo, against whatever is installed. It runs separately, because one process should hold one MuJoCo.
if exports=$(scripts/system-mujoco.sh); then
    eval "$exports"
    run cargo test --workspace --features copq-envs-mujoco/system,copq-tests/system --locked \
        --lib --test engines --test mujoco
else
    printf '\n!! SKIPPED: feature `system` of copq-envs-mujoco, for there is no MuJoCo to test it on\n'
fi

# A crate outside the workspace trains with its own projection, environment and networks.
run cargo run --locked --manifest-path tests/foreign/Cargo.toml --target-dir target
printf '\nall checks passed\n'
