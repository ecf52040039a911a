#!/usr/bin/env bash
# REDQ, and REDQ with optimistic exploration (COP-OAC), on MuJoCo's hopper as in the paper (preset Paper); about two and a half hours on two cores
# without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features copq-examples/mujoco --example redq
#   results/hopper-mujoco-redq/run.sh && results/plot.sh results/hopper-mujoco-redq "REDQ on MuJoCo's hopper, preset Paper"
set -euo pipefail
cd "$(dirname "$0")/../.."
redq=${REDQ:-target/release/examples/redq}
out=results/hopper-mujoco-redq

printf '%s\n' "--gaussian --out $out/redq-s0" "--out $out/redq-cop-oac-s0" | xargs -P 2 -I {} sh -c \
    "$redq --engine mujoco --preset paper --steps 20000 --eval-every 1000 --seed 0 {} 2>&1 | tail -n 3"
