#!/usr/bin/env bash
# Builds the wheel for Python into FOLDER, installs it in a clean environment, and holds it against the program: the tests of
# python/tests, the examples, among them the whole demo, the time of a frame, and drives over a local cluster of Ray.
#
#     tools/wheel.sh FOLDER FINGERPOST DEMO
#
# FINGERPOST is the program, DEMO the run folder of its demo. Needs Python 3.10 or later with venv, and the Python index.
set -euo pipefail
mkdir -p "$1"
out=$(realpath "$1")
FINGERPOST=$(realpath "$2")
demo=$(realpath "$3")
export FINGERPOST
cd "$(dirname "$0")/.."
root=$PWD
export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$root/target}"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/build"
"$work/build/bin/pip" install --quiet maturin==1.16.0
"$work/build/bin/maturin" build --quiet --release --locked --manifest-path python/Cargo.toml --interpreter python3 --out "$out"

python3 -m venv "$work/clean"
"$work/clean/bin/pip" install --quiet pytest==9.2.0 "$out"/fingerpost-*.whl
# Away from the sources, so that the package that was installed is the one that is tried.
cd "$work"
clean/bin/python -m pytest --quiet -p no:cacheprovider "$root/python/tests/test_fingerpost.py"
sed -n '/^```python$/,/^```$/{/^```/d;p}' "$root/python/README.md" >readme.py
clean/bin/python readme.py | tail -n 1
clean/bin/python "$root/python/examples/simulated_drive.py"
clean/bin/python "$root/python/examples/demo.py" "$demo"
clean/bin/python "$root/python/examples/time_of_a_frame.py" "$FINGERPOST"

# All that goes without it has gone; now Ray.
clean/bin/pip install --quiet "$(echo "$out"/fingerpost-*.whl)[fleet]" ray==2.60.0 pyarrow==26.0.1
clean/bin/python -m pytest --quiet -p no:cacheprovider "$root/python/tests/test_fleet.py"
clean/bin/python "$root/python/examples/fleet_campaign.py" "$FINGERPOST" campaign 2>/dev/null
