#!/usr/bin/env bash
# The README's curves and table from the runs here.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=results/hopper-mujoco-paper
runs=()
for run in "$out"/*-s[0-9]; do
    projection=$(basename "${run%-s*}")
    runs+=("$projection=$run")
done
cargo run -q -p copq-experiments --bin copq-plot -- --title "TD3 on MuJoCo's hopper, preset Paper" \
    --out $out/curves.svg --out $out/curves.png --table $out/table.md "${runs[@]}"
