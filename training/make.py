#!/usr/bin/env python3
"""Draws the worlds, trains the network, calibrates it and writes its weights and its card.

    python training/make.py --program target/release/fingerpost --out training_run

What is there already is not made again: a run that was stopped goes on where it was. Same seeds, same weights on the same machine. No real
picture is trained on; labelled ones (`--test`) are looked at for the curves and the card alone.
"""

import argparse
import json
import os

import torch

import card
import colours
import worlds
from calibrate import calibrate, measured
from fit import Training
from labelled import LabelledSet
from network import OUTPUTS, Shape
from pictures import drives
from weights import written

# Drives to learn from, to calibrate by, and to measure the calibration on: seeds that have nothing in common.
LEARNED, CALIBRATED, MEASURED = range(1001, 1601), range(9001, 9021), range(9021, 9041)
STEPS, BATCH, SEED = 12_000, 16, 0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="fingerpost, which draws the worlds")
    parser.add_argument("--out", required=True, help="folder of the run")
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--test", action="append", default=[], type=LabelledSet.named, metavar="NAME=IMAGES:LABELS:ROAD:VOID",
                        help="labelled pictures to show the network to, never to learn from")
    parser.add_argument("--look", action="append", default=[], metavar="NAME=IMAGES", help="pictures without labels for the card")
    return parser.parse_args()


def main():
    asked = arguments()
    # One thread sums in one order. A second one draws the next step's pictures.
    torch.set_num_threads(1)
    folder = lambda name: os.path.join(asked.out, name)
    for name, seeds in (("learned", LEARNED), ("calibrated", CALIBRATED), ("measured", MEASURED)):
        worlds.draw(asked.program, folder(name), seeds)

    training = Training(Shape(), asked.steps, BATCH, SEED)
    saved = folder("training.pt")
    if os.path.exists(saved):
        training.load(saved)
    if training.step < training.steps:
        training.run(*drives(folder("learned")), saved, 500, lambda network: {s.name: s.scores(network, every=4)[0] for s in asked.test})
    network = training.network.eval()

    fits = calibrate(network, *drives(folder("calibrated")), seed=1)
    joining = colours.fitted(*colours.samples(network, folder("calibrated"))).tolist()
    facts = {
        "steps": training.steps, "batch": BATCH, "parameters": sum(p.numel() for p in network.parameters()), "calibration": fits, "joining": joining,
        "reliability": measured(network, *drives(folder("measured")), seed=2), "outputs": OUTPUTS, "curve": training.curve,
        "tests": {s.name: dict(zip(("best", "at_even_odds"), s.scores(network))) for s in asked.test},
    }
    data = written(network, joining)
    with open(folder("road_network.weights"), "wb") as file:
        file.write(data)
    with open(folder("card.json"), "w") as file:
        json.dump(facts, file, indent=1)
    sets = [(s.name, s.pictures()) for s in asked.test] + [(name, card.pictures(path)) for name, path in (look.split("=", 1) for look in asked.look)]
    card.write(folder("card.html"), facts, network, [("worlds that were not trained on", card.pictures(folder("measured/*/frames"))), *sets])
    print(f"{folder('road_network.weights')}: {len(data)} bytes; {folder('card.html')}")


if __name__ == "__main__":
    main()
