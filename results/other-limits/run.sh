#!/usr/bin/env bash
# COP-Q on CAL on MuJoCo's hopper under half its velocity limit and one and a half times that, three seeds of 75,000 steps, two at a time:
# some fifty minutes on two cores. They are compared with the first 75,000 steps of results/limits, under the limit itself.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/other-limits/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/other-limits}

for limit in 370 1110; do
    for seed in 0 1 2; do echo "--limit cost=$limit --seed $seed --out $out/limit$limit-s$seed"; done
done | xargs -P 2 -I {} bash -o pipefail -c \
    "$copq train cop-cal {} --task b/hopper --engine mujoco --preset paper --steps 75000 2>&1 | tail -n 3"
