"""Training: drawn crops on drawn days; on small pictures first, then on those of the network's size, last in the program's arithmetic."""

import json
import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import torch
import torch.nn.functional as F

from days import Days
from network import RoadNetwork, inputs
from pictures import crops, targets

# Shares of the steps: at the start on small pictures, which cost a third; at the end with the ranges of the activations measured, and then
# in whole numbers.
SMALL_SHARE, MEASURED_SHARE, FOLDED_SHARE = 0.68, 0.06, 0.04
# Size of the small pictures: whole multiples of the coarsest level's places, of nearly the network's aspect.
SMALL = (144, 80)
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

    def drawn(self, pictures, classes, step):
        """Inputs and targets of a step. Each step draws from a stream of its own, so that neither where a training was stopped nor which
        thread draws matters."""
        rng = np.random.default_rng((self.seed, step))
        is_small = step < self.steps * SMALL_SHARE
        shape = replace(self.shape, width=SMALL[0], height=SMALL[1]) if is_small else self.shape
        x, c = Days(shape, int(rng.integers(1 << 31)))(*crops(pictures, classes, self.batch, shape, rng))
        return inputs(x, shape).contiguous(memory_format=torch.channels_last), targets(c)

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

    def advance(self, x, wanted):
        """One step; gives its loss."""
        if self.step >= self.steps * (1 - MEASURED_SHARE):
            self.network.measure()
        if self.step == self.folds_at and not self.network.is_folded:
            self.network.fold()
            self.restart_optimiser()
        self.network.train()
        loss = loss_of(self.network(x), *wanted)
        self.optimiser.zero_grad()
        loss.backward()
        self.optimiser.step()
        self.rate.step()
        self.step += 1
        return float(loss.detach())

    def run(self, pictures, classes, path, every=250, watch=lambda network: {}):
        """Trains to the end; after `every` steps what `watch` says of the network joins the curve, and all is saved at `path`."""
        began, before, losses = time.time(), self.step, []
        with ThreadPoolExecutor(1) as ahead:
            next_batch = ahead.submit(self.drawn, pictures, classes, self.step)
            while self.step < self.steps:
                batch = next_batch.result()
                next_batch = ahead.submit(self.drawn, pictures, classes, self.step + 1)
                losses.append(self.advance(*batch))
                if self.step % every == 0 or self.step == self.steps:
                    self.network.eval()
                    self.curve.append({"step": self.step, "loss": float(np.mean(losses)), **watch(self.network)})
                    losses.clear()
                    seconds = (time.time() - began) / (self.step - before)
                    print(json.dumps(self.curve[-1]), f"{seconds:.2f} s a step", flush=True)
                    self.save(path)
