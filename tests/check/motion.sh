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

. tests/check/blender_common.sh

needs_blender "bpy, OpenEXR"
FOLDER=$(cd "$FOLDER" && pwd)
FOGBOW_FOLDER=$FOLDER cargo test --quiet --test physics the_files_beside_cycles -- --ignored > "$FOLDER/messages"
needs_fogbow
"${blender[@]}" tests/check/motion.py "$FOLDER" "$FOGBOW"
