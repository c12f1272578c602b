#!/usr/bin/env bash
# Blurs smoke by fogbow, in an even wind and in a vortex, and holds the pictures against means of sharp ones by Cycles; Cycles' own
# motion blur of the same file is told beside.
#
#     pip install bpy==5.2.3 OpenEXR            # bpy wants Python 3.13
#     tests/check/motion.sh
#
# BLENDER_PYTHON names the command with both (python3.13), FOGBOW a built program, FOLDER where files and pictures are left: of
# each field one PNG, Cycles above fogbow, sharp beside blurred, twice as large.
set -euo pipefail
cd "$(dirname "$0")/../.."

read -ra blender <<< "${BLENDER_PYTHON:-python3.13}"
"${blender[@]}" -c 'import bpy, OpenEXR' > /dev/null 2>&1 ||
    { echo "skipped: ${blender[*]} has no bpy or no OpenEXR"; exit 0; }

if [ -z "${FOLDER:-}" ]; then
    FOLDER=$(mktemp -d)
    trap 'rm -r "$FOLDER"' EXIT
fi
mkdir -p "$FOLDER"
FOLDER=$(cd "$FOLDER" && pwd)
FOGBOW_FOLDER=$FOLDER cargo test --quiet --test physics the_files_beside_cycles -- --ignored > "$FOLDER/messages"
if [ -z "${FOGBOW:-}" ]; then
    cargo build --release
    FOGBOW=${CARGO_TARGET_DIR:-target}/release/fogbow
fi
"${blender[@]}" tests/check/motion.py "$FOLDER" "$FOGBOW"
