#!/usr/bin/env bash
# Renders the pictures of README and guide from what ships: volumes/*.png and src/guide/figures/*.png.
# FOGBOW may name the program; else it is built.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
if [ -z "${FOGBOW:-}" ]; then
  cargo build --release --manifest-path "$root/Cargo.toml"
  FOGBOW=${CARGO_TARGET_DIR:-$root/target}/release/fogbow
fi
volumes=$root/volumes
figures=$root/src/guide/figures
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$figures"

# picture PNG ARGUMENTS...: renders, and keeps the PNG.
picture() {
  local png=$1
  shift
  "$FOGBOW" render "$@" -o "$work/picture.exr" --quiet > /dev/null
  mv "$work/picture.png" "$png"
}

# README: smoke, fire and cloud, and what a bare file gives.
fine=(--size 480x600 --rays 64 --photons 4000000)
"$FOGBOW" make smoke -o "$work/smoke.vdb" --resolution 384 > /dev/null # that of smoke.vdb, three times finer
picture "$volumes/smoke.png" "$work/smoke.vdb" "${fine[@]}" --orbit 60 --elevation 8 --density 0.7 --albedo 0.7
picture "$volumes/fire.png" "$volumes/fire.vdb" "${fine[@]}"
picture "$volumes/cloud.png" "$volumes/cloud.vdb" "${fine[@]}" --orbit 20
picture "$volumes/bare.png" "$volumes/smoke.vdb"

# How it works: photons, one scene with one exposure.
"$FOGBOW" render "$volumes/smoke.vdb" --size 200x250 --write-scene "$work/smoke.toml" -o "$work/first.exr" --quiet > /dev/null
for photons in 2000 20000 200000 2000000; do
  picture "$figures/photons_$photons.png" "$work/smoke.toml" --rays 64 --photons "$photons"
done

# How it works: orders of scattering.
"$FOGBOW" render "$volumes/cloud.vdb" --size 240x180 --write-scene "$work/cloud.toml" -o "$work/first.exr" --quiet > /dev/null
for orders in 1 4 16; do
  picture "$figures/scatter_$orders.png" "$work/cloud.toml" --rays 64 --photons 2000000 --max-scatter "$orders"
done
picture "$figures/scatter_all.png" "$work/cloud.toml" --rays 64 --photons 2000000

# How it works: the director's maps.
picture "$figures/maps_picture.png" "$volumes/balls_a.toml" --size 256x192 --rays 64
"$FOGBOW" maps "$volumes/balls_a.toml" --size 256x192 -o "$work/maps" --quiet > /dev/null
mv "$work/maps/x.png" "$figures/maps_transmittance.png"
mv "$work/maps/saliency.png" "$figures/maps_saliency.png"
mv "$work/maps/xs.png" "$figures/maps_rays.png"
