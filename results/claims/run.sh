#!/usr/bin/env bash
# The paper's claims, judged by the runs that lie here: one table a figure.
set -euo pipefail
cd "$(dirname "$0")/../.."
copq=${COPQ:-cargo run --release --features mujoco --}
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
for figure in 3 4 5 6; do
  $copq sweep report "experiments/figure-$figure.toml" --from results --out "$folder/page.html" --parts "$folder/$figure"
  cp "$folder/$figure/claims.md" "results/claims/figure-$figure.md"
  cp "$folder/$figure/claims.csv" "results/claims/figure-$figure.csv"
done
