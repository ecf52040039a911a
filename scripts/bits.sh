#!/usr/bin/env bash
# Checks whether a refactoring has kept every bit: trains with each line of scripts/bits.txt for 1,500 steps and compares
# what the run leaves with the line's two checksums.
#
#     cargo build --release                      # with --features mujoco for the lines of that engine
#     scripts/bits.sh target/release/copq        # all lines, about 12 minutes per engine on one core
#     scripts/bits.sh target/release/copq 'cop-td3 .*rapier'
#
# A change that is meant to change bits replaces the lines that it changes, and says so in CHANGELOG.md. --print writes the new lines.
set -euo pipefail
program=$(realpath "${1:?which program, such as target/release/copq}")
pattern=${2:-}
print=${3:-}
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

checksum() { sha256sum | cut -c 1-16; }

different=0
compared=0
while read -r evaluations metrics arguments; do
    run=$work/run
    # shellcheck disable=SC2086 # several arguments
    "$program" train $arguments --steps 1500 --eval-every 500 --eval-episodes 2 --log-every 250 --seed 3 --out "$run" \
        > "$work/log" 2>&1 || { cat "$work/log" >&2; exit 1; }
    now="$(checksum < "$run/evaluations.csv") $(checksum < "$run/metrics.csv")"
    if test "$print" = --print; then
        echo "$now $arguments"
    elif test "$now" = "$evaluations $metrics"; then
        echo "same       $arguments"
    else
        echo "DIFFERENT  $arguments"
        different=$((different + 1))
    fi
    rm -r "$run"
    compared=$((compared + 1))
done < <(grep -e "$pattern" bits.txt)
test "$compared" -gt 0 || { echo "no line of bits.txt matches '$pattern'" >&2; exit 1; }
exit $((different > 0))
