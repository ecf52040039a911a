#!/usr/bin/env bash
# Do the learner and the environment reproduce what TD3 is known to learn? Gymnasium's hopper, three seeds of copq's TD3
# and of Stable-Baselines3's (bench/peers/requirements.txt): some four hours on two cores.
set -euo pipefail
cd "$(dirname "$0")/../.."
python=third_party/bench-peers/bin/python # bench/run.py makes it
"$python" -c 'import stable_baselines3'
cargo run --release --features mujoco -- sweep run experiments/anchor.toml
for seed in 0 1 2; do
    "$python" bench/peers/td3_learns.py $seed 300000 results/anchor/sb3-s$seed.csv
done
