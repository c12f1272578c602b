#!/usr/bin/env bash
# Renders a picture or a sequence on a Slurm cluster, whose nodes share a disk:
#
#     farm/slurm.sh crops N SCENE OUT.exr --size WIDTHxHEIGHT [FLAG...]
#     farm/slurm.sh passes N SCENE OUT.exr [FLAG...]
#     farm/slurm.sh frames FIRST-LAST SCENE OUT.####.exr [FLAG...]
#
# Prints the numbers of the jobs: photons, crops or passes, and merge, or frames. FLAGs are those of fogbow render.
# SBATCH_* sets partition, time and the like, as for any job; CORES and MEMORY are those of a task (4 and 4G).
#
# A task that is requeued gets SIGTERM, leaves its picture so far and a checkpoint, and goes on from that, to the same bytes.
# One that is killed is requeued twice. One that failed is run again alone by scontrol requeue JOB_TASK.
set -euo pipefail
usage() { sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2; }
[ $# -ge 4 ] || usage
kind=$1 parts=$2 scene=$3 out=$4
shift 4
cores=${CORES:-4}
stem=${out%.exr}

quoted() { printf '%q ' "$@"; }
render=$(quoted fogbow render "$scene" --threads "$cores" --json --quiet "$@")

# submit NAME COMMAND [OPTION...]: submits a job that runs COMMAND, and prints its number.
submit() {
    local name=$1 command=$2
    shift 2
    sbatch --parsable --requeue --job-name="fogbow-$name" --cpus-per-task="$cores" --mem="${MEMORY:-4G}" \
        --output="$stem.$name.%a.log" --open-mode=append "$@" << SCRIPT
#!/usr/bin/env bash
# Slurm signals fogbow itself; this shell waits for what it leaves.
trap : TERM
task=\${SLURM_ARRAY_TASK_ID:-}
$command
code=\$?
if [ \$code = 137 ] && [ "\${SLURM_RESTART_COUNT:-0}" -lt 2 ]; then
    scontrol requeue "\$SLURM_JOB_ID"
    sleep 60
fi
exit \$code
SCRIPT
}

# Submits the shooting of the photons that all parts read.
photons() { submit photons "$render --photons-to $(quoted "$stem.fog")"; }

# merge JOB: submits the merge of all parts, after JOB.
merge() {
    local files=() number
    for number in $(seq "$parts"); do files+=("$stem.$part$number.exr"); done
    submit merge "$(quoted fogbow merge "${files[@]}" -o "$out" --json)" --dependency="afterok:$1"
}

case $kind in
    crops)
        [[ " $* " =~ " --size "([0-9]+)x([0-9]+)" " ]] || { echo "slurm.sh: crops need --size WIDTHxHEIGHT" >&2; exit 2; }
        width=${BASH_REMATCH[1]} height=${BASH_REMATCH[2]} part=crop
        photons=$(photons)
        crop="top=\$(($height * (task - 1) / $parts))
$render --photons-from $(quoted "$stem.fog") --crop 0,\$top,${width}x\$(($height * task / $parts - top)) \
--resume -o $(printf %q "$stem.crop")\$task.exr"
        crops=$(submit crops "$crop" --array="1-$parts" --dependency="afterok:$photons")
        echo "$photons $crops $(merge "$crops")"
        ;;
    passes)
        part=pass
        photons=$(photons)
        pass="$render --photons-from $(quoted "$stem.fog") --pass \$task/$parts \
--resume -o $(printf %q "$stem.pass")\$task.exr"
        passes=$(submit passes "$pass" --array="1-$parts" --dependency="afterok:$photons")
        echo "$photons $passes $(merge "$passes")"
        ;;
    frames)
        submit frames "$render --frames \$task --resume -o $(quoted "$out")" --array="$parts"
        ;;
    *) usage ;;
esac
