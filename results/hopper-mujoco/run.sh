#!/usr/bin/env bash
# The default on MuJoCo's hopper, three seeds of 300,000 steps, two at a time: about two hours on two cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/hopper-mujoco/run.sh
#   results/plot.sh results/hopper-mujoco "cop-td3 on MuJoCo's hopper"
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=results/hopper-mujoco

for seed in 0 1 2; do
    echo "--seed $seed --out $out/cop-td3-s$seed"
done | xargs -P 2 -I {} sh -c "$copq train --engine mujoco --steps 300000 {} 2>&1 | tail -n 3"
