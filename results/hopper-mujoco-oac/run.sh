#!/usr/bin/env bash
# TD3 with optimistic exploration (OAC, each method towards its own upper bound) on MuJoCo's hopper, preset Paper: three projections with FAMO, and two
# of them without; about seven hours on two cores without AVX-512. Not the paper's main comparison, which explores by noise alone. (config.toml has
# the commands of their day, when --method cop-td3 explored so.)
#   scripts/fetch-mujoco.sh && cargo build --release --features copq-examples/mujoco --example td3
#   results/hopper-mujoco-oac/run.sh && results/plot.sh results/hopper-mujoco-oac "TD3 with OAC on MuJoCo's hopper, preset Paper"
set -euo pipefail
cd "$(dirname "$0")/../.."
td3=${TD3:-target/release/examples/td3}
out=results/hopper-mujoco-oac
famo="--set famo.lr=0.025 --set famo.weight_decay=0.001" # the default of their day, except for separate critics

runs() {
    for seed in 0 1; do
        echo "--projection cholesky --seed $seed --out $out/cholesky-s$seed"
        echo "--projection scalarised-min --seed $seed --out $out/scalarised-min-s$seed"
        echo "--projection independent-min --seed $seed --out $out/independent-min-no-famo-s$seed"
    done
    echo "--projection independent-min $famo --seed 0 --out $out/independent-min-s0"
    echo "--projection cholesky --set famo=none --seed 1 --out $out/cholesky-no-famo-s1"
}

runs | xargs -P 2 -I {} sh -c "$td3 --method cop-td3-oac --engine mujoco --preset paper --steps 300000 {} 2>&1 | tail -n 3"
