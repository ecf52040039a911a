#!/usr/bin/env bash
# Which parts of the paper's protocol decide early learning on MuJoCo's hopper: eleven arms, three seeds each.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec cargo run --release --features mujoco -- sweep run experiments/protocol.toml
