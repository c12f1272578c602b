#!/usr/bin/env bash
# Writes smoke, fire and a coloured cloud by Blender's own OpenVDB and by Debian's, and renders both: what
# fogbow tells of their grids must be the same, and the pictures to the last pixel, whatever the formats
# of the files are.
#
#     pip install bpy==5.2.3            # wants Python 3.13
#     apt-get install python3-openvdb python3-numpy
#     tests/check/blender.sh
#
# BLENDER_PYTHON names the command with bpy (python3.13), SYSTEM_PYTHON the one with Debian's module
# (/usr/bin/python3), FOGBOW a built program, FOLDER where files and pictures are left.
set -euo pipefail
cd "$(dirname "$0")/../.."

. tests/check/blender_common.sh

system=${SYSTEM_PYTHON:-/usr/bin/python3}
"$system" -c 'import pyopenvdb, numpy' 2> /dev/null ||
    { echo "skipped: $system has no pyopenvdb or numpy"; exit 0; }

needs_blender bpy
mkdir -p "$FOLDER/blender" "$FOLDER/system"
"${blender[@]}" - "$FOLDER/blender" < tests/check/blender.py 2> "$FOLDER/blender/messages" |
    tail -n 1 || { cat "$FOLDER/blender/messages"; exit 1; }
"$system" - "$FOLDER/system" < tests/check/blender.py

needs_fogbow
for name in smoke fire cloud; do
    for writer in blender system; do
        picture=$FOLDER/$writer/$name
        "$FOGBOW" render "$picture.vdb" -o "$picture.exr" --size 96x96 --rays 4 --photons 20000 \
            --quiet > "$FOLDER/$writer/$name.txt"
        "$FOGBOW" info "$picture.vdb" --json |
            "$system" -c 'import json, sys; print(json.dumps(json.load(sys.stdin)["grids"], indent=1))' \
                > "$picture.json"
    done
    cmp "$FOLDER/blender/$name.json" "$FOLDER/system/$name.json"
    cmp "$FOLDER/blender/$name.png" "$FOLDER/system/$name.png"
    "$FOGBOW" error "$FOLDER/blender/$name.exr" "$FOLDER/system/$name.exr" --json |
        "$system" -c 'import json, sys; found = json.load(sys.stdin); sys.exit(found["errors"]["mse"] != 0)'
    echo "$name: the same grids, the same pixels"
done
