#!/usr/bin/env bash
# The README's first command, `copq train`, five seeds, two at a time, continued to 150,000 steps: about an hour on two cores with
# AVX-512, two without.
#   cargo build --release -p copq-cli && results/hopper-rapier/run.sh
#   results/plot.sh results/hopper-rapier "cop-td3 on rapier's hopper"
# These runs began as seeds of experiments/precision-rapier.toml and continued to 150,000 steps (`copq resume --steps 150000`, the same numbers).
# Seed 4 continued to 163,000; its rows after 150,000 are left out.
# The film is of the first command itself, seed 0 after 110,000 steps:
#   cargo run --release -- rollout runs/cop-td3-a-hopper-cholesky-s0 --steps 250 --out results/hopper-rapier/hopper.gif
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-rapier}

for seed in 0 1 2 3 4; do
    echo "--seed $seed --steps 150000 --out $out/cop-td3-s$seed"
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} 2>&1 | tail -n 3"
