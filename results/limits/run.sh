#!/usr/bin/env bash
# The paper's constrained off-policy methods on MuJoCo's hopper under its velocity limit, three seeds of 500,000 steps, two at a time:
# and COP-Q on CAL again with c = 0.1 in place of CAL's 10: some ten hours on two cores. So far three seeds of COP-Q on CAL, two of it
# with c = 0.1 and one of each of the others are here.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/limits/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/limits}

for seed in 0 1 2; do
    for method in cop-cal cal saclag-ucb; do echo "$method --seed $seed --out $out/$method-s$seed"; done
    echo "cop-cal --set constraint.lagrangian.augmentation=0.1 --seed $seed --out $out/cop-cal-c0.1-s$seed"
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} --task b/hopper --engine mujoco --preset paper --steps 500000 2>&1 | tail -n 3"
