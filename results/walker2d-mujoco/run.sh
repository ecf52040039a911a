#!/usr/bin/env bash
# The default beside clipped double-Q on MuJoCo's walker2d; three runs of six so far.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec cargo run --release --features mujoco -- sweep run experiments/default.toml
