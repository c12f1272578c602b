# What checks with Blender begin with; they source it.

# `blender` becomes the command that BLENDER_PYTHON names, which must have these modules, and FOLDER a folder that is there.
needs_blender() {
    read -ra blender <<< "${BLENDER_PYTHON:-python3.13}"
    "${blender[@]}" -c "import $1" > /dev/null 2>&1 || { echo "skipped: ${blender[*]} cannot import $1"; exit 0; }
    if [ -z "${FOLDER:-}" ]; then
        FOLDER=$(mktemp -d)
        trap 'rm -r "$FOLDER"' EXIT
    fi
    mkdir -p "$FOLDER"
}

# FOGBOW becomes a built program.
needs_fogbow() {
    if [ -z "${FOGBOW:-}" ]; then
        cargo build --release
        FOGBOW=${CARGO_TARGET_DIR:-target}/release/fogbow
    fi
}
