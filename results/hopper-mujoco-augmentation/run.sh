#!/usr/bin/env bash
# COP-Q on CAL with a hundredth of CAL's augmentation, c = 0.1, on MuJoCo's hopper as in the paper (preset Paper): 60,000 steps. Also c = 10 with every
# update logged, to see the estimate's noise (its metrics.csv, ten megabytes, is not kept). Half an hour on two cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features mujoco -p copq-cli
#   results/hopper-mujoco-augmentation/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-mujoco-augmentation}

printf '%s\n' "--steps 60000 --set constraint.lagrangian.augmentation=0.1 --out $out/cop-cal-c0.1-s0" \
    "--steps 45000 --log-every 1 --out runs/cop-cal-c10-every-update" | xargs -P 2 -I {} bash -o pipefail -c \
    "$copq train cop-cal --engine mujoco --preset paper --seed 0 {} 2>&1 | tail -n 3"
