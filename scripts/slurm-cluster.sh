#!/usr/bin/env bash
# A private Slurm cluster of two nodes on this machine: no systemd, nothing in /etc, loopback only. For tests, and for trying `copq sweep
# submit` before using a real one. Needs slurmctld, slurmd, munged (Debian: apt-get install slurm-wlm munge).
#   scripts/slurm-cluster.sh up DIR; export SLURM_CONF=DIR/slurm.conf; sinfo; ...; scripts/slurm-cluster.sh down DIR
# `node DIR n1` and `controller DIR` restart one part of it.
set -euo pipefail
usage() { echo "usage: $0 up|down|controller DIR, or $0 node DIR n1|n2" >&2; exit 2; }
test $# -ge 2 || usage
dir=$(realpath -m "$2")
export SLURM_CONF=$dir/slurm.conf
PATH="$PATH:/usr/sbin:/sbin"

write_config() {
    local host user
    host=$(hostname -s)
    user=$(id -un)
    cat > "$SLURM_CONF" << EOF
ClusterName=copq
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
# Without an early end of credentials every requeued job waits for two minutes.
AuthInfo=socket=$dir/munge/sock,cred_expire=5
CredType=cred/munge
StateSaveLocation=$dir/controller
SlurmdSpoolDir=$dir/spool/%n
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/%n.pid
SlurmctldLogFile=$dir/log/slurmctld.log
SlurmdLogFile=$dir/log/%n.log
SlurmctldPort=16817
SlurmdPort=16818
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/linux
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc=$dir/jobs.txt
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=2,batch_sched_delay=0
ReturnToService=2
MinJobAge=300
InactiveLimit=0
KillWait=10
SlurmdTimeout=15
NodeName=n[1-2] NodeHostname=$host NodeAddr=127.0.0.1 Port=[16821-16822] CPUs=1 RealMemory=4000 State=UNKNOWN
PartitionName=main Nodes=n[1-2] Default=YES MaxTime=INFINITE State=UP
EOF
}

up() {
    umask 022
    mkdir -p "$dir"/{controller,spool/n1,spool/n2,log,munge}
    chmod 755 "$dir" "$dir/munge"
    if ! test -f "$dir/munge/key"; then
        dd if=/dev/urandom of="$dir/munge/key" bs=1 count=1024 status=none
        chmod 400 "$dir/munge/key"
    fi
    munged --key-file="$dir/munge/key" --socket="$dir/munge/sock" --pid-file="$dir/munge/pid" \
        --log-file="$dir/munge/log" --seed-file="$dir/munge/seed" --num-threads=2
    write_config
    controller
    node n1
    node n2
    for _ in $(seq 100); do
        test "$(sinfo -h -N -o %t 2> /dev/null | grep -c idle)" = 2 && return
        sleep 0.1
    done
    echo "the cluster does not come up; $dir/log says why" >&2
    exit 1
}

controller() { slurmctld -f "$SLURM_CONF"; }
node() { slurmd -f "$SLURM_CONF" -N "$1"; }

down() {
    local file
    for file in "$dir"/n1.pid "$dir"/n2.pid "$dir"/slurmctld.pid "$dir"/munge/pid; do
        if test -s "$file"; then kill "$(cat "$file")" 2> /dev/null || true; fi
    done
}

case "$1" in
    up | down | controller) "$1" ;;
    node) test $# = 3 || usage; node "$3" ;;
    *) usage ;;
esac
