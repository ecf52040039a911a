#!/usr/bin/env bash
# TD3 with optimistic exploration (OAC, each method towards its own upper bound) on MuJoCo's hopper, preset Paper: three projections with FAMO, and two
# of them without; about seven hours on two cores without AVX-512. Not the paper's main comparison, which explores by noise alone. (config.toml has
# the commands of the time, when --method cop-td3 explored in this way.)
#   scripts/fetch-mujoco.sh && cargo build --release --features mujoco -p copq-cli
#   results/hopper-mujoco-oac/run.sh && results/plot.sh results/hopper-mujoco-oac "TD3 with OAC on MuJoCo's hopper, preset Paper"
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-mujoco-oac}
famo="--set famo.separate=true"

runs() {
    for seed in 0 1; do
        echo "--bound cholesky --seed $seed --out $out/cholesky-s$seed"
        echo "--bound scalarised-min --seed $seed --out $out/scalarised-min-s$seed"
        echo "--bound independent-min --seed $seed --out $out/independent-min-no-famo-s$seed"
    done
    echo "--bound independent-min $famo --seed 0 --out $out/independent-min-s0"
    echo "--bound cholesky --set famo=none --seed 1 --out $out/cholesky-no-famo-s1"
}

runs | xargs -P 2 -I {} bash -o pipefail -c "$copq train cop-td3-oac --engine mujoco --preset paper --steps 300000 {} 2>&1 | tail -n 3"
