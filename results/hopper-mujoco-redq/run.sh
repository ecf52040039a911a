#!/usr/bin/env bash
# REDQ, and REDQ with optimistic exploration (COP-OAC), on MuJoCo's hopper as in the paper (preset Paper). A second seed, and a run with a seventh of
# the shift, show what holds COP-OAC back (ours were stopped at 14,829 and 16,202 steps). About five hours on two cores without AVX-512.
# (config.toml has the commands of the time, when --oac was the default and --gaussian turned it off.)
#   scripts/fetch-mujoco.sh && cargo build --release --features mujoco -p copq-cli
#   results/hopper-mujoco-redq/run.sh && results/plot.sh results/hopper-mujoco-redq "REDQ on MuJoCo's hopper, preset Paper"
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-mujoco-redq}

runs() {
    echo "redq --seed 0 --out $out/redq-s0"
    echo "redq-oac --seed 0 --out $out/redq-cop-oac-s0"
    echo "redq-oac --seed 1 --out $out/redq-cop-oac-14k-s1"
    echo "redq-oac --set optimism.shift=1 --seed 0 --out $out/redq-cop-oac-shift1-s0"
}

runs | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} --engine mujoco --preset paper --steps 20000 --eval-every 1000 2>&1 | tail -n 3"
