#!/usr/bin/env bash
# The README's curves and table from the runs here.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=results/hopper-mujoco-constrained
runs=()
for run in "$out"/*-s[0-9]; do
    method=$(basename "${run%-s*}")
    runs+=("$method=$run")
done
cargo run -q -p copq-experiments --bin copq-plot -- --title "SAC under a cost's limit, MuJoCo's hopper, preset Paper" --limit cost=740.2 \
    --out $out/curves.svg --out $out/curves.png --table $out/table.md "${runs[@]}"
