#!/usr/bin/env bash
# Tests that a sweep on a private Slurm cluster survives what happens on clusters, and ends with the bytes that a single machine leaves.
# There are eight runs: one is warned of its time limit, one is on a node that dies, and one is on a full disk; the controller dies too.
# Takes about three minutes.
#   scripts/slurm-test.sh target/debug/copq
set -euo pipefail
copq=$(realpath "${1:?usage: $0 COPQ}")
cd "$(dirname "$0")/.."
cluster=$PWD/scripts/slurm-cluster.sh
PATH="$PATH:/usr/sbin:/sbin"
for program in slurmctld slurmd munged sbatch; do
    command -v $program > /dev/null || { echo "!! SKIPPED: Slurm, for there is no $program (Debian: apt-get install slurm-wlm munge)"; exit; }
done

work=$(mktemp -d)
chmod 755 "$work" # munge requires it
export SLURM_CONF=$work/slurm/slurm.conf
disk=
clean() {
    timeout 5 scancel --user "$(id -un)" 2> /dev/null || true
    "$cluster" down "$work/slurm" 2> /dev/null || true
    if test "$disk"; then umount "$disk" 2> /dev/null || true; fi
    rm -rf "$work" 2> /dev/null || true
}
trap clean EXIT
fail() {
    echo "slurm-test: $*" >&2
    squeue >&2 || true
    tail -n 2 "$work"/runs/submit/*/logs/* >&2 || true
    exit 1
}
# Waits for a condition, and fails with its name after two minutes.
wait_for() {
    local what=$1
    shift
    for _ in $(seq 1200); do
        if "$@"; then return; fi
        sleep 0.1
    done
    fail "waited in vain for $what"
}
say() { printf '%4d s  %s\n' $SECONDS "$*"; }

cd "$work"
cat > sweep.toml << 'EOF'
out = "runs"

[all]
task = "a/hopper"
steps = 12000
eval-every = 4000
eval-episodes = 1
checkpoint-every = 1000
set = ["networks.hidden=[64,64]", "batch=128", "start_steps=200"]

[grid]
seed = [0, 1, 2, 3, 4, 5, 6, 7]
EOF
folder() { echo "$work/runs/$(basename "$("$copq" sweep plan sweep.toml | awk -v n="$1" '$1 == n { print $2 }')")"; }

"$cluster" up "$work/slurm"
say "two nodes are up"

# A disk of 100 kB for the last run, if one can be mounted.
full=$(folder 7)
mkdir -p "$full"
if mount -t tmpfs -o size=100k tmpfs "$full" 2> /dev/null; then disk=$full; else say "SKIPPED: the full disk, for nothing may be mounted here"; fi

"$copq" sweep submit sweep.toml --time 10:00 --memory 500M
say "submitted"
has_checkpoint() { test -s "$(folder "$1")/checkpoint.safetensors"; }

# The first run is warned of its time limit.
wait_for "a checkpoint of run 0" has_checkpoint 0
say "run 0 has a checkpoint"
job=$(squeue -h -t R -r -o "%A %K" | awk '$2 == 0 { print $1 }')
test "$job" || fail "run 0 ended before it could be told"
# (Without the timeout, scancel would keep asking about a job that has since been requeued.)
timeout 1 scancel --signal=USR1 --batch "$job" || true
say "run 0 is told of its time limit"

# The node of another run dies with all that runs on it.
find_victim() {
    local job number node
    while read -r job number node; do
        if test "$number" != 0 && test "$number" != 7 && has_checkpoint "$number"; then
            victim=$number victim_job=$job victim_node=$node
            return 0
        fi
    done < <(squeue -h -t R -r -o "%A %K %N" | grep ' [0-9]* n')
    return 1
}
wait_for "a run to kill" find_victim
kill -9 "$(cat "$work/slurm/$victim_node.pid")"
pkill -9 -f "slurmstepd: \[$victim_job\." || true
pkill -9 -f "sweep task $work/runs/submit/.*/sweep.toml --task $victim\$" || true
sleep 1
"$cluster" node "$work/slurm" "$victim_node"
say "node $victim_node died under run $victim, and is back"

# The controller dies.
kill -9 "$(cat "$work/slurm/slurmctld.pid")"
sleep 1
"$cluster" controller "$work/slurm"
answers() { squeue > /dev/null 2>&1; }
wait_for "the controller" answers
say "the controller died, and is back"

# Meanwhile, the same runs on this machine alone.
sed 's/"runs"/"local"/' sweep.toml > local.toml
"$copq" sweep run local.toml > local.txt 2>&1 || { cat local.txt >&2; fail "the local runs"; }
say "the local runs are done"
is_empty() { test -z "$(squeue -h)"; }
wait_for "the queue to empty" is_empty

if test "$disk"; then
    "$copq" sweep status sweep.toml | grep -q 'No space left' || fail "the full disk was not told: $("$copq" sweep status sweep.toml)"
    mount -o remount,size=100m "$disk"
    "$copq" sweep submit sweep.toml --time 10:00 --memory 500M | grep '^1 of 8 runs are not done yet' || fail "submitted something else than run 7"
    wait_for "run 7" is_empty
    say "run 7 failed on a full disk, said so, and is done now that there is room"
fi

for number in 0 1 2 3 4 5 6 7; do
    run=$(folder $number)
    test -s "$run/DONE" || fail "run $number is not done: $("$copq" sweep status sweep.toml)"
    for file in metrics.csv evaluations.csv checkpoint.safetensors policy-best.safetensors; do
        cmp "$run/$file" "local/$(basename "$run")/$file" || fail "run $number: another $file than on one machine"
    done
done
for number in 0 "$victim"; do
    test "$(grep -c '^from step' "$(folder "$number")/log.txt")" -ge 2 || fail "run $number had one turn only"
done
test -s runs/report.html || fail "no report"
grep -q '8 runs: 8 done' runs/report.html || fail "the report tells something else"
say "eight runs with the bytes of one machine, and their report"
