#!/usr/bin/env bash
# Holds the packets of --tev against those of tev's own Python client, from PyPI, and fails where that is skipped.
#
#     apt-get install python3-pip
#     tests/check/tev.sh
set -euo pipefail
cd "$(dirname "$0")/../.."

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m pip install --quiet --target "$folder" tevclient numpy
export PYTHONPATH=$folder
cargo test --test cli tev -- --nocapture 2>&1 | tee "$folder/told"
grep -q '^test result: ok. [1-9]' "$folder/told"
if grep 'skipped: ' "$folder/told"; then
    echo "tests were skipped" >&2
    exit 1
fi
echo "none skipped"
