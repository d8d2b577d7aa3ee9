"""Real pictures with labels, to test and to choose by; nothing is trained on them."""

import glob
import os

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image

from network import inputs


def prepared(path, shape):
    """A picture at the network's size, 1 x 3 x h x w, levels 0 to 1."""
    picture = torch.from_numpy(np.asarray(Image.open(path).convert("RGB")).copy()).permute(2, 0, 1)[None].float()
    size = (shape.height, shape.width)
    return torch.round(F.interpolate(picture, size=size, mode="bilinear", antialias=True)) / 255


def log_odds(network, path):
    with torch.no_grad():
        return network(inputs(prepared(path, network.shape), network.shape))[0]


def road_scores(network, images, labels, road, void, every=1):
    """Intersection over union at the best threshold and at even odds, rows below a third, one threshold for the set."""
    said, true = [], []
    for path in sorted(glob.glob(f"{images}/*"))[::every]:
        label = np.asarray(Image.open(f"{labels}/{os.path.basename(path)}"))
        y = F.interpolate(log_odds(network, path)[None, :1], size=label.shape, mode="bilinear")[0, 0].numpy()
        first = len(label) // 3
        known = label[first:] != void
        said.append(y[first:][known])
        true.append((label[first:] == road)[known])
    said, true = np.concatenate(said), np.concatenate(true)
    at = lambda odds: ((said > odds) & true).sum() / ((said > odds) | true).sum()
    return float(max(at(o) for o in np.linspace(-4, 4, 33))), float(at(0.0))
