#!/usr/bin/env python3
"""The method on a simulated drive through the demonstration's town: what is found, against the truth.

    python examples/simulated_drive.py [FRAMES]
"""

import sys

import fingerpost


def main(frames):
    roads, route = fingerpost.demo_town()
    camera = fingerpost.Camera(640, 480, fx=420, fy=420, cx=319.5, cy=239.5, height_m=1.5, pitch_deg=8, x_m=1.5)
    drive = fingerpost.Simulator(roads, route, camera, seed=1, frames=frames)
    pipeline = fingerpost.Pipeline(camera, route, start_m=0.0)
    records, truth = [], []
    state = None
    for frame in drive:
        output = pipeline.step(frame.picture, t_s=frame.truth["t_s"])
        records.append(output.record)
        truth.append(frame.truth)
        if output.state != state:
            state = output.state
            print(f"{frame.truth['t_s']:5.1f} s  {state:<9}  {output.why}")
    found = fingerpost.evaluate_junctions(records, truth, route)
    error = found["position_error_m"]
    print(
        f"{found['features_detected']} of {found['features_total']} features found, {found['false_detections']} falsely; "
        f"{error['p50']:.2f} m off in the median, {error['p95']:.2f} m at the 95th percentile"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 120)
