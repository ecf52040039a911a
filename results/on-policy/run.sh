#!/usr/bin/env bash
# The paper's on-policy rivals under a limit, three seeds of 1,024,000 steps each, two at a time: about half an hour on two quiet cores.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/on-policy/run.sh
#   results/plot.sh results/on-policy "On-policy methods on MuJoCo's hopper (paper), a velocity cost under 740.2" --limit cost=740.2
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/on-policy}

for seed in 0 1 2; do
    for method in cppo-pid rcpo cup ppo-saute; do
        echo "$method --seed $seed --out $out/$method-s$seed"
    done
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} --task b/hopper --engine mujoco --preset paper 2>&1 | tail -n 3"
