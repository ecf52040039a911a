#!/usr/bin/env bash
# The default on MuJoCo's hopper and clipped double-Q beside it, three seeds of 300,000 steps, two at a time: about four hours on two
# cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/hopper-mujoco/run.sh
#   results/plot.sh results/hopper-mujoco "cop-td3 on MuJoCo's hopper: its Cholesky bound and clipped double-Q's" --passes 1000
# cop-td3's runs are from 30 November 2026; scalarised-min's are from before sums were added in a different order.
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-mujoco}

for seed in 0 1 2; do
    echo "--seed $seed --out $out/cop-td3-s$seed"
    echo "--bound scalarised-min --seed $seed --out $out/scalarised-min-s$seed"
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train --engine mujoco --steps 300000 {} 2>&1 | tail -n 3"
