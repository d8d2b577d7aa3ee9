#!/usr/bin/env bash
# Installs a Debian package in an empty root, where there is nothing but what the package brings, runs the demo from it and holds its
# numbers against those of REFERENCE, the summary of another build's demo. What is installed must be the static binary PROGRAM, byte for
# byte, so that the same is shown of it; pages of the manual and completions must be in their places and those of that program.
#
#     tools/check_installed.sh PACKAGE PROGRAM REFERENCE
#
# Needs dpkg and jq, and root, to enter the other root.
set -euo pipefail
package=$(realpath "$1")
program=$(realpath "$2")
reference=$(realpath "$3")
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
mkdir -p "$root/var/lib/dpkg/updates" "$root/var/lib/dpkg/info" "$root/tmp"
: >"$root/var/lib/dpkg/status"
dpkg --root="$root" --log=/dev/null --install "$package" >/dev/null
cmp "$program" "$root/usr/bin/fingerpost"
share="$root/usr/share"
chroot "$root" /usr/bin/fingerpost man --out /tmp/man
for page in "$root"/tmp/man/*.1; do
    gzip -dc "$share/man/man1/$(basename "$page").gz" | cmp - "$page"
    # As groff takes it for one: macros in the first line, and a title.
    head -n 1 "$page" | grep -qE '^\.(ie|TH) ' && grep -qE '^\.TH fingerpost' "$page" || { echo "$page is no page of the manual" >&2; exit 1; }
done
test -e "$share/man/man1/fingerpost-calibrate-mount.1.gz"
for completions in bash-completion/completions/fingerpost zsh/vendor-completions/_fingerpost fish/vendor_completions.d/fingerpost.fish; do
    chroot "$root" /usr/bin/fingerpost completions "${completions%%[-/]*}" | cmp - "$share/$completions"
done
bash -n "$share/bash-completion/completions/fingerpost"
chroot "$root" /usr/bin/fingerpost demo --out /tmp/demo --json >"$root/summary.json" 2>"$root/said" || { cat "$root/said" >&2; exit 1; }
test -s "$root/tmp/demo/report.html"
# Times depend on the machine; all else is the same to the last digit, on whatever C library.
without_times='del(.fps, .stage_ms)'
if ! diff <(jq "$without_times" "$reference") <(jq "$without_times" "$root/summary.json"); then
    echo "the installed program's demo gives other numbers" >&2
    exit 1
fi
dpkg --root="$root" --log=/dev/null --purge fingerpost >/dev/null
test ! -e "$root/usr/bin/fingerpost" && test ! -e "$share/man/man1/fingerpost.1.gz"
echo "$(basename "$package") installs in an empty root, gives the demo's numbers there and leaves nothing behind"
