#!/usr/bin/env bash
# Runs the job templates of the guide by openjd-cli of PyPI: four frames, and one picture in crops and in passes.
# Crops are pasted by oiiotool of OpenImageIO, a part is rendered again alone, and a task is cancelled and goes on.
#
#     apt-get install python3-venv openimageio-tools
#     tests/check/farm.sh [--quick]
#
# With --quick no task is cancelled. FOGBOW may name the program; else it is built.
set -euo pipefail
case ${1:-} in
    "" | --quick) ;;
    *) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" >&2; exit 2 ;;
esac
root=$(cd "$(dirname "$0")/../.." && pwd)
for program in oiiotool idiff python3; do
    command -v "$program" > /dev/null || { echo "farm.sh: needs $program; install it" >&2; exit 2; }
done
if [ -z "${FOGBOW:-}" ]; then
    cargo build --manifest-path "$root/Cargo.toml"
    FOGBOW=${CARGO_TARGET_DIR:-$root/target}/debug/fogbow
fi
templates=$root/src/guide/farm
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
FOGBOW=$(realpath "$FOGBOW")
cd "$work"

title() { printf '\n== %s\n' "$1"; }
fail() { echo "farm.sh: $1" >&2; exit 1; }
# The number at the end of what oiiotool tells of an attribute.
attribute() { oiiotool --info -v "$1" | sed -n "s/^ *fogbow:$2: \"*\([^\"]*\)\"*$/\1/p"; }
same_pixels() { idiff -q -a -fail 0 -warn 0 "$1" "$2" || fail "$1 and $2 have other pixels"; }
same_bytes() { cmp "$1" "$2" || fail "$1 and $2 have other bytes"; }
# Runs a template with 2 cores a task.
run() { openjd run "$@" -p Cores=2 > log 2>&1 || { cat log >&2; fail "openjd run $*"; }; }

title "openjd-cli"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet 'openjd-cli==0.8.*'
mkdir "$work/bin"
ln -s "$FOGBOW" "$work/bin/fogbow"
export PATH=$work/bin:$work/venv/bin:$PATH
for template in "$templates"/*.yaml; do openjd check "$template"; done

title "frames"
cp "$root/volumes/smoke.toml" "$root/volumes/smoke.vdb" .
for frame in 1 2 3 4; do cp "$root/volumes/smoke.vdb" "smoke_000$frame.vdb"; done
sed 's/smoke\.vdb/smoke_####.vdb/' smoke.toml > frames.toml
flags="--size 48x32 --rays 4 --photons 10000"
fogbow render frames.toml --frames 1-4 -o alone.####.exr $flags --quiet > /dev/null
run "$templates/frames.yaml" --step Frames -p Scene=frames.toml -p Frames=1-4 -p Chunk=2 -p Output=out.####.exr -p Flags="$flags"
grep -q 'openjd_progress: 100' log || fail "frames told no progress"
for frame in 1 2 3 4; do same_bytes "alone.000$frame.exr" "out.000$frame.exr"; done

title "crops"
flags="--rays 4 --photons 20000"
fogbow render smoke.toml -o whole.exr --size 96x64 $flags --quiet > /dev/null
crops=(-p Scene=smoke.toml -p Output=out.exr -p Width=96 -p Height=64 -p Crops=4 -p Flags="$flags")
run "$templates/crops.yaml" --step Merge --run-dependencies "${crops[@]}"
same_pixels whole.exr out.exr
[ "$(attribute out.exr work:photon_paths)" = 0 ] || fail "crops shot photons"
[ "$(attribute whole.exr work:photon_paths)" = 20000 ] || fail "the whole shot none"

title "crops pasted by oiiotool"
oiiotool out.crop3.exr out.crop1.exr out.crop4.exr out.crop2.exr --paste:all=1:mergeroi=1 - -o pasted.exr
# Parts have all layers, the whole has those of one value in its header.
layers="$(oiiotool --info -v out.exr | sed -n 's/^ *channel list: //p' | tr -d ' ')"
oiiotool pasted.exr --ch "$layers" -o pasted.exr
same_pixels pasted.exr out.exr

title "a part that failed"
mv out.exr first.exr
rm out.crop3.exr
if fogbow merge out.crop{1,2,4}.exr -o out.exr 2> told; then fail "a crop is missing"; fi
grep -q 'render --crop 0,32,96x16' told || fail "the merge does not name the missing crop: $(cat told)"
[ ! -e out.exr ] || fail "a merge of some crops left a picture"
run "$templates/crops.yaml" --step Crops --no-run-dependencies -tp Crop=3 "${crops[@]}"
run "$templates/crops.yaml" --step Merge --no-run-dependencies "${crops[@]}"
same_bytes first.exr out.exr

title "passes"
passes=(-p Scene=smoke.toml -p Output=mean.exr -p Passes=4 -p Flags="--size 96x64 $flags")
run "$templates/passes.yaml" --step Merge --run-dependencies "${passes[@]}"
[ "$(attribute mean.exr work:rays)" = "$(attribute whole.exr work:rays)" ] || fail "passes have other rays"
[ "$(attribute mean.exr work:photon_paths)" = 0 ] || fail "passes shot photons"
# The same rays read the same photons: only the cells that they fill have noise of their own.
mean() { oiiotool --stats "$1" | sed -n 's/^ *Stats Avg: //p'; }
python3 - "$(mean whole.exr)" "$(mean mean.exr)" << 'CHECK'
import sys
whole, passes = ([float(x) for x in text.split()[:3]] for text in sys.argv[1:])
print("mean of R, G, B of the whole", whole, "and of passes", passes)
assert all(abs(p / w - 1) < 0.01 for w, p in zip(whole, passes))
CHECK

if [ "${1:-}" = --quick ]; then
    title "all is as it should be"
    exit
fi

title "a task that is cancelled"
long=(-p Scene=smoke.toml -p Output=long.exr -p Passes=2 -p Flags="--size 96x64 --rays 400 --photons 20000" -p Cores=2)
fogbow render smoke.toml --photons-to long.fog --size 96x64 --rays 400 --photons 20000 --quiet > /dev/null
fogbow render smoke.toml -o undisturbed.exr --size 96x64 --rays 400 --photons 20000 --pass 1/2 --photons-from long.fog --quiet > /dev/null
openjd run "$templates/passes.yaml" --step Passes --no-run-dependencies -tp Pass=1 "${long[@]}" > log 2>&1 &
task=$!
for _ in $(seq 100); do
    if grep -q openjd_status log; then break; fi
    sleep 0.1
done
sleep 2
kill -INT "$task"
if wait "$task"; then fail "the task was not cancelled: it ended before"; fi
[ -e long.pass1.exr.checkpoint ] || { cat log >&2; fail "a cancelled task left no checkpoint"; }
run "$templates/passes.yaml" --step Passes --no-run-dependencies -tp Pass=1 "${long[@]:0:8}"
same_bytes undisturbed.exr long.pass1.exr

title "all is as it should be"
