"""Training: drawn crops on drawn days, in floating point first, then in the program's own arithmetic."""

import json
import os
import time

import numpy as np
import torch
import torch.nn.functional as F

from days import Days
from network import RoadNetwork, inputs
from pictures import crops, targets

# Share of the steps at the end for which the network computes in whole numbers.
FOLDED_SHARE = 0.12
# How much each output's error counts: road is what the program lives on.
COUNTS = torch.tensor([1.0, 0.4, 0.3, 0.3]).view(1, -1, 1, 1)


def loss_of(said, wanted, shown):
    errors = F.binary_cross_entropy_with_logits(said, wanted, reduction="none") * COUNTS * shown
    return errors.sum() / (shown.sum() * COUNTS.sum())


class Training:
    """What a step needs; saved whole every so often, so that a training that was stopped goes on where it was."""

    def __init__(self, shape, steps, batch, seed):
        torch.manual_seed(seed)
        self.shape, self.steps, self.batch, self.seed = shape, steps, batch, seed
        self.network = RoadNetwork(shape).to(memory_format=torch.channels_last)
        self.step, self.curve = 0, []
        self.restart_optimiser()

    @property
    def folds_at(self):
        return int(self.steps * (1 - FOLDED_SHARE))

    def restart_optimiser(self):
        folded = self.network.is_folded
        peak = 4e-4 if folded else 4e-3
        total = self.steps - self.folds_at if folded else self.folds_at
        self.optimiser = torch.optim.AdamW(self.network.parameters(), peak, weight_decay=0 if folded else 1e-4)
        self.rate = torch.optim.lr_scheduler.OneCycleLR(self.optimiser, peak, total_steps=total + 1)

    def save(self, path):
        state = {"step": self.step, "curve": self.curve, "network": self.network.state_dict(), "optimiser": self.optimiser.state_dict(),
                 "rate": self.rate.state_dict(), "folded": self.network.is_folded}
        torch.save(state, path + ".part")
        os.replace(path + ".part", path)

    def load(self, path):
        state = torch.load(path, weights_only=True)
        if state["folded"]:
            self.network.fold()
            self.restart_optimiser()
        self.network.load_state_dict(state["network"])
        self.optimiser.load_state_dict(state["optimiser"])
        self.rate.load_state_dict(state["rate"])
        self.step, self.curve = state["step"], state["curve"]

    def run(self, pictures, classes, path, every=250, watch=lambda network: {}):
        began, before = time.time(), self.step
        while self.step < self.steps:
            if self.step == self.folds_at and not self.network.is_folded:
                self.network.fold()
                self.restart_optimiser()
            # Each step draws from a stream of its own, so that where a training was stopped does not matter.
            rng = np.random.default_rng((self.seed, self.step))
            x, c = Days(self.shape, int(rng.integers(1 << 31)))(*crops(pictures, classes, self.batch, self.shape, rng))
            self.network.train()
            said = self.network(inputs(x, self.shape).contiguous(memory_format=torch.channels_last))
            loss = loss_of(said, *targets(c))
            self.optimiser.zero_grad()
            loss.backward()
            self.optimiser.step()
            self.rate.step()
            self.step += 1
            if self.step % every == 0 or self.step == self.steps:
                self.network.eval()
                seen = watch(self.network)
                self.curve.append({"step": self.step, "loss": float(loss.detach()), **seen})
                seconds = (time.time() - began) / (self.step - before)
                print(json.dumps(self.curve[-1]), f"{seconds:.2f} s a step", flush=True)
                self.save(path)
