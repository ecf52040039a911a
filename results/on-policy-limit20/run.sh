#!/usr/bin/env bash
# Twenty epochs on Gymnasium's hopper under a limit that bites at once, three seeds each: five minutes on two cores.
#   scripts/fetch-mujoco.sh && cargo build --release -p copq-cli --features mujoco && results/on-policy-limit20/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/on-policy-limit20}

for seed in 0 1 2; do
    for method in ppo ppo-lag cppo-pid rcpo cup ppo-saute; do
        echo "$method --seed $seed --out $out/$method-s$seed"
    done
done | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} --task b/hopper --engine mujoco --limit cost=20 --steps 40960 --set window=100 --eval-every 0 2>&1 | tail -n 1"
