#!/usr/bin/env bash
# SAC under a limit on cost, on MuJoCo's hopper as in the paper (preset Paper), by four methods; about three hours on two cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features copq-examples/mujoco --example sac_lagrangian
#   results/hopper-mujoco-constrained/run.sh
#   results/plot.sh results/hopper-mujoco-constrained "SAC under a cost's limit, MuJoCo's hopper, preset Paper" --limit cost=740.2
set -euo pipefail
cd "$(dirname "$0")/../.."
sac=${SAC:-target/release/examples/sac_lagrangian}
out=results/hopper-mujoco-constrained

printf '%s\n' cop-cal cal saclag-ucb sac-lagrangian | xargs -P 2 -I {} sh -c \
    "$sac --engine mujoco --preset paper --task b/hopper --method {} --steps 200000 --seed 0 --out $out/{}-s0 2>&1 | tail -n 3"
