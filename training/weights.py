"""Weights of a folded network as the program's file (`FPROAD01`), and the network in integers, to hold the program's against."""

import struct

import numpy as np
import torch
import torch.nn.functional as F

from network import INPUT_STEPS, OUTPUTS

# Log-odds leave the network in sixteenths.
PER_LOG_ODDS = 16


def f32(values):
    return np.asarray(values, "<f4").tobytes()


class Layers:
    """The layers in the file's order, as bytes."""

    def __init__(self):
        self.bytes = b""

    def add(self, weights, bias, into_step, out_step, scalars=()):
        """Weights (numpy, channel of output first), bias, step of what comes in and of what goes out."""
        flat = weights.reshape(len(weights), -1)
        steps = np.maximum(np.abs(flat).max(1) / 127, 1e-9)
        whole = np.clip(np.rint(flat / steps[:, None]), -127, 127).astype(np.int8)
        sums_step = steps * into_step
        self.bytes += whole.tobytes() + np.rint(bias / sums_step).astype("<i4").tobytes() + f32(sums_step / out_step) + f32(scalars)


def numbers(tensor):
    return tensor.detach().double().numpy()


def written(network, joining):
    """The file's bytes; `joining` are what the network's log-odds of road count, what those of the drive's colours count, and an offset."""
    assert network.is_folded
    shape, file = network.shape, Layers()
    stem = numbers(network.stem.convolution.weight) * numbers(INPUT_STEPS).reshape(1, -1, 1, 1)
    # Out, row, column, in: the order in which the program's picture lies in memory.
    file.add(stem.transpose(0, 2, 3, 1), numbers(network.stem.bias), 1.0, network.stem_after.step)
    steps = [network.stem_after.step]

    def separable(block, step):
        file.add(numbers(block.depthwise.convolution.weight), numbers(block.depthwise.bias), step, block.between.step)
        residual = [step / block.after.step] if block.residual else []
        file.add(numbers(block.pointwise.convolution.weight), numbers(block.pointwise.bias), block.between.step, block.after.step, residual)
        return block.after.step

    for level in network.levels:
        step = steps[-1]
        for block in level:
            step = separable(block, step)
        steps.append(step)
    context = network.context
    places = shape.width * shape.height // 256
    file.add(numbers(context.pointwise.weight), numbers(context.pointwise.bias), context.mean.step, context.between.step,
             [steps[3] / places / context.mean.step, steps[3] / context.after.step, context.between.step / context.after.step])
    step = context.after.step
    for narrow, merge, level in zip(network.narrows, network.merges, (2, 1, 0)):
        after = narrow.after.step
        file.add(numbers(narrow.pointwise.weight), numbers(narrow.pointwise.bias), step, narrow.step, [narrow.step / 16 / after, steps[level] / after])
        step = separable(merge, after)
    file.add(numbers(network.head.weight), numbers(network.head.bias), step, 1 / PER_LOG_ODDS)
    head = b"FPROAD01" + struct.pack("<2I4f4I3II", shape.width, shape.height, *shape.strip, *shape.channels, *shape.blocks, len(OUTPUTS))
    return head + file.bytes + f32(joining)


class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, kind, *size):
        count = int(np.prod(size))
        out = np.frombuffer(self.data, kind, count, self.at).reshape(size)
        self.at += out.nbytes
        return out


def requantised(sums, bias, multiplier, low=0, extra=None):
    """As the program: single precision, in this order."""
    scaled = (sums + bias.reshape(-1, 1, 1)).astype(np.float32) * multiplier.reshape(-1, 1, 1)
    if extra is not None:
        scaled = scaled + extra[0].astype(np.float32) * extra[1]
    return np.clip(np.rint(scaled), low, 127)


def convolved(x, weights, stride=1, padding=0, groups=1):
    """Sums are whole numbers below 2^53, so double precision is exact."""
    return F.conv2d(torch.from_numpy(x[None].astype(np.float64)), torch.from_numpy(weights.astype(np.float64)), None, stride, padding, groups=groups)[0].numpy()


def integer_log_odds(data, quantised_input):
    """The outputs (sixteenths, outputs x rows x columns) of a file's network for an input of 8 x rows x columns, 0 to 127."""
    read = Reader(data)
    assert read.take("S8", 1)[0] == b"FPROAD01"
    read.take("<u4", 2), read.take("<f4", 4)
    c, blocks, outputs = read.take("<u4", 4), read.take("<u4", 3), int(read.take("<u4", 1)[0])
    arrays = lambda out, *size: (read.take("i1", out, *size), read.take("<i4", out), read.take("<f4", out))
    w, b, m = arrays(c[0], 3, 3, 8)
    fine = [requantised(convolved(quantised_input.astype(np.float64) - 64, w.transpose(0, 3, 1, 2), 2, 1), b, m)]

    def separable(x, into, out, stride=1, residual=False):
        w, b, m = arrays(into, 1, 3, 3)
        y = requantised(convolved(x, w, stride, 1, int(into)), b, m)
        w, b, m = arrays(out, into, 1, 1)
        extra = (x, read.take("<f4", 1)[0]) if residual else None
        return requantised(convolved(y, w), b, m, extra=extra)

    for k in range(3):
        y = separable(fine[-1], c[k], c[k + 1], 2)
        for _ in range(blocks[k]):
            y = separable(y, c[k + 1], c[k + 1], residual=True)
        fine.append(y)
    w, b, m = arrays(c[3], c[3], 1, 1)
    s, of_level, of_context = read.take("<f4", 3)
    mean = np.clip(np.rint(fine[3].sum((1, 2)).astype(np.float32) * s), 0, 127)
    said = requantised(convolved(mean.reshape(-1, 1, 1), w), b, m)
    y = np.clip(np.rint(fine[3].astype(np.float32) * of_level + said.astype(np.float32) * of_context), 0, 127)
    for k in (2, 1, 0):
        w, b, m = arrays(c[k], c[k + 1], 1, 1)
        of_coarse, of_fine = read.take("<f4", 2)
        narrow = requantised(convolved(y, w), b, m, -127)
        doubled = F.interpolate(torch.from_numpy(narrow[None]), scale_factor=2, mode="bilinear", align_corners=False)[0].numpy() * 16
        y = np.clip(np.rint(doubled.astype(np.float32) * of_coarse + fine[k].astype(np.float32) * of_fine), 0, 127)
        y = separable(y, c[k], c[k])
    w, b, m = arrays(outputs, c[0], 1, 1)
    out = requantised(convolved(y, w), b, m, -127)
    assert read.at + 12 == len(data)
    return out
