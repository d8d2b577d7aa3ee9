"""Log-odds that are right as often as they say: a slope and an offset for each output, fitted on worlds that were not trained on.

Fitted to the places' shares by logistic regression (Platt 1999, "Probabilistic outputs for support vector machines"); of road the places at
edges count as much as all the others together, because an offset moves edges and nothing else that matters.
"""

import numpy as np
import torch
import torch.nn.functional as F

from days import Days
from network import OUTPUTS, inputs
from pictures import crops, targets

# Pictures that are looked at, and how far an edge reaches, places of the network's output.
PICTURES, EDGE = 384, 2


def said_and_true(network, pictures, classes, seed):
    """Log-odds, shares of each output, and whether an edge of it is near, of every place that shows anything (lists of outputs), on days of
    their own."""
    said, true, near, seen = [], [], [], []
    for part in range(PICTURES // 16):
        rng = np.random.default_rng((seed, part))
        x, c = Days(network.shape, int(rng.integers(1 << 31)))(*crops(pictures, classes, 16, network.shape, rng))
        wanted, shown = targets(c)
        with torch.no_grad():
            said.append(network(inputs(x, network.shape)))
        size = 2 * EDGE + 1
        spread = F.max_pool2d(wanted, size, 1, EDGE) + F.max_pool2d(-wanted, size, 1, EDGE)
        true.append(wanted)
        near.append(spread > 0.5)
        seen.append(shown[:, 0] > 0.5)
    is_seen = torch.cat(seen).flatten()
    rows = lambda parts: [row[is_seen] for row in torch.cat(parts).transpose(0, 1).flatten(1)]
    return rows(said), rows(true), rows(near)


def fitted(said, true, weight):
    """Slope and offset by Newton's method, its steps halved until they lead down."""
    weight = weight.double() / weight.sum()
    x = torch.stack([said, torch.ones_like(said)], 1).double()
    loss = lambda w: (F.binary_cross_entropy_with_logits(x @ w, true.double(), reduction="none") * weight).sum()
    w = torch.tensor([1.0, 0.0], dtype=torch.float64)
    for _ in range(30):
        p = torch.sigmoid(x @ w)
        gradient = x.T @ ((p - true) * weight)
        curvature = (x * (p * (1 - p) * weight)[:, None]).T @ x + 1e-9 * torch.eye(2, dtype=torch.float64)
        step, before = torch.linalg.solve(curvature, gradient), loss(w)
        while loss(w - step) > before and step.abs().max() > 1e-9:
            step = step / 2
        w = w - step
    return w


def calibrate(network, pictures, classes, seed):
    """Fits and builds slope and offset into the last layer. Gives them, by output."""
    said, true, at_edge = said_and_true(network, pictures, classes, seed)
    fits = {}
    for i, name in enumerate(OUTPUTS):
        # Of road the edges are what is measured on; of the others, whether they are there at all.
        edges = at_edge[i].double() * len(said[i]) / at_edge[i].sum().clamp_min(1) if name == "road" else 0
        slope, offset = fitted(said[i], true[i], edges + torch.ones_like(said[i])).tolist()
        network.head.weight.data[i] *= slope
        network.head.bias.data[i] = network.head.bias.data[i] * slope + offset
        fits[name] = [slope, offset]
    return fits


def reliability(said, true):
    """For each tenth of the probability: its mean, how much of what was called that is true, and how many places were; none where none was."""
    p = torch.sigmoid(said)
    bins = (p * 10).long().clamp(0, 9)
    add = lambda of: torch.zeros(10).scatter_add_(0, bins, of)
    return [[float(m / n), float(h / n), int(n)] if n > 0 else None for m, h, n in zip(add(p), add(true), add(torch.ones_like(p)))]


def measured(network, pictures, classes, seed):
    """The reliability of every output on worlds of their own, and intersection over union of road at even odds."""
    said, true, _ = said_and_true(network, pictures, classes, seed)
    road, is_road = said[0] > 0, true[0] > 0.5
    by_output = {name: reliability(said[i], true[i]) for i, name in enumerate(OUTPUTS)}
    return {"by_output": by_output, "road_iou": float((road & is_road).sum() / (road | is_road).sum())}
