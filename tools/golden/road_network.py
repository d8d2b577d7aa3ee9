#!/usr/bin/env python3
"""Writes the golden files of the road network's kernels: what PyTorch makes of the same numbers.

    pip install numpy torch
    python3 tools/golden/road_network.py crates/fingerpost-vision/tests/golden

    road_network.weights    a network of random numbers, WIDTH x HEIGHT pixels
    road_network.rgb        pictures, PICTURES of them
    road_network.i8         the logits of each: outputs, rows, columns

Sums are PyTorch's, in 64-bit floating point, which has all whole numbers that come up; the input's formulas and what is scaled
back to 7 bits are in 32 bits, as the program has them. All numbers are little-endian.
"""

import pathlib
import struct
import sys

import numpy as np
import torch
import torch.nn.functional as F

WIDTH, HEIGHT, PICTURES = 48, 32, 3
STRIP = (0.86, 1.0, 0.36, 0.64)  # top, bottom, left, right
CHANNELS, BLOCKS, OUTPUTS = (16, 32, 16, 48), (1, 0, 2), 4
LIMITS = (3.0, 3.0, 3.0, 2.0, 2.0, 2.0, 1.0, 0.5)

random = np.random.default_rng(17)
written = bytearray(b"FPROAD01")
f32 = np.float32


class Layer:
    """Weights, biases and multipliers, written as they are drawn."""

    def __init__(self, shape, scales=()):
        inputs = int(np.prod(shape[1:]))
        self.weights = random.integers(-127, 128, shape).astype(np.int8)
        self.bias = random.integers(-1000, 3000, shape[0]).astype(np.int32)
        # So that sums spread over all activations, some beyond them.
        self.multiplier = (random.uniform(0.2, 1.2, shape[0]) / (32 * inputs**0.5)).astype(f32)
        self.scales = np.array(scales, f32)
        for numbers in (self.weights, self.bias, self.multiplier, self.scales):
            written.extend(numbers.tobytes())

    def convolve(self, x, low=0, added=None, **options):
        weights = self.weights.astype(np.float64)
        if weights.ndim == 2:
            weights = weights[:, :, None, None]
        elif weights.ndim == 3:
            weights = weights[:, None]
            options["groups"] = len(weights)
        elif weights.shape[-1] == 8:
            weights = weights.transpose(0, 3, 1, 2)
        sums = F.conv2d(torch.from_numpy(x.astype(np.float64)), torch.from_numpy(weights), **options).numpy()
        sums = (sums + self.bias[None, :, None, None]).astype(f32) * self.multiplier[None, :, None, None]
        return rounded(sums if added is None else sums + added, low)


def rounded(values, low=0):
    assert values.dtype == f32
    return np.clip(np.rint(values), low, 127).astype(np.int64)


def separable(layers, x, stride=1):
    depthwise, pointwise = layers
    between = depthwise.convolve(x, stride=stride, padding=1)
    added = x.astype(f32) * pointwise.scales[0] if len(pointwise.scales) else None
    return pointwise.convolve(between, added=added)


def draw_separable(i, o, scales=()):
    return Layer((i, 3, 3)), Layer((o, i), scales)


def features(rgb):
    """The network's input, channels first, 0 for 0."""
    x = rgb.astype(f32) / f32(255)
    rows = slice(int(STRIP[0] * HEIGHT), int(STRIP[1] * HEIGHT))
    columns = slice(int(STRIP[2] * WIDTH), int(STRIP[3] * WIDTH))
    strip = rgb[rows, columns].astype(np.float64)
    mean, spread = (strip.mean((0, 1)) / 255).astype(f32), (strip.std((0, 1)) / 255).astype(f32)
    total = rgb.astype(np.int64).sum(2).astype(f32) / f32(255)
    grey = total / f32(3)
    log = lambda g: np.log((g + f32(0.02)).astype(np.float64)).astype(f32)
    row = f32(-1) + f32(2) * np.arange(HEIGHT, dtype=f32) / f32(HEIGHT - 1)
    chroma = [((x[..., c] + f32(0.016)) / (total + f32(0.05)) - f32(0.333)) * f32(4) for c in (0, 1)]
    planes = [(x[..., c] - mean[c]) / (f32(4) * (spread[c] + f32(0.03))) for c in range(3)] + chroma
    strip_grey = (mean[0] + mean[1] + mean[2]) / f32(3)
    planes += [log(grey) - log(strip_grey), np.repeat(row[:, None], WIDTH, 1), grey - f32(0.5)]
    limited = [np.clip(p, f32(-l), f32(l)) * f32(63) / f32(l) for p, l in zip(planes, LIMITS)]
    return np.rint(np.stack(limited)).astype(np.int64)[None]


def main(folder):
    written.extend(struct.pack("<2I4f8I", WIDTH, HEIGHT, *STRIP, *CHANNELS, *BLOCKS, OUTPUTS))
    c = CHANNELS
    stem = Layer((c[0], 3, 3, 8))
    down = []
    for k in range(3):
        halving = draw_separable(c[k], c[k + 1])
        down.append((halving, [draw_separable(c[k + 1], c[k + 1], (0.71,)) for _ in range(BLOCKS[k])]))
    places = (WIDTH // 16) * (HEIGHT // 16)
    context = Layer((c[3], c[3]), (0.9 / places, 0.8, 0.33))
    up = [(Layer((c[k], c[k + 1]), (0.041, 0.62)), draw_separable(c[k], c[k])) for k in (2, 1, 0)]
    head = Layer((OUTPUTS, c[0]))

    # Patches, slopes and noise.
    shape = (PICTURES, HEIGHT, WIDTH, 3)
    patches = random.integers(0, 256, (PICTURES, HEIGHT // 8, WIDTH // 8, 3)).repeat(8, 1).repeat(8, 2)
    slopes = np.linspace(-60, 60, WIDTH)[None, None, :, None]
    pictures = np.clip(patches + slopes + random.normal(0, 12, shape), 0, 255).astype(np.uint8)

    logits = []
    for picture in pictures:
        levels = [stem.convolve(features(picture), stride=2, padding=1)]
        for halving, blocks in down:
            x = separable(halving, levels[-1], stride=2)
            for block in blocks:
                x = separable(block, x)
            levels.append(x)
        x = levels[3]
        mean = rounded(x.sum((2, 3), keepdims=True).astype(f32) * context.scales[0])
        said = context.convolve(mean).astype(f32)
        x = rounded(x.astype(f32) * context.scales[1] + said * context.scales[2])
        for (narrow, merge), level in zip(up, levels[2::-1]):
            narrowed = torch.from_numpy(narrow.convolve(x, low=-127).astype(np.float64))
            doubled = 16 * F.interpolate(narrowed, scale_factor=2, mode="bilinear", align_corners=False).numpy()
            assert (doubled == np.rint(doubled)).all()
            joined = doubled.astype(f32) * narrow.scales[0] + level.astype(f32) * narrow.scales[1]
            x = separable(merge, rounded(joined))
        logits.append(head.convolve(x, low=-127).astype(np.int8))
        saturated = (abs(logits[-1].astype(int)) == 127).mean()
        print(f"logits: mean {logits[-1].mean():.1f}, spread {logits[-1].std():.1f}, {saturated:.0%} saturated")

    folder = pathlib.Path(folder)
    (folder / "road_network.weights").write_bytes(written)
    (folder / "road_network.rgb").write_bytes(pictures.tobytes())
    (folder / "road_network.i8").write_bytes(np.concatenate(logits).tobytes())


if __name__ == "__main__":
    main(sys.argv[1])
