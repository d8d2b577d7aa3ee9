"""The road network: its inputs, its layers, and the same layers in the integers of the program.

Shapes are batch x channels x rows x columns. Every activation is a non-negative number, because the program keeps it in seven bits
(`crates/fingerpost-vision/src/road_network`): what a layer gives is cut off at zero.
"""

from dataclasses import dataclass

import torch
import torch.nn as nn
import torch.nn.functional as F

# What the network says of a place, in the order of its outputs.
OUTPUTS = ("road", "paint", "raised", "hidden")


@dataclass(frozen=True)
class Shape:
    """Sizes of a network."""

    width: int = 256
    height: int = 144
    # The strip of road whose tone all else is compared with: top, bottom, left, right, shares of the picture.
    strip: tuple = (0.72, 0.95, 0.35, 0.65)
    channels: tuple = (16, 32, 64, 128)
    blocks: tuple = (1, 2, 3)


# Limits of the inputs; the program quantises each to 63 steps on either side of zero.
LIMITS = torch.tensor([3.0, 3.0, 3.0, 2.0, 2.0, 2.0, 1.0, 0.5])
# A step of an input, as the program has it.
INPUT_STEPS = LIMITS / 63


def inputs(pictures, shape):
    """Eight channels from pictures (n x 3 x h x w, 0 to 1): each colour against the strip of road just ahead, so that what road looks
    like today comes from the picture itself, as in histogram back-projection; chroma; brightness against the strip; row; brightness."""
    n, _, h, w = pictures.shape
    top, bottom, left, right = shape.strip
    strip = pictures[:, :, int(top * h):int(bottom * h), int(left * w):int(right * w)]
    mean = strip.mean((2, 3), keepdim=True)
    spread = strip.std((2, 3), keepdim=True, correction=0)
    against = (pictures - mean) / (4 * (spread + 0.03))
    total = pictures.sum(1, keepdim=True)
    chroma = ((pictures[:, :2] + 0.016) / (total + 0.05) - 0.333) * 4
    grey, strip_grey = total / 3, mean.sum(1, keepdim=True) / 3
    brightness = torch.log(grey + 0.02) - torch.log(strip_grey + 0.02)
    row = torch.linspace(-1, 1, h, device=pictures.device).view(1, 1, h, 1).expand(n, 1, h, w)
    channels = torch.cat([against, chroma, brightness, row, grey - 0.5], 1)
    limits = LIMITS.view(1, -1, 1, 1)
    steps = INPUT_STEPS.view(1, -1, 1, 1)
    # Straight through the rounding: the network learns on the very numbers that the program gives it.
    return torch.round(channels.clamp(-limits, limits) / steps) * steps


class Range(nn.Module):
    """The largest magnitude that passes through, followed while `is_measured`: the steps of whole numbers are shares of it."""

    def __init__(self):
        super().__init__()
        self.register_buffer("largest", torch.tensor(0.0))
        self.is_measured = False

    def measure(self, x):
        if self.training and self.is_measured:
            # Every place of some pictures, every some of the places: a quantile needs no more.
            seen = torch.quantile(x.detach()[::3, :, ::3, ::3].abs().flatten().float(), 0.9995)
            self.largest.copy_(seen if self.largest == 0 else self.largest.lerp(seen, 0.02))

    def rounded(self, x):
        """In whole steps up to the largest; gradients pass straight through."""
        step = (self.largest / 127).clamp_min(1e-6)
        cut = x.clamp(-float(self.largest), float(self.largest)) / step
        return (cut + (torch.round(cut) - cut).detach()) * step

    @property
    def step(self):
        return float(self.largest) / 127


class Quantised(Range):
    """An activation of seven bits: cut off at zero and at the largest value, and rounded once `is_folded`."""

    def __init__(self):
        super().__init__()
        self.is_folded = False

    def forward(self, x):
        x = F.relu(x)
        self.measure(x)
        return self.rounded(x) if self.is_folded else x


def rounded_weights(weights):
    """Weights rounded to eight bits, a step a channel of output; gradients pass straight through."""
    step = (weights.detach().abs().amax((1, 2, 3), keepdim=True) / 127).clamp_min(1e-9)
    return weights + (torch.round(weights / step).clamp(-127, 127) * step - weights).detach()


