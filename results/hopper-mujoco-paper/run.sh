#!/usr/bin/env bash
# COP-Q on the paper's hopper in MuJoCo, two seeds at a time; about 45 minutes of two cores' work without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features copq-examples/mujoco --example td3 && results/hopper-mujoco-paper/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
td3=${TD3:-target/release/examples/td3}

for seed in 0 1; do
    echo "--engine mujoco --preset paper --steps 200000 --seed $seed --out results/hopper-mujoco-paper/cholesky-s$seed"
done | xargs -P 2 -I {} sh -c "$td3 {} 2>&1 | tail -n 3"
