#!/usr/bin/env bash
# Figure 6 and Table E.3 from the runs that lie here.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec cargo run --release --features mujoco -- sweep report experiments/figure-6.toml --from results --parts results/figure-6
