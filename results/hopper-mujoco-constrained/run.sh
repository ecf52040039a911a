#!/usr/bin/env bash
# Four methods of SAC under a limit on the cost, on MuJoCo's hopper as in the paper (preset Paper); about three hours on two cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features mujoco -p copq-cli
#   results/hopper-mujoco-constrained/run.sh
#   results/plot.sh results/hopper-mujoco-constrained "SAC under a cost's limit, MuJoCo's hopper, preset Paper" --limit cost=740.2
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-mujoco-constrained}

printf '%s\n' cop-cal cal saclag-ucb sac-lagrangian | xargs -P 2 -I {} bash -o pipefail -c \
    "$copq train {} --engine mujoco --preset paper --steps 200000 --seed 0 --out $out/{}-s0 2>&1 | tail -n 3"
