#!/usr/bin/env bash
# The README's first command, `copq train`, five seeds, two at a time: about 80 minutes on two cores without AVX-512.
#   cargo build --release -p copq-cli && results/hopper-rapier/run.sh
#   results/plot.sh results/hopper-rapier "cop-td3 on rapier's hopper"
# The picture is, where the checkpoint still is,
#   cargo run --release -- rollout results/hopper-rapier/cop-td3-s1 --steps 250 --out results/hopper-rapier/hopper.gif
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=results/hopper-rapier

for seed in 0 1 2 3 4; do
    echo "--seed $seed --out $out/cop-td3-s$seed"
done | xargs -P 2 -I {} sh -c "$copq train {} 2>&1 | tail -n 3"
