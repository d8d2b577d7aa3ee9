#!/usr/bin/env bash
# Makes what a release holds into FOLDER: static binary, Debian package and wheel, each installed in an empty root or a clean environment
# and held against the program that cargo builds. With TAG, which must be that of the version, as in v0.1.0.
#
#     tools/release.sh FOLDER [TAG]
#
# Needs root, and what tools/static_binary.sh, debian_package.sh, check_installed.sh and wheel.sh need.
set -euo pipefail
mkdir -p "$1"
out=$(realpath "$1")
cd "$(dirname "$0")/.."
version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
if [ "${2:-v$version}" != "v$version" ]; then
    echo "the tag is $2 and the version $version; tag v$version, or change the version in Cargo.toml and python/Cargo.toml" >&2
    exit 1
fi
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cargo build --release --locked
program="$CARGO_TARGET_DIR/release/fingerpost"
"$program" demo --out "$work/demo" --json >"$work/summary.json"
tools/static_binary.sh "$out"
package=$(tools/debian_package.sh "$out/fingerpost" "$out")
tools/check_installed.sh "$package" "$out/fingerpost" "$work/summary.json"
tools/wheel.sh "$out" "$program" "$work/demo"
(cd "$out" && sha256sum fingerpost fingerpost_*.deb fingerpost-*.whl | tee SHA256SUMS)
