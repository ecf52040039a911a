#!/usr/bin/env bash
# The README's first command with five more seeds, which had no part in choosing its number of steps: fifty minutes on two cores
# with AVX-512. (Seeds 5 to 7 began as 100,000-step runs of experiments/precision-rapier.toml and were continued, with the same numbers.
# Seed 8 continued to 115,000; its rows after 110,000 are left out, as its settings say.)
#   cargo build --release -p copq-cli && results/hopper-rapier-fresh/run.sh
#   results/plot.sh results/hopper-rapier-fresh "cop-td3 on rapier's hopper, fresh seeds"
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-rapier-fresh}

for seed in 5 6 7 8 9; do
    echo "--seed $seed --out $out/cop-td3-s$seed"
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} 2>&1 | tail -n 3"
