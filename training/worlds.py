"""Drives of the simulator to learn from: each a world of its own, drawn from its seed alone."""

import os
import subprocess
from concurrent.futures import ThreadPoolExecutor

from pictures import KEPT

# One picture every two seconds: each shows another place.
FPS = 0.5


def draw(program, folder, seeds, workers=2):
    """Draws the drives that are not there yet; each is written whole or not at all by the program. Seeds of which it makes no drive, because
    the route that it draws is none in that world, are named and passed over."""
    os.makedirs(folder, exist_ok=True)

    def one(seed):
        out = f"{folder}/{seed:06d}"
        if os.path.exists(f"{out}/truth.jsonl"):
            return
        drawn = subprocess.run([program, "simulate", "--world", "--world-ranges", "wide", "--seed", str(seed), "--fps", str(FPS),
                        "--size", f"{KEPT[0]}x{KEPT[1]}", "--classes", "--out", out], capture_output=True, text=True)
        if drawn.returncode == 1:
            print(f"no drive of seed {seed}: {drawn.stderr.strip().splitlines()[-1]}", flush=True)
        else:
            drawn.check_returncode()

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(one, seeds))
