#!/usr/bin/env bash
# What of the paper's protocol decides early learning on MuJoCo's hopper: eleven arms, three seeds each.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec cargo run --release --features mujoco -- sweep run experiments/protocol.toml
