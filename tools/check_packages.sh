#!/usr/bin/env bash
# Packages every crate that could be published, and compiles the packages alone, away from the repository: nothing may be missing in
# them. With another compiler than the oldest that is promised, that one checks the workspace, where rustup has it.
#
#     tools/check_packages.sh
set -euo pipefail
cd "$(dirname "$0")/.."

packages=$(mktemp -d)
trap 'rm -rf "$packages"' EXIT
cargo package --workspace --exclude fingerpost-fuzz --no-verify --allow-dirty --quiet --target-dir "$packages/target" 2>"$packages/said" \
    || { cat "$packages/said"; exit 1; }
mkdir "$packages/crates"
for package in "$packages"/target/package/*.crate; do
    # With the time of now: packages have one of their own for all files, by which cargo takes what it built of older ones for theirs.
    tar -xzmf "$package" -C "$packages/crates"
done
{
    printf '[workspace]\nresolver = "3"\nmembers = ["crates/*"]\n\n[patch.crates-io]\n'
    for crate in "$packages"/crates/*; do
        name=$(basename "$crate")
        printf '%s = { path = "crates/%s" }\n' "${name%-*}" "$name"
    done
} >"$packages/Cargo.toml"
cp Cargo.lock "$packages/Cargo.lock"
for crate in "$packages"/crates/*; do
    test -s "$crate/LICENSE-MIT" && test -s "$crate/LICENSE-APACHE" && test -s "$crate/README.md" \
        || { echo "$crate lacks a licence or its README"; exit 1; }
    for key in repository homepage documentation; do
        grep -q "^$key = " "$crate/Cargo.toml" || { echo "$crate has no $key"; exit 1; }
    done
done
CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}" cargo check --manifest-path "$packages/Cargo.toml" --workspace --all-features --quiet

oldest=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
case "$(rustc --version)" in
    "rustc $oldest."*) echo "packages compile with the oldest compiler that is promised, $oldest" ;;
    *)
        if command -v rustup >/dev/null && rustup run "$oldest" rustc --version >/dev/null 2>&1; then
            rustup run "$oldest" cargo check --workspace --quiet
            echo "packages compile, and the workspace with the oldest compiler that is promised, $oldest"
        else
            echo "packages compile; the oldest compiler that is promised, $oldest, is not here and was not tried"
        fi
        ;;
esac