class Convolution(nn.Module):
    """A convolution and its normalisation, which is folded into the weights once `is_folded`."""

    def __init__(self, into, out, size, stride=1, groups=1):
        super().__init__()
        self.convolution = nn.Conv2d(into, out, size, stride, size // 2, groups=groups, bias=False)
        self.normalisation = nn.BatchNorm2d(out)
        self.is_folded = False
        self.bias = None

    def fold(self):
        """Makes the normalisation a part of weights and bias, and rounds the weights from now on."""
        norm = self.normalisation
        scale = (norm.weight / torch.sqrt(norm.running_var + norm.eps)).detach()
        self.convolution.weight.data *= scale.view(-1, 1, 1, 1)
        self.bias = nn.Parameter((norm.bias - norm.running_mean * scale).detach())
        self.normalisation = None
        self.is_folded = True

    def forward(self, x):
        if not self.is_folded:
            return self.normalisation(self.convolution(x))
        c = self.convolution
        return F.conv2d(x, rounded_weights(c.weight), self.bias, c.stride, c.padding, groups=c.groups)


class Separable(nn.Module):
    """Each channel's 3 x 3 neighbourhood, then all channels of a place; with `residual` what came in is added."""

    def __init__(self, into, out, stride=1, residual=False):
        super().__init__()
        self.depthwise = Convolution(into, into, 3, stride, into)
        self.between = Quantised()
        self.pointwise = Convolution(into, out, 1)
        self.after = Quantised()
        self.residual = residual

    def forward(self, x):
        y = self.pointwise(self.between(self.depthwise(x)))
        return self.after(y + x if self.residual else y)


class Context(nn.Module):
    """What the whole picture has to say to every place."""

    def __init__(self, channels):
        super().__init__()
        self.mean = Quantised()
        self.pointwise = nn.Conv2d(channels, channels, 1)
        self.between = Quantised()
        self.after = Quantised()
        self.is_folded = False

    def forward(self, x):
        weights = rounded_weights(self.pointwise.weight) if self.is_folded else self.pointwise.weight
        y = self.between(F.conv2d(self.mean(x.mean((2, 3), keepdim=True)), weights, self.pointwise.bias))
        return self.after(x + y)


class Narrow(Range):
    """A level with the channels of the finer one below it, at its resolution, added to it."""

    def __init__(self, into, out):
        super().__init__()
        self.pointwise = nn.Conv2d(into, out, 1)
        self.after = Quantised()
        self.is_folded = False

    def forward(self, coarse, fine):
        weights = rounded_weights(self.pointwise.weight) if self.is_folded else self.pointwise.weight
        y = F.conv2d(coarse, weights, self.pointwise.bias)
        self.measure(y)
        y = self.rounded(y) if self.is_folded else y
        return self.after(fine + F.interpolate(y, scale_factor=2, mode="bilinear", align_corners=False))


class RoadNetwork(nn.Module):
    """Log-odds of [`OUTPUTS`] at half the picture's resolution, from [`inputs`]."""

    def __init__(self, shape=Shape()):
        super().__init__()
        self.shape = shape
        c = shape.channels
        self.stem = Convolution(len(LIMITS), c[0], 3, 2)
        self.stem_after = Quantised()
        self.levels = nn.ModuleList(
            nn.ModuleList([Separable(c[k], c[k + 1], stride=2)]
                          + [Separable(c[k + 1], c[k + 1], residual=True) for _ in range(shape.blocks[k])])
            for k in range(3))
        self.context = Context(c[3])
        self.narrows = nn.ModuleList(Narrow(c[k + 1], c[k]) for k in (2, 1, 0))
        self.merges = nn.ModuleList(Separable(c[k], c[k]) for k in (2, 1, 0))
        self.head = nn.Conv2d(c[0], len(OUTPUTS), 1)
        self.is_folded = False

    def forward(self, x):
        fine = [self.stem_after(self.stem(x))]
        for level in self.levels:
            y = fine[-1]
            for block in level:
                y = block(y)
            fine.append(y)
        y = self.context(fine[3])
        for narrow, merge, level in zip(self.narrows, self.merges, (2, 1, 0)):
            y = merge(narrow(y, fine[level]))
        weights = rounded_weights(self.head.weight) if self.is_folded else self.head.weight
        return F.conv2d(y, weights, self.head.bias)

    def measure(self):
        """From here on the ranges of the activations are followed, which [`fold`] rounds by."""
        for module in self.modules():
            if isinstance(module, Range):
                module.is_measured = True
        return self

    def fold(self):
        """From here on the network computes as the program does: normalisations folded, weights of eight bits, activations of seven."""
        self.is_folded = True
        for module in self.modules():
            if isinstance(module, Convolution):
                module.fold()
            elif isinstance(module, (Quantised, Context, Narrow)):
                module.is_folded = True
        return self
