#!/usr/bin/env python3
"""Makes a Rerun recording with Fingerpost's blueprint from a run.mcap: viewers/rerun_blueprint.py RUN.mcap OUT.rrd

Needs rerun-sdk, with its program `rerun` on the path.
"""
import pathlib
import subprocess
import sys
import tempfile

import rerun.blueprint as rrb

# Recording and blueprint belong together by this name.
APPLICATION = "fingerpost"

BLUEPRINT = rrb.Blueprint(
    rrb.Horizontal(
        rrb.Vertical(
            rrb.Spatial2DView(name="Camera", origin="/camera", contents=["/camera/image", "/camera/annotations"]),
            rrb.Horizontal(
                rrb.Spatial2DView(name="Ground view", origin="/ground_view", contents=["/ground_view/image"]),
                rrb.TextLogView(name="What changed and why", origin="/log"),
            ),
            row_shares=[3, 2],
        ),
        rrb.Vertical(
            rrb.Spatial3DView(
                name="Road",
                origin="/",
                contents=["/tf", "/odometry", "/driving_line/poses", "/camera/calibration", "/camera/image"],
            ),
            rrb.MapView(name="Map", origin="/fix"),
            row_shares=[3, 2],
        ),
        column_shares=[3, 2],
    ),
    collapse_panels=True,
)


def main(recording, out):
    with tempfile.TemporaryDirectory() as folder:
        drive, blueprint = pathlib.Path(folder, "drive.rrd"), pathlib.Path(folder, "blueprint.rbl")
        BLUEPRINT.save(APPLICATION, str(blueprint))
        convert = ["rerun", "mcap", "convert", recording, "--application-id", APPLICATION, "-o", str(drive)]
        subprocess.run(convert, check=True)
        subprocess.run(["rerun", "rrd", "merge", str(drive), str(blueprint), "-o", out], check=True)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
