#!/usr/bin/env bash
# TD3 on MuJoCo's hopper as in the paper (preset Paper), under three projections; about five hours on two cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features copq-examples/mujoco --example td3
#   results/hopper-mujoco-paper/run.sh && results/plot.sh results/hopper-mujoco-paper "TD3 on MuJoCo's hopper, preset Paper"
set -euo pipefail
cd "$(dirname "$0")/../.."
td3=${TD3:-target/release/examples/td3}
out=results/hopper-mujoco-paper

for projection in cholesky scalarised-min independent-min; do
    for seed in 0 1; do
        echo "--projection $projection --seed $seed --out $out/$projection-s$seed"
    done
done | xargs -P 2 -I {} sh -c "$td3 --engine mujoco --preset paper --steps 300000 {} 2>&1 | tail -n 3"
