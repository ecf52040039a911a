#!/usr/bin/env bash
# The default on rapier's hopper with products in bf16, ten seeds each of `backward` and `careful`: some three hours on two cores of
# an AMD Zen 4. f32's ten seeds are those of results/hopper-rapier and results/hopper-rapier-fresh, which continue after 100,000 steps.
#   cargo build --release -p copq-cli && results/precision-rapier/run.sh
#   results/claims/run.sh compares them
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/precision-rapier}

for seed in 0 1 2 3 4 5 6 7 8 9; do
    for precision in backward careful; do
        echo "--seed $seed --set networks.precision=$precision --out $out/$precision-s$seed"
    done
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train --steps 100000 {} 2>&1 | tail -n 3"
