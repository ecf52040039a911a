#!/usr/bin/env bash
# The curves and table of results/README.md from the runs here. If the checkpoint is still there, this makes the picture:
#   cargo run --release -- rollout results/hopper-rapier-oac/cholesky-s2 --steps 250 --out results/hopper-rapier-oac/hopper.gif
set -euo pipefail
cd "$(dirname "$0")/../.."
out=results/hopper-rapier-oac
runs=()
for seed in 0 1 2; do runs+=("cholesky=$out/cholesky-s$seed"); done
for projection in eigen extremum diagonal scalarised-min independent-min; do runs+=("$projection=$out/$projection-s0"); done
${COPQ:-cargo run -q --release -p copq-cli --} plot --title "COP-Q on TD3 with OAC, rapier's hopper" \
    --out $out/curves.svg --out $out/curves.png --table $out/table.md "${runs[@]}"
