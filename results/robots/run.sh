#!/usr/bin/env bash
# COP-Q with optimistic exploration (COP-OAC) for 20,000 steps on both engines, for every robot but the hopper, which has longer runs; half an hour on two cores.
# (config.toml has the commands of the time, when td3 explored in this way by default.)
#   scripts/fetch-mujoco.sh && cargo build --release --features mujoco -p copq-cli && results/robots/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}

for robot in ant humanoid halfcheetah walker2d; do
    for engine in rapier mujoco; do
        echo "--engine $engine --robot $robot --steps 20000 --out ${OUT:-results/robots}/$engine-$robot"
    done
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train cop-td3-oac {} 2>&1 | tail -n 3"
