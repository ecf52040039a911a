#!/usr/bin/env bash
# The default on MuJoCo's hopper before sums were added in a different order (30 November 2026; these runs are from commit 3ff4d95):
# three seeds of 300,000 steps. Today's program gives different runs for the same seeds: results/hopper-mujoco.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/hopper-mujoco-older/run.sh
#   results/plot.sh results/hopper-mujoco-older "cop-td3 on MuJoCo's hopper, older arithmetic"
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-mujoco-older}

for seed in 0 1 2; do
    echo "--seed $seed --out $out/cop-td3-s$seed"
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train --engine mujoco --steps 300000 {} 2>&1 | tail -n 3"
