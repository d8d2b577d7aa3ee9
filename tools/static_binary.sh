#!/usr/bin/env bash
# Builds the program as one static binary for Linux into FOLDER: it needs no library of the machine that it runs on.
#
#     tools/static_binary.sh FOLDER
#
# Needs musl-gcc (Debian: musl-tools) and Rust's library for musl, which rustup adds where it is missing.
set -euo pipefail
mkdir -p "$1"
out=$(realpath "$1")
cd "$(dirname "$0")/.."
target=$(uname -m)-unknown-linux-musl

command -v musl-gcc >/dev/null || { echo "musl-gcc is missing; install it (Debian: apt-get install musl-tools)" >&2; exit 1; }
has_target() { test -d "$(rustc --print sysroot)/lib/rustlib/$target/lib"; }
if ! has_target && command -v rustup >/dev/null; then
    rustup target add "$target" || true
fi
has_target || {
    echo "Rust's library for $target is missing, and rustup is not here or could not fetch it: run 'rustup target add $target' where" \
        "rustup has a network, or install your distribution's package of it" >&2
    exit 1
}

export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
cargo build --quiet --release --locked --package fingerpost-cli --features completions --target "$target"
install -m 755 "$CARGO_TARGET_DIR/$target/release/fingerpost" "$out/fingerpost"
# A binary that names an interpreter or a library needs that of the machine.
if readelf --program-headers --dynamic "$out/fingerpost" | grep -E 'INTERP|NEEDED'; then
    echo "$out/fingerpost is not static" >&2
    exit 1
fi
echo "$out/fingerpost"
