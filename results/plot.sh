#!/usr/bin/env bash
# Curves and table of the runs in a folder, each named LABEL-sSEED: results/plot.sh FOLDER TITLE [OPTIONS OF copq plot]
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1%/} title=$2
shift 2
runs=()
for run in "$out"/*-s[0-9]*; do
    test -d "$run" || continue
    label=$(basename "${run%-s*}")
    runs+=("$label=$run")
done
${COPQ:-cargo run -q --release -p copq-cli --} plot --title "$title" "$@" \
    --out "$out/curves.svg" --out "$out/curves.png" --table "$out/table.md" "${runs[@]}"
