"""Drives of the simulator to learn from: each a world of its own, drawn from its seed alone."""

import os
import subprocess
from concurrent.futures import ThreadPoolExecutor

from pictures import KEPT

# One picture every two seconds: each shows another place.
FPS = 0.5


def draw(program, folder, seeds, workers=2):
    """Draws the drives that are not there yet; each is written whole or not at all by the program."""
    os.makedirs(folder, exist_ok=True)

    def one(seed):
        out = f"{folder}/{seed:06d}"
        if os.path.exists(f"{out}/truth.jsonl"):
            return
        subprocess.run([program, "simulate", "--world", "--world-ranges", "wide", "--seed", str(seed), "--fps", str(FPS),
                        "--size", f"{KEPT[0]}x{KEPT[1]}", "--classes", "--out", out], check=True, capture_output=True)

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(one, seeds))
