#!/usr/bin/env bash
# The README's first sweep and its page: four to ten minutes on two cores.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo run --release -- sweep run experiments/quick.toml
exec cargo run --release -- sweep report experiments/quick.toml --rollouts
