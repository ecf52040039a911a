#!/usr/bin/env bash
# Figures 1, 2 and B.1, and the clip as the correlation changes.
set -euo pipefail
cd "$(dirname "$0")/../.."
exec cargo run --release -- bounds --out results/bounds
