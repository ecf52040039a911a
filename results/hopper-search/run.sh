#!/usr/bin/env bash
# What makes COP-Q on TD3 leave the hopper's plateau: single runs that chose the settings of cop-td3 (DESIGN.md, "The preset to begin with").
# Several of ours were stopped early: evaluations.csv shows where. About six hours on two cores without AVX-512.
#   scripts/fetch-mujoco.sh && cargo build --release --features mujoco -p copq-cli && results/hopper-search/run.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-search}
# Today's preset with the noise of the time; config.toml has the original commands, which started from a different preset.
near="cop-td3 --set discount=0.99"
old="$near --set exploration_std=0.1"
raw="--set normalise=false --set networks.init=torch"
famo="--set famo.lr=0.025 --set famo.decay=l2"

runs() {
    echo "$old $raw $famo --engine mujoco --preset paper --steps 150000 --seed 1 --out $out/mujoco-l2-s1"
    echo "$old $famo --engine mujoco --preset paper --steps 150000 --seed 1 --out $out/mujoco-l2-norm-s1"
    echo "$old $famo --steps 100000 --seed 0 --out $out/l2-norm-s0"
    echo "$old --steps 100000 --seed 0 --out $out/norm-s0"
    echo "$old --set networks.critic_lr=1e-3 --set networks.actor_lr=1e-3 --steps 100000 --seed 0 --out $out/norm-lr3-s0"
    echo "$old --set pessimism=0.5 --set actor_pessimism=0.5 --steps 60000 --seed 10 --out $out/norm-pessimism05-s10"
    echo "cop-td3-oac --set optimism.shift=2 --set normalise=true --set networks.init=lecun --set famo=none --steps 60000 --seed 10 --out $out/norm-oac2-s10"
    echo "$near --steps 100000 --seed 0 --out $out/norm-noise03-s0"
    echo "$near --steps 60000 --seed 10 --out $out/norm-noise03-s10"
    echo "$near --steps 100000 --seed 11 --out $out/norm-noise03-s11"
    echo "cop-td3 --steps 100000 --seed 10 --out $out/norm-noise03-g995-s10"
    echo "cop-td3 --steps 100000 --seed 11 --out $out/norm-noise03-g995-s11"
    echo "$near --set tau=0.02 --steps 100000 --seed 10 --out $out/norm-noise03-tau02-s10"
    echo "cop-td3 --set tau=0.02 --steps 100000 --seed 10 --out $out/norm-noise03-tau02-g995-s10"
    oac="cop-td3-oac --set famo=none --set normalise=true --set networks.init=lecun --steps 100000"
    far="--set discount=0.995"
    until="--set optimism.until=50000"
    echo "$oac --seed 10 --out $out/norm-oac-s10"
    for seed in 10 11; do
        echo "$oac $far --seed $seed --out $out/norm-oac-g995-s$seed"
        echo "$oac $far $until --seed $seed --out $out/norm-oac-g995-until50k-s$seed"
        echo "$oac $far $until --set exploration_std=0.3 --set optimism.shift=2.3 --seed $seed --out $out/norm-oac03-g995-until50k-s$seed"
    done
}

runs | xargs -P 2 -I {} bash -o pipefail -c "$copq train {} 2>&1 | tail -n 3"
