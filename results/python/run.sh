#!/usr/bin/env bash
# Environments of Python's, two seeds each: about two hours of two cores.
set -euo pipefail
cd "$(dirname "$0")/../.."
scripts/python-worlds.sh
cargo run --release -- sweep run experiments/python.toml
exec cargo run --release -- sweep report experiments/python.toml
