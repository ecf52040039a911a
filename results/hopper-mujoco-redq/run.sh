#!/usr/bin/env bash
# REDQ (10 critics, 20 updates a step) on MuJoCo's hopper as in the paper (preset Paper), exploring by noise alone and towards the critics'
# upper bound (COP-OAC); about four hours on two cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features copq-examples/mujoco --example redq
#   results/hopper-mujoco-redq/run.sh && results/plot.sh results/hopper-mujoco-redq "REDQ on MuJoCo's hopper, preset Paper"
set -euo pipefail
cd "$(dirname "$0")/../.."
redq=${REDQ:-target/release/examples/redq}
out=results/hopper-mujoco-redq
options="--engine mujoco --preset paper --steps 20000 --seed 0 --eval-every 1000 --checkpoint-every 2000"

printf '%s\n' "--out $out/cop-oac-s0" "--gaussian --out $out/noise-s0" |
    xargs -P 2 -I {} sh -c "$redq $options {} 2>&1 | tail -n 3"
