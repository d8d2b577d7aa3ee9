#!/usr/bin/env python3
"""How long a frame takes in Python, beside what `fingerpost run` takes for the method alone.

    python examples/time_of_a_frame.py FINGERPOST [FRAMES]
"""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy

import fingerpost


def main(program, frames):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        roads, route = fingerpost.demo_town()
        camera = fingerpost.Camera(640, 480, fx=420, fy=420, cx=319.5, cy=239.5, height_m=1.5, pitch_deg=8, x_m=1.5)
        drive = fingerpost.Simulator(roads, route, camera, seed=1, frames=frames)
        pictures = [frame.picture for frame in drive]
        (folder / "frames").mkdir()
        for i, picture in enumerate(pictures):
            (folder / f"frames/{i:06}.ppm").write_bytes(b"P6\n640 480\n255\n" + picture.tobytes())
        (folder / "camera.toml").write_text(camera.to_toml())
        (folder / "route.geojson").write_text(route.to_geojson())
        command = [program, "run", folder / "frames", "--camera", folder / "camera.toml", "--route", folder / "route.geojson",
                   "--start-m", "0", "--no-recording", "--threads", "1"]
        of_program, of_package = [], []
        # In turns, so that what else the machine does falls on both.
        for turn in range(5):
            out = folder / f"run{turn}"
            subprocess.run([str(word) for word in [*command, "--out", out]], check=True, capture_output=True)
            records = [json.loads(line) for line in (out / "frames.jsonl").read_text().splitlines()]
            of_program.append([sum(ms for stage, ms in record["stage_ms"].items() if stage != "decode") for record in records])
            pipeline = fingerpost.Pipeline(camera, route, start_m=0.0)
            times_ms = []
            for i, picture in enumerate(pictures):
                began = time.perf_counter()
                output = pipeline.step(picture, t_s=0.1 * i)
                surface = output.road_surface
                times_ms.append(1e3 * (time.perf_counter() - began))
                assert isinstance(surface, numpy.ndarray)
            of_package.append(times_ms)
        # The least of the turns of each frame is what it takes undisturbed.
        program_ms, package_ms = (statistics.mean(map(min, zip(*turns))) for turns in (of_program, of_package))
        print(f"a frame takes {package_ms:.2f} ms in Python, {program_ms:.2f} ms in the program: {100 * (package_ms / program_ms - 1):+.1f} %")


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100)
