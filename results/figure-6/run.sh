#!/usr/bin/env bash
# Figure 6 and Table E.3 from the runs in results/.
set -euo pipefail
cd "$(dirname "$0")/../.."
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cargo run --release --features mujoco -- sweep report experiments/figure-6.toml --from results --out "$folder/page.html" --parts "$folder"
for name in reward-and-cost.{csv,md,tex} b-hopper-mujoco-paper{,-cost}.svg; do cp "$folder/$name" results/figure-6; done
