#!/usr/bin/env bash
# Checks that PACKAGEs, or else all of the workspace, compile for 64-bit ARM, and runs the picture kernels' tests there, under an emulator on other machines: the
# kernels must give the bytes that they give on x86-64.
#
#     tools/aarch64.sh [PACKAGE...]
#
# Needs, where the machine is no 64-bit ARM, aarch64-linux-gnu-gcc and qemu-aarch64-static (Debian: gcc-aarch64-linux-gnu
# libc6-dev-arm64-cross qemu-user-static), and Rust's library for ARM, which rustup adds where it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
target=aarch64-unknown-linux-gnu

if [ "$(uname -m)" != aarch64 ]; then
    for program in aarch64-linux-gnu-gcc qemu-aarch64-static; do
        command -v "$program" >/dev/null || {
            echo "$program is missing; install it (Debian: apt-get install gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user-static)" >&2
            exit 1
        }
    done
    if ! test -d "$(rustc --print sysroot)/lib/rustlib/$target/lib"; then
        rustup target add "$target"
    fi
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64-static -L /usr/aarch64-linux-gnu"
fi
packages=(--workspace)
if [ $# -gt 0 ]; then
    packages=("${@/#/--package=}")
fi
cargo check "${packages[@]}" --target "$target"
cargo test --package fingerpost-vision --target "$target"
