#!/usr/bin/env bash
# The default beside clipped double-Q on MuJoCo's hopper and walker2d, three seeds each.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec cargo run --release --features mujoco -- sweep run experiments/default.toml
