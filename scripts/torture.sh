#!/usr/bin/env bash
# Kills runs, makes their disk fail and damages their checkpoints, then resumes each run. It must end with exactly the bytes of a
# run that nothing happened to, or say what is damaged. Silence, a panic or an abort is a failure. Needs Linux and a C compiler.
#
#     scripts/torture.sh target/release/copq        # 1,000 kills, five kinds of fault at every write of a run, 300 damages
#     scripts/torture.sh target/release/copq 20     # 20 kills, every 40th write, 6 damages
#
# Three methods take turns. The script prints a tally. Runs that failed stay in the folder that it names.
set -euo pipefail
program=$(realpath "${1:?which program, such as target/release/copq}")
kills=${2:-1000}
export RUST_BACKTRACE=0
scripts=$(realpath "$(dirname "$0")")
work=$(realpath "$(mktemp -d)")
case $work in *[[:space:]:]*) echo "$work: a preloaded library needs a TMPDIR without spaces and colons" >&2; exit 2 ;; esac
cc -shared -fPIC -O1 -o "$work/faults.so" "$scripts/faults.c" -ldl

methods=("cop-td3" "sac --task b/hopper" "redq --set updates_per_step=2")
tiny="--steps 130 --eval-every 50 --eval-episodes 1 --log-every 20 --checkpoint-every 30
    --set networks.hidden=[8,8] --set batch=8 --set start_steps=40"
declare -A tally

# The files that must not depend on how a run was interrupted.
bytes() { (cd "$1" && cat metrics.csv evaluations.csv checkpoint.safetensors policy.safetensors policy-best.safetensors | sha256sum); }

count() { tally[$1]=$((${tally[$1]:-0} + 1)); }

failures=0
failed() { # what, folder
    count "FAILED: $1"
    failures=$((failures + 1))
    echo "FAILED ($1): $2" >&2
}

train() { # method's number, folder
    # shellcheck disable=SC2086 # several arguments
    "$program" train ${methods[$1]} $tiny --out "$2"
}

# Resumes a run that something happened to, and compares it with the uninterrupted one.
verdict() { # what happened, method's number, folder
    local what=$1 method=$2 run=$3
    if grep -q 'panicked' "$run.log"; then failed "$what: panic" "$run"; return; fi
    local code=0
    if test -f "$run/config.toml"; then
        "$program" resume "$run" > "$run.again" 2>&1 || code=$?
    else
        train "$method" "$run" > "$run.again" 2>&1 || code=$?
    fi
    if grep -q 'panicked' "$run.again" || test "$code" -gt 1; then
        failed "$what: panic or abort on resume" "$run"
    elif test "$code" = 1; then
        # Only what was damaged from outside may be lost. Then the run must say so, and must not have believed it.
        if test "$what" = damage && grep -q 'checkpoint.safetensors' "$run.again"; then
            count "$what: told"; rm -rf "$run" "$run".*
        else
            failed "$what: an error on resume" "$run"
        fi
    elif test "$(bytes "$run")" = "${whole[$method]}"; then
        count "$what: same bytes"; rm -rf "$run" "$run".*
    else
        failed "$what: other bytes, in silence" "$run"
    fi
}

whole=()
for method in 0 1 2; do
    began=$(date +%s%N)
    train "$method" "$work/whole$method" > "$work/whole$method.log" 2>&1
    milliseconds[method]=$((($(date +%s%N) - began) / 1000000))
    whole[method]=$(bytes "$work/whole$method")
done

for ((i = 0; i < kills; i++)); do
    method=$((i % 3)) run=$work/kill$i
    : > "$run.log"
    # shellcheck disable=SC2086 # several arguments; not through the function train, whose shell would be killed instead
    "$program" train ${methods[$method]} $tiny --out "$run" > "$run.log" 2>&1 &
    child=$!
    sleep "$(printf '0.%03d' $((RANDOM % (milliseconds[method] > 999 ? 999 : milliseconds[method]))))"
    kill -9 "$child" 2> /dev/null || true
    wait "$child" 2> /dev/null || true
    verdict kill "$method" "$run"
done

stride=$((kills >= 800 ? 1 : 800 / (kills > 0 ? kills : 1)))
for kind in enospc eio short torn rename; do
    for ((at = 1; ; at += stride)); do
        method=$((at % 3)) run=$work/$kind$at code=0
        FAULT_DIR=$run FAULT_AT=$at FAULT_KIND=$kind LD_PRELOAD=$work/faults.so train "$method" "$run" > "$run.log" 2>&1 || code=$?
        # A signal other than the one that ends a torn process.
        if test "$code" -gt 1 -a "$code" != 137; then failed "$kind: abort" "$run"; continue; fi
        # The run ended before this write, or the fault did no harm.
        if test "$code" = 0 && test "$(bytes "$run")" = "${whole[$method]}"; then
            count "$kind: past the end or no harm"
            rm -rf "$run" "$run".*
            if test $((past = ${past:-0} + 1)) -ge 12; then past=0; break; fi
            continue
        fi
        past=0
        verdict "$kind" "$method" "$run"
    done
done
# A full disk makes any write fail. If none failed, the library was not loaded.
test -n "${tally[enospc: same bytes]:-}" || failed "no write has failed" "$work"

for ((i = 0; i < kills * 3 / 10; i++)); do
    method=$((i % 3)) run=$work/damage$i
    cp -r "$work/whole$method" "$run"
    : > "$run.log"
    size=$(stat -c %s "$run/checkpoint.safetensors")
    at=$(((RANDOM * 32768 + RANDOM) % size))
    printf "$(printf '\\%03o' $((RANDOM % 256)))" | dd of="$run/checkpoint.safetensors" bs=1 seek="$at" conv=notrunc status=none
    verdict damage "$method" "$run"
done

printf '\n'
for what in "${!tally[@]}"; do printf '%6d  %s\n' "${tally[$what]}" "$what"; done | sort -k 2
if test "$failures" -gt 0; then
    echo "what failed is in $work"
    exit 1
fi
rm -rf "$work"
