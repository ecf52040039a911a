#!/usr/bin/env bash
# The paper's constrained off-policy methods on MuJoCo's hopper under its velocity limit, three seeds of 500,000 steps, two at a time:
# some seven hours on two cores. So far the three of COP-Q on CAL and the one of CAL that lie here.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/limits/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/limits}

for method in cop-cal cal saclag-ucb; do
    for seed in 0 1 2; do echo "$method --seed $seed --out $out/$method-s$seed"; done
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} --task b/hopper --engine mujoco --preset paper --steps 500000 2>&1 | tail -n 3"
