#!/usr/bin/env bash
# Runs both commands of the README, and the one that installs fogbow, in a bare Debian with Rust alone,
# in a clone of what is committed, and lists the tests that were skipped there.
#
#     apt-get install debootstrap
#     tests/check/bare.sh [FOLDER [render|install|test ...]]
#
# As root. A FOLDER is kept and taken up again, so that the second run downloads and compiles less;
# without one the root is a temporary folder. MIRROR names another mirror of Debian.
set -euo pipefail
cd "$(dirname "$0")/../.."

[ "$(id -u)" = 0 ] || { echo "bare.sh: a root is entered by root only; use sudo" >&2; exit 2; }
for program in debootstrap chroot mount git rustc; do
    command -v "$program" > /dev/null || { echo "bare.sh: needs $program; install it" >&2; exit 2; }
done
root=${1:-}
shift $(($# > 0 ? 1 : 0))
wanted=("$@")
[ ${#wanted[@]} -gt 0 ] || wanted=(render install test)

is_kept=${root:+yes}
root=$(realpath -m "${root:-$(mktemp -d)}")
leave() {
    if mountpoint -q "$root/proc"; then umount "$root/proc"; fi
    if [ -z "$is_kept" ]; then rm -rf --one-file-system "$root"; fi
}
trap leave EXIT

title() { printf '\n== %s\n' "$1"; }
readme() { awk -v name="<!-- $1 -->" '$0 == name {on=1} on && /^```$/ {exit} on && !/^(<|```)/' README.md; }

title "a bare Debian in $root"
if [ ! -e "$root/etc/debian_version" ]; then
    debootstrap --variant=minbase bookworm "$root" "${MIRROR:-http://deb.debian.org/debian}"
fi
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
cp /etc/resolv.conf "$root/etc/"

title "Rust, copied from $(rustc --print sysroot)"
rust=/usr/local/rust
if [ ! -x "$root$rust/bin/cargo" ]; then
    mkdir -p "$root$rust"
    cp -a "$(rustc --print sysroot)/." "$root$rust"
fi
# Whoever downloaded Rust has certificates to download crates by.
certificates=/etc/ssl/certs/ca-certificates.crt
mkdir -p "$root/etc/ssl/certs"
cp "$certificates" "$root$certificates"
inside() {
    chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 CARGO_TERM_COLOR=never DEBIAN_FRONTEND=noninteractive \
        PATH="$rust/bin:/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin" \
        SSL_CERT_FILE="$certificates" \
        ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} "$@"
}
inside rustc --version
inside cargo --version

title "the commands"
clone=$root/root/fogbow
commit=$(git rev-parse HEAD)
[ -d "$clone/.git" ] || git clone --quiet --no-hardlinks . "$clone"
git -C "$clone" fetch --quiet "$PWD" HEAD
git -C "$clone" checkout --quiet --force --detach "$commit"
rm -f "$clone/target/tmp/skipped"
ends=()
status=0
for name in "${wanted[@]}"; do
    case $name in
        install) command='cargo install --path . && "$HOME/.cargo/bin/fogbow" --version' ;;
        *) command=$(readme "$name") ;;
    esac
    [ -n "$command" ] || { echo "bare.sh: the README has no block behind <!-- $name -->" >&2; exit 2; }
    title "$name"
    code=0
    inside bash -euo pipefail -c "cd /root/fogbow; $command" || code=$?
    ends+=("$name: exit $code")
    [ "$code" = 0 ] || status=1
done

title "skipped tests"
list=$(sort -u "$clone/target/tmp/skipped" 2> /dev/null || true)
printf '%s skipped:\n%s\n' "$(grep -c . <<< "$list" || true)" "$list"
title "ends"
printf '%s\n' "${ends[@]}"
exit "$status"
