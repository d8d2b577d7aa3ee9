"""Real pictures with labels, to test and to choose by; nothing is trained on them."""

import glob
import os
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image

from network import inputs


# Where the horizon is taken to be where it is not known, as a share of the height, and how much of what the network looks at lies above it
# (`road_surface/looked_at.rs`).
HORIZON, ABOVE = 1 / 3, 0.25


def first_row(height, horizon=HORIZON):
    """The first row of a picture that the network looks at."""
    return int(max(height - height * (1 - horizon) / (1 - ABOVE), 0))


def prepared(path, shape, horizon=HORIZON):
    """What the network looks at of a picture, at its size, 1 x 3 x h x w, levels 0 to 1."""
    picture = torch.from_numpy(np.asarray(Image.open(path).convert("RGB")).copy()).permute(2, 0, 1)[None].float()
    picture = picture[:, :, first_row(picture.shape[2], horizon):]
    size = (shape.height, shape.width)
    return torch.round(F.interpolate(picture, size=size, mode="bilinear", antialias=True)) / 255


def log_odds(network, path, horizon=HORIZON):
    """The network's outputs (n x h/2 x w/2) for what it looks at of a picture."""
    with torch.no_grad():
        return network(inputs(prepared(path, network.shape, horizon), network.shape))[0]


@dataclass(frozen=True)
class LabelledSet:
    """A folder of pictures and one of labels of the same names: grey pictures whose levels are classes."""

    name: str
    images: str
    labels: str
    road: int
    void: int

    @classmethod
    def named(cls, text):
        """From `NAME=IMAGES:LABELS:ROAD:VOID`."""
        name, rest = text.split("=", 1)
        images, labels, road, void = rest.split(":")
        return cls(name, images, labels, int(road), int(void))

    def pictures(self):
        return sorted(glob.glob(f"{self.images}/*"))

    def said_and_true(self, network, every=1):
        """Log-odds of road and whether it is road, of all pixels with a label, rows below a third."""
        said, true = [], []
        for path in self.pictures()[::every]:
            label = np.asarray(Image.open(f"{self.labels}/{os.path.basename(path)}"))
            top, first = first_row(len(label)), len(label) // 3
            size = (len(label) - top, label.shape[1])
            y = F.interpolate(log_odds(network, path)[None, :1], size=size, mode="bilinear")[0, 0].numpy()
            known = label[first:] != self.void
            said.append(y[first - top:][known])
            true.append((label[first:] == self.road)[known])
        return np.concatenate(said), np.concatenate(true)

    def scores(self, network, every=1):
        """Intersection over union at the best threshold and at even odds, one threshold for the set."""
        said, true = self.said_and_true(network, every)
        at = lambda odds: ((said > odds) & true).sum() / ((said > odds) | true).sum()
        return float(max(at(o) for o in np.linspace(-4, 4, 33))), float(at(0.0))
