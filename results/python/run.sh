#!/usr/bin/env bash
# Python's environments, two seeds each: about two hours on two cores.
set -euo pipefail
cd "$(dirname "$0")/../.."
scripts/python-worlds.sh
cargo run --release -- sweep run experiments/python.toml
exec cargo run --release -- sweep report experiments/python.toml
