#!/usr/bin/env python3
"""Writes the golden files of the drive's colours: what the training's computation makes of the same pictures and logits.

    pip install --require-hashes -r training/requirements.txt
    python3 tools/golden/drive_colours.py crates/fingerpost/tests/golden

    drive_colours.rgb   pictures, 48 x 32
    drive_colours.i8    logits of each, 24 x 16, sixteenths
    drive_colours.f32   log-odds that colours add, little endian
"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "training"))
from colours import DriveColours  # noqa: E402

WIDTH, HEIGHT, PICTURES, FIRST_ROW = 48, 32, 3, 5


def main(folder):
    random = np.random.default_rng(23)
    colours = DriveColours()
    written = {"rgb": b"", "i8": b"", "f32": b""}
    for _ in range(PICTURES):
        left = np.array([100, 98, 96]) + random.normal(0, 14, (HEIGHT, WIDTH, 3))
        right = np.array([80, 120, 60]) + random.normal(0, 20, (HEIGHT, WIDTH, 3))
        edge = random.integers(10, 38)
        is_left = (np.arange(WIDTH) < edge)[None, :, None]
        picture = np.clip(np.where(is_left, left, right), 0, 255).astype(np.uint8)
        places = (np.arange(WIDTH // 2) < edge / 2)[None, :]
        logits = np.clip(np.where(places, 40, -40) + random.normal(0, 30, (HEIGHT // 2, WIDTH // 2)), -127, 127).astype(np.int8)
        added = colours.see(picture, logits / 16, FIRST_ROW)
        for name, data in (("rgb", picture), ("i8", logits), ("f32", added.astype("<f4"))):
            written[name] += data.tobytes()
    for name, data in written.items():
        (pathlib.Path(folder) / f"drive_colours.{name}").write_bytes(data)


if __name__ == "__main__":
    main(sys.argv[1])
