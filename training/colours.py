"""The drive's own colours beside the network: the computation of the program (`crates/fingerpost/src/road_surface/drive_colours.rs`), and
what either counts, fitted on drives that were not trained on."""

import glob
import os

import numpy as np
from PIL import Image

from labelled import ABOVE, first_row, log_odds, prepared
from pictures import PAINT, ROAD, VOID, horizons

BINS = 24
KEPT, DOUBT = np.float32(0.9), np.float32(0.002)


def named(picture):
    """The colour of each place (h/2 x w/2) of a picture (h x w x 3, whole levels): as a number below BINS cubed."""
    h, w, _ = picture.shape
    sums = picture.astype(np.int64).reshape(h // 2, 2, w // 2, 2, 3).sum((1, 3))
    total = sums.sum(-1)
    chromaticity = lambda c: np.clip(72 * sums[..., c] // (total + 12), 12, 11 + BINS) - 12
    log = np.log(total / (4.0 * 255.0) + 0.05)
    brightness = np.clip((log / 2.2 + 1.0) / 1.6 * BINS, 0, BINS - 1).astype(np.int64)
    return (chromaticity(0) * BINS + chromaticity(2)) * BINS + brightness


def spread(counts):
    """Over neighbours along each axis, with weights 1, 2, 1; what would leave the ends stays there."""
    for axis in (2, 1, 0):
        around = np.pad(counts, [(1, 1) if a == axis else (0, 0) for a in range(3)], mode="edge")
        part = lambda first: np.take(around, np.arange(first, first + BINS), axis)
        counts = np.float32(0.25) * part(0) + np.float32(0.5) * part(1) + np.float32(0.25) * part(2)
    return counts


class DriveColours:
    """What was counted on a drive so far."""

    def __init__(self):
        self.road, self.beside = (np.zeros(BINS**3, np.float32) for _ in range(2))

    def see(self, picture, road, first_row):
        """Log-odds (h/2 x w/2) that colours add, from a picture (h x w x 3, whole levels) and the network's log-odds of road; rows before
        `first_row` show no ground."""
        colours = named(picture)
        ground, sure = np.s_[first_row:], np.tanh(road / 2)
        for name, share in (("road", np.maximum(sure, 0)), ("beside", np.maximum(-sure, 0))):
            new = np.bincount(colours[ground].ravel(), share[ground].ravel(), BINS**3).astype(np.float32)
            setattr(self, name, getattr(self, name) * KEPT + new)
        totals = self.road.sum(), self.beside.sum()
        if min(totals) < 1:
            return np.zeros_like(road, dtype=np.float32)
        on_road, beside = (spread(c.reshape(BINS, BINS, BINS)).ravel() for c in (self.road, self.beside))
        ratio = np.log((on_road / totals[0] + DOUBT) / (beside / totals[1] + DOUBT))
        return ratio[colours].astype(np.float32)


def whole_levels(path, shape, horizon):
    """What the network looks at of a picture, at its size, h x w x 3, whole levels."""
    return (prepared(path, shape, horizon)[0].permute(1, 2, 0).numpy() * 255).round().astype(np.uint8)


def first_ground(rows):
    """The first of so many rows of the network's output that shows ground."""
    return int(np.ceil(ABOVE * rows))


def drive(network, paths, horizon):
    """For each picture of a drive: the network's log-odds of road, in the program's steps, and what colours add."""
    colours = DriveColours()
    for path in paths:
        road = np.clip(np.rint(log_odds(network, path, horizon)[0].numpy() * 16), -127, 127) / 16
        yield road, colours.see(whole_levels(path, network.shape, horizon), road, first_ground(len(road)))


def samples(network, folder):
    """Log-odds of the network, what colours add, and whether it is road, of all places below the horizon of all drives in a folder."""
    said, added, true = [], [], []
    for one in sorted(glob.glob(f"{folder}/*")):
        paths = sorted(glob.glob(f"{one}/frames/*"))
        truth = [np.asarray(Image.open(os.path.splitext(p.replace("/frames/", "/classes/"))[0] + ".png")) for p in paths]
        horizon = float(np.median(horizons(np.stack(truth)))) / len(truth[0])
        # A camera that looks at its feet shows no horizon, and one that sees no ground nothing to learn from.
        horizon = min(max(horizon, 0.0), 0.8)
        for shown, (road, colours) in zip(truth, drive(network, paths, horizon)):
            classes = Image.fromarray(shown[first_row(len(shown), horizon):])
            classes = np.asarray(classes.resize(road.shape[::-1], Image.NEAREST))
            ground = np.s_[first_ground(len(road)):]
            seen = classes[ground] != VOID
            said.append(road[ground][seen])
            added.append(colours[ground][seen])
            true.append(((classes == ROAD) | (classes == PAINT))[ground][seen])
    return np.concatenate(said), np.concatenate(added), np.concatenate(true)


def fitted(said, added, true):
    """What the network counts, what colours count, and an offset: logistic regression by Newton's method."""
    x = np.stack([said, added, np.ones_like(said)], 1).astype(float)
    counts = np.array([1.0, 0.0, 0.0])
    for _ in range(30):
        p = 1 / (1 + np.exp(-x @ counts))
        counts += np.linalg.solve((x * (p * (1 - p))[:, None]).T @ x + 1e-9 * np.eye(3), x.T @ (true - p))
    return counts
