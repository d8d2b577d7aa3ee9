#!/usr/bin/env bash
# Installs a Debian package in an empty root, where there is nothing but what the package brings, runs the demo from it and holds its
# numbers against those of REFERENCE, the summary of another build's demo. What is installed must be the static binary PROGRAM, byte for
# byte, so that the same is shown of it.
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
chroot "$root" /usr/bin/fingerpost demo --out /tmp/demo --json >"$root/summary.json" 2>"$root/said" || { cat "$root/said" >&2; exit 1; }
test -s "$root/tmp/demo/report.html"
# Frames and counts must be the same. Places and errors are those of another C library, whose sines and exponentials differ from the
# reference's in the last digit: on this drive that moves a place by 0.11 m at most and an error by 0.003 m.
counts='[.frames, .broken_frames, .lost_frames, .features_total, .features_detected, .false_detections, .arrivals, .interrupted,
    (.features[] | .id, .kind, .detected_frame, .arrived_frame)]'
if ! diff <(jq "$counts" "$reference") <(jq "$counts" "$root/summary.json"); then
    echo "the installed program's demo finds other things" >&2
    exit 1
fi
jq -e --slurp '
    def near(numbers; most): map([numbers]) | transpose | all((.[0] - .[1] | fabs) <= most);
    near(.features[].detected_forward_m; 0.2)
    and near(.features[].max_p; 0.002)
    and near(.position_error_m | .p50, .p95, .max; 0.005)
    and near(.motion_error_pct; 0.005)
' "$reference" "$root/summary.json" >/dev/null || { echo "the installed program's demo gives other numbers" >&2; jq . "$root/summary.json" >&2; exit 1; }
dpkg --root="$root" --log=/dev/null --purge fingerpost >/dev/null
test ! -e "$root/usr/bin/fingerpost"
echo "$(basename "$package") installs in an empty root, gives the demo's numbers there and leaves nothing behind"
