#!/usr/bin/env bash
# Compares two builds of fogbow on the scenes of the measurement `strategy` and on a flight into a cloud:
# processor seconds, peak of memory, and whether the pictures are equal within noise.
#
#     apt-get install time
#     tests/check/before.sh OLD_BINARY NEW_BINARY [WORDS_OF_SCENES ...]
#
# The builds take turns, RUNS times (5), each time with seeds of their own. Told are medians of user and
# system seconds and of the peak of resident memory with their ratios; noise, the ratio of the variances of
# pictures, by the relative squared differences between successive seeds without the worst pixels; cost, that ratio
# times that of the seconds: below 1 the new build has the same noise sooner; and z: the mean over the runs of
# how much brighter the new picture is, over its standard error. Of Student's distribution with 4 degrees
# of freedom 1 % lies beyond 4.6.
set -euo pipefail
[ $# -ge 2 ] || { echo "before.sh: wants OLD_BINARY NEW_BINARY" >&2; exit 2; }
old=$(realpath "$1")
new=$(realpath "$2")
shift 2
runs=${RUNS:-5}
cd "$(dirname "$0")/../.."
[ -x /usr/bin/time ] || { echo "before.sh: needs time; install it" >&2; exit 2; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cargo bench --quiet --bench results -- --scenes "$work/scenes"

# render BINARY SEED NAME SCENE: a picture NAME.exr, and a line of seconds and kilobytes in NAME.spent.
render() {
    /usr/bin/time --quiet -f "%U %S %M" -o "$work/spent" \
        "$1" render "$4" --seed "$2" -o "$work/$3.exr" --quiet > /dev/null
    awk '{ print $1 + $2, $3 }' "$work/spent" >> "$work/$3.spent"
}
# differ FIGURE A B: that figure of the picture B against A.
differ() { "$new" error "$work/$2.exr" "$work/$3.exr" --json | sed -n "s/.*\"$1\": \([-+.e0-9]*\).*/\1/p"; }
# vary NAME: the difference between the picture and the one before, in NAME.noise.
vary() {
    if [ -e "$work/$1.before.exr" ]; then
        differ relative_mse_trimmed "$1.before" "$1" >> "$work/$1.noise"
    fi
    cp "$work/$1.exr" "$work/$1.before.exr"
}
# mean NAME: of the lines of NAME.noise.
mean() { awk '{ s += $1 } END { print s / NR }' "$work/$1.noise"; }
# median NAME COLUMN: of the lines of NAME.spent.
median() { awk -v c="$2" '{ print $c }' "$work/$1.spent" | sort -g | awk '{ v[NR] = $1 } END { print v[int((NR + 1) / 2)] }'; }

printf '%-58s %8s %8s %6s %8s %8s %6s %6s %6s %6s\n' \
    scene 'old s' 'new s' ratio 'old MiB' 'new MiB' ratio noise cost z
for scene in "$work"/scenes/*.toml; do
    name=$(basename "$scene" .toml)
    if [ $# -gt 0 ] && ! grep -qF "$(printf '%s\n' "$@")" <<< "$name"; then continue; fi
    rm -f "$work"/*.spent "$work"/*.noise "$work"/*.before.exr "$work/brighter"
    for ((run = 0; run < runs; run++)); do
        if ((run % 2 == 0)); then
            render "$old" "$run" old "$scene"
            render "$new" $((run + 1000)) new "$scene"
        else
            render "$new" $((run + 1000)) new "$scene"
            render "$old" "$run" old "$scene"
        fi
        vary old
        vary new
        differ mean_difference old new >> "$work/brighter"
    done
    z=$(awk '{ s += $1; q += $1 * $1 } END { v = (q - s * s / NR) / (NR - 1); print (v > 0) ? s / sqrt(NR * v) : 0 }' "$work/brighter")
    noise=$(awk -v old="$(mean old)" -v new="$(mean new)" 'BEGIN { print (old > 0) ? new / old : 1 }')
    printf '%s %s %s %s %s %s %s\n' "$name" "$(median old 1)" "$(median new 1)" "$(median old 2)" "$(median new 2)" \
        "$noise" "$z" |
        awk '{ printf "%-58s %8.2f %8.2f %6.2f %8.0f %8.0f %6.2f %6.2f %6.2f %6.1f\n",
            $1, $2, $3, $3 / $2, $4 / 1024, $5 / 1024, $5 / $4, $6, $6 * $3 / $2, $7 }'
done
