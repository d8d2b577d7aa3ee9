#!/usr/bin/env python3
"""The program's demonstration in Python, with its numbers held against those of the program.

    python examples/demo.py RUN

RUN is the run folder of `fingerpost demo`. Every frame must give the same record, and all of them together the same evaluation.
"""

import json
import pathlib
import sys

import fingerpost


def main(run):
    roads, route = fingerpost.demo_town()
    camera = fingerpost.Camera(640, 480, fx=420, fy=420, cx=319.5, cy=239.5, height_m=1.5, pitch_deg=8, x_m=1.5)
    drive = fingerpost.Simulator(roads, route, camera)
    pipeline = fingerpost.Pipeline(camera, route, start_m=5.0)
    records, truth = [], []
    for frame in drive:
        truth.append(frame.truth)
        records.append(pipeline.step(frame.picture, t_s=frame.truth["t_s"]).record)
    found = fingerpost.evaluate_junctions(records, truth, route)

    expected = [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]
    different = [ours["frame"] for ours, theirs in zip(records, expected, strict=True) if ours != {**theirs, "stage_ms": {}}]
    if different:
        sys.exit(f"{len(different)} of {len(records)} frames differ from those of {run}, frame {different[0]} first")
    summary = json.loads((run / "summary.json").read_text())
    other = sorted(name for name in found.keys() & summary.keys() if found[name] != summary[name])
    if other:
        sys.exit(f"the evaluation differs from that of {run} in {', '.join(other)}")
    print(
        f"{len(records)} frames as the program's: {found['features_detected']} of {found['features_total']} features found, "
        f"{found['false_detections']} falsely; {found['position_error_m']['p95']:.2f} m off at the 95th percentile"
    )


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
