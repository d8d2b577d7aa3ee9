#!/usr/bin/env python3
"""Drives `fingerpost advise` in lockstep through the frames of a simulated drive, and prints what it advises.

    fingerpost simulate --map town.osm --route route.geojson --ppm --out drive
    python3 examples/advise.py drive [path of fingerpost] [arguments of advise]
"""
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

drive, program = Path(sys.argv[1]), (sys.argv[2:3] or ["fingerpost"])[0]
files = ["--camera", drive / "camera.toml", "--route", drive / "route.geojson", "--start-m", "0"]
advisor = subprocess.Popen([program, "advise", *files, *sys.argv[3:]], stdin=subprocess.PIPE, stdout=subprocess.PIPE)


def advised(header, picture):
    """The answer to a picture; what is said before it, that none came for a while, is no answer."""
    advisor.stdin.write(json.dumps(header).encode() + b"\n")
    advisor.stdin.write(np.ascontiguousarray(picture))  # Its bytes, without a copy of a picture that lies in one piece.
    advisor.stdin.flush()
    while "frame" not in (answer := json.loads(advisor.stdout.readline())):
        print(answer["advice"]["because"])  # Here a vehicle would stop, at the time at which the line comes.
    return answer


truth = [json.loads(line) for line in (drive / "truth.jsonl").read_text().splitlines()]
waited_s = 0.0
for frame, path in zip(truth, sorted((drive / "frames").glob("*.ppm"))):
    _, size, _, pixels = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    picture = np.frombuffer(pixels, np.uint8).reshape(height, width, 3)  # Here a simulator would give its own.
    header = {"t_s": frame["t_s"], "width": width, "height": height, "speed_mps": frame["speed_mps"]}
    began = time.perf_counter()
    answer = advised(header, picture)
    waited_s += time.perf_counter() - began
    advice = answer["advice"]  # Here a vehicle would steer.
    print(f"{answer['t_s']:6.2f} s: steer {advice['steer_rad']:+.3f} rad, {advice['speed_mps']:.1f} m/s, {advice['because']}")
advisor.stdin.close()
print(f"{len(truth) / waited_s:.1f} frames a second", file=sys.stderr)
sys.exit(advisor.wait())
