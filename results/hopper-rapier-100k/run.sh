#!/usr/bin/env bash
# The README's first command as it was until 30 November 2026: 100,000 steps, five seeds, with the arithmetic of that time (commit 285897f has its tables).
# Today's program gives different runs for the same seeds.
#   cargo build --release -p copq-cli && results/hopper-rapier-100k/run.sh
#   results/plot.sh results/hopper-rapier-100k "cop-td3 on rapier's hopper"
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-rapier-100k}

for seed in 0 1 2 3 4; do
    echo "--seed $seed --steps 100000 --out $out/cop-td3-s$seed"
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} 2>&1 | tail -n 3"
