#!/usr/bin/env bash
# Renders on a Slurm cluster of one node by the script of the guide: crops behind their photons, of which one is
# requeued and one is killed in mid-frame, passes, and frames. All have the bytes of renders that nothing disturbed.
#
#     apt-get install slurmctld slurmd slurm-client munge openimageio-tools
#     tests/check/slurm.sh
#
# As root. Daemons run from a temporary folder, on ports of their own, and end with the check. FOGBOW may name the
# program; else it is built.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
[ "$(id -u)" = 0 ] || { echo "slurm.sh: daemons of Slurm are started by root only; use sudo" >&2; exit 2; }
for program in munged mungekey slurmctld slurmd sbatch idiff; do
    command -v "$program" > /dev/null || { echo "slurm.sh: needs $program; install it" >&2; exit 2; }
done
if [ -z "${FOGBOW:-}" ]; then
    cargo build --manifest-path "$root/Cargo.toml"
    FOGBOW=${CARGO_TARGET_DIR:-$root/target}/debug/fogbow
fi
submit=$root/src/guide/farm/slurm.sh
work=$(mktemp -d)
daemons=()
leave() {
    scancel --user root 2> /dev/null || true
    for daemon in "${daemons[@]}"; do kill "$daemon" 2> /dev/null || true; done
    for daemon in "${daemons[@]}"; do wait "$daemon" 2> /dev/null || true; done
    rm -rf "$work"
}
trap leave EXIT
FOGBOW=$(realpath "$FOGBOW")
cd "$work"
chmod 755 "$work"

title() { printf '\n== %s\n' "$1"; }
fail() { echo "slurm.sh: $1" >&2; tail -n 20 ./*.log daemons/*.out >&2 || true; exit 1; }
same_pixels() { idiff -q -a -fail 0 -warn 0 "$1" "$2" || fail "$1 and $2 have other pixels"; }
same_bytes() { cmp "$1" "$2" || fail "$1 and $2 have other bytes"; }
# until SECONDS COMMAND...: waits until the command is true.
until_true() {
    local left=$((10 * $1))
    shift
    until "$@"; do
        left=$((left - 1))
        [ "$left" -gt 0 ] || fail "waited too long for: $*"
        sleep 0.1
    done
}
state() { scontrol show job "$1" 2> /dev/null | sed -n 's/^ *JobState=\([A-Z_]*\).*/\1/p' | head -n 1; }
is() { [ "$(state "$1")" = "$2" ]; }
# renders PICTURE: whether a process of this cluster writes it, whose number goes to the file pid.
renders() {
    local process
    for process in $(pgrep -f "fogbow render .* -o $1( |\$)"); do
        [ "$(readlink "/proc/$process/exe")" = "$work/bin/fogbow" ] && echo "$process" > pid && return
    done
    return 1
}

title "a cluster of one node"
mkdir daemons daemons/state daemons/spool bin
ln "$FOGBOW" bin/fogbow 2> /dev/null || cp "$FOGBOW" bin/fogbow
export PATH=$work/bin:$PATH SLURM_CONF=$work/daemons/slurm.conf
munge=$work/daemons/munge
mungekey --create --keyfile "$munge.key"
munged --foreground --force --key-file="$munge.key" --socket="$munge.socket" --pid-file="$munge.pid" \
    --log-file="$munge.log" --seed-file="$munge.seed" > daemons/munged.out 2>&1 &
daemons+=($!)
# Credentials expire soon, since a task that is requeued waits for that.
cat > "$SLURM_CONF" << CONF
ClusterName=check
SlurmctldHost=localhost
SlurmUser=root
AuthType=auth/munge
CryptoType=crypto/munge
AuthInfo=socket=$munge.socket,cred_expire=5
StateSaveLocation=$work/daemons/state
SlurmdSpoolDir=$work/daemons/spool
SlurmctldPidFile=$work/daemons/slurmctld.pid
SlurmdPidFile=$work/daemons/slurmd.pid
SlurmctldPort=16817
SlurmdPort=16818
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerParameters=batch_sched_delay=0,sched_interval=1
ReturnToService=2
NodeName=localhost CPUs=$(nproc) RealMemory=2000 State=UNKNOWN
PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE State=UP
CONF
until_true 10 test -S "$munge.socket"
slurmctld -D > daemons/slurmctld.out 2>&1 &
daemons+=($!)
slurmd -D -N localhost > daemons/slurmd.out 2>&1 &
daemons+=($!)
is_idle() { [ "$(sinfo --noheader --format=%T 2> /dev/null)" = idle ]; }
until_true 30 is_idle
sinfo
export CORES=1 MEMORY=500M

title "what nothing disturbs"
cp "$root/volumes/smoke.toml" "$root/volumes/smoke.vdb" .
for frame in 1 2 3; do cp "$root/volumes/smoke.vdb" "smoke_000$frame.vdb"; done
sed 's/smoke\.vdb/smoke_####.vdb/' smoke.toml > frames.toml
flags="--size 96x64 --rays 600 --photons 20000"
small="--size 48x32 --rays 4 --photons 10000"
fogbow render smoke.toml -o whole.exr $flags --quiet > /dev/null
fogbow render frames.toml --frames 1-3 -o alone.####.exr $small --quiet > /dev/null
fogbow render smoke.toml --photons-to alone.fog $small --quiet > /dev/null
for pass in 1 2; do
    fogbow render smoke.toml -o "alone.pass$pass.exr" $small --photons-from alone.fog --pass "$pass/2" --quiet > /dev/null
done
fogbow merge alone.pass{1,2}.exr -o alone.exr > /dev/null

title "crops, of which one is requeued and one is killed in mid-frame"
read -r photons crops merge < <("$submit" crops 4 smoke.toml out.exr $flags --checkpoint 500ms)
until_true 60 is "${crops}_1" RUNNING
is "$photons" COMPLETED || fail "crops began before their photons were there"
until_true 60 test -e out.crop1.exr.checkpoint
scontrol requeue "${crops}_1"
until_true 60 test -e out.crop2.exr.checkpoint
until_true 5 renders out.crop2.exr
kill -9 "$(cat pid)"
squeue
until_true 240 is "$merge" COMPLETED
same_pixels whole.exr out.exr
for crop in 1 2; do
    [ "$(scontrol show job "${crops}_$crop" | grep -o 'Restarts=[0-9]*')" = Restarts=1 ] || fail "crop $crop ran once"
done

title "passes"
read -r _ passes merge < <("$submit" passes 2 smoke.toml mean.exr $small)
until_true 120 is "$merge" COMPLETED
same_bytes alone.exr mean.exr

title "frames, one of which is run again alone"
read -r frames < <("$submit" frames 1-3 frames.toml frame.####.exr $small)
for frame in 1 2 3; do until_true 120 is "${frames}_$frame" COMPLETED; done
for frame in 1 2 3; do same_bytes "alone.000$frame.exr" "frame.000$frame.exr"; done
rm frame.0002.exr
scontrol requeue "${frames}_2"
until_true 60 test -e frame.0002.exr
same_bytes alone.0002.exr frame.0002.exr

title "all is as it should be"
