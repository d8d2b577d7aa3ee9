"""The drawn drives as arrays: pictures, and what each of their pixels shows."""

import glob
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image

# Size at which pictures are kept; crops of it are what the network sees.
KEPT = (384, 216)
# Classes of a drive's `classes/` folder.
VOID, ROAD, PAINT, RAISED, VERGE, THING, STRUCTURE, SKY = range(8)


def drives(folder):
    """Pictures (n x h x w x 3, levels) and classes (n x h x w) of every drive in a folder, in the order of their names."""
    frames = sorted(glob.glob(f"{folder}/*/frames/*"))

    def read(frame):
        classes = os.path.splitext(frame.replace("/frames/", "/classes/"))[0] + ".png"
        picture = Image.open(frame).convert("RGB").resize(KEPT, Image.BOX, reducing_gap=None)
        return np.asarray(picture), np.asarray(Image.open(classes).resize(KEPT, Image.NEAREST))

    with ThreadPoolExecutor(2) as pool:
        pairs = list(pool.map(read, frames))
    return np.stack([p for p, _ in pairs]), np.stack([c for _, c in pairs])


def horizons(classes):
    """The first row of every picture (n x h x w) with ground in more than a few of its places; the last row where none has."""
    ground = np.isin(classes, (ROAD, PAINT, RAISED, VERGE)).mean(2) > 0.02
    return np.where(ground.any(1), ground.argmax(1), classes.shape[1] - 1)


def crops(pictures, classes, count, shape, rng):
    """So many random crops at the network's size (levels 0 to 1), and their classes at the same size.

    A camera's picture is three to thirteen units wide for every four that it is high; the network's input is always the same size."""
    height, width = pictures.shape[1:3]
    xs, cs = [], []
    for _ in range(count):
        i = rng.integers(len(pictures))
        w = width * rng.uniform(0.6, 1.0)
        h = min(height, w / np.exp(rng.uniform(np.log(1.33), np.log(3.3))))
        w, h = int(w), int(h)
        left, top = rng.integers(0, width - w + 1), rng.integers(0, height - h + 1)
        cut = np.s_[i, top:top + h, left:left + w]
        x = torch.from_numpy(pictures[cut].copy()).permute(2, 0, 1)[None].float() / 255
        xs.append(F.interpolate(x, size=(shape.height, shape.width), mode="bilinear", antialias=True)[0])
        c = torch.from_numpy(classes[cut].copy())[None, None].float()
        cs.append(F.interpolate(c, size=(shape.height, shape.width), mode="nearest")[0, 0].long())
    return torch.stack(xs), torch.stack(cs)


def targets(classes):
    """What the network should say (n x 4 x h/2 x w/2): shares of road, paint, raised ground and hidden ground in each of its places; and
    the share of each place that shows anything."""
    share = lambda mask: F.avg_pool2d(mask.float()[:, None], 2)
    of = [(classes == ROAD) | (classes == PAINT), classes == PAINT, classes == RAISED, classes == THING]
    return torch.cat([share(mask) for mask in of], 1), share(classes != VOID)
