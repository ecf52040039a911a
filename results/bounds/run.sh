#!/usr/bin/env bash
# Figures 1, 2 and B.1, and the clip over the correlation.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec cargo run --release -- bounds --out results/bounds
