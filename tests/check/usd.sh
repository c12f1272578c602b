#!/usr/bin/env bash
# Makes shots in Blender, exports them as USD and renders them by Cycles and by fogbow: corners of a mesh must be
# where Blender projects them, and the light of each kind of lamp on a white plane, and of smoke, as bright as
# Cycles has it.
#
#     pip install bpy==5.2.3 OpenEXR            # bpy wants Python 3.13
#     tests/check/usd.sh
#
# A stage with references, payloads, variants and instances is held against usd-core, which must not be where bpy
# is: USD_PYTHON names a command with it and numpy (pip install usd-core numpy).
#
# With FIGURE=volumes/shot.png it renders the picture of the guide anew.
#
# BLENDER_PYTHON names the command with both (python3.13), FOGBOW a built program, FOLDER where files and pictures are
# left.
set -euo pipefail
cd "$(dirname "$0")/../.."

. tests/check/blender_common.sh

needs_blender "bpy, OpenEXR"
needs_fogbow
for frame in 1 2 3; do
    cp volumes/smoke.vdb "$FOLDER/smoke_000$frame.vdb"
done
"${blender[@]}" tests/check/usd.py make "$FOLDER" > "$FOLDER/messages" 2>&1 || { tail "$FOLDER/messages"; exit 1; }
"${blender[@]}" tests/check/usd.py compare "$FOLDER" "$FOGBOW"
if [ -n "${FIGURE:-}" ]; then
    "${blender[@]}" tests/check/usd_figure.py "$FOLDER" "$FOGBOW" "$FIGURE"
fi
read -ra usd <<< "${USD_PYTHON:-python3}"
if "${usd[@]}" -c 'import pxr, numpy' > /dev/null 2>&1; then
    "${usd[@]}" tests/check/usd_compose.py "$FOLDER" "$FOGBOW"
else
    echo "skipped: ${usd[*]} has no usd-core or no numpy"
fi
