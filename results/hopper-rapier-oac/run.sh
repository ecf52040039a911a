#!/usr/bin/env bash
# COP-Q with optimistic exploration (COP-OAC) and the other projections, each towards its own upper bound, on rapier's
# hopper, two at a time; about two hours of two cores' work without AVX-512. (config.toml has the commands of the time, when td3 explored in this way by default.)
#   cargo build --release -p copq-cli && results/hopper-rapier-oac/run.sh && results/hopper-rapier-oac/plot.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-target/release/copq}
out=${OUT:-results/hopper-rapier-oac}

{
    for seed in 0 1 2; do
        echo "--steps 100000 --seed $seed --out $out/cholesky-s$seed"
    done
    for projection in eigen extremum diagonal scalarised-min; do
        echo "--bound $projection --steps 60000 --out $out/$projection-s0"
    done
    # Made when FAMO was also on for separate critics.
    famo="--set famo.separate=true"
    echo "--bound independent-min $famo --steps 60000 --out $out/independent-min-s0"
} | xargs -P 2 -I {} bash -o pipefail -c "$copq train cop-td3-oac {} 2>&1 | tail -n 3"
