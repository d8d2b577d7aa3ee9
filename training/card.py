"""What a training came to: the model card with its curves and pictures."""


import numpy as np
import torch.nn.functional as F
import torch
from PIL import Image

from labelled import log_odds

# Colours of what is drawn over a picture: road, raised ground, hidden ground, paint.
COLOURS = {0: (40, 200, 90), 2: (230, 60, 200), 3: (40, 80, 230), 1: (255, 230, 0)}


def overlay(network, path, width=320, height=180):
    """A picture with what the network says of each place laid over it, as strongly as it is sure."""
    y = torch.sigmoid(F.interpolate(log_odds(network, path)[None], size=(height, width), mode="bilinear"))[0].numpy()
    picture = np.asarray(Image.open(path).convert("RGB").resize((width, height), Image.BILINEAR)).astype(np.float32)
    for output, colour in COLOURS.items():
        share = 0.6 * np.clip(2 * y[output] - 1, 0, 1)[..., None]
        picture = picture * (1 - share) + np.array(colour, np.float32) * share
    return Image.fromarray(picture.astype(np.uint8))


def sheet(network, paths, out, columns=6):
    """A contact sheet of overlays."""
    tiles = [overlay(network, path) for path in paths]
    rows = -(-len(tiles) // columns)
    page = Image.new("RGB", (320 * columns, 180 * rows))
    for i, tile in enumerate(tiles):
        page.paste(tile, (i % columns * 320, i // columns * 180))
    page.save(out)


def curve(points, name, width=640, height=220):
    """A line of an SVG over the steps; values between their least and largest."""
    steps = [p["step"] for p in points]
    values = [p[name] for p in points]
    low, high = min(values), max(values)
    place = lambda s, v: f"{40 + (width - 50) * s / max(steps):.1f},{10 + (height - 40) * (high - v) / max(high - low, 1e-9):.1f}"
    line = " ".join(place(s, v) for s, v in zip(steps, values))
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" role="img" aria-label="{name} over the steps">'
            f'<polyline points="{line}" fill="none" stroke="#1565c0" stroke-width="2"/>'
            f'<text x="2" y="16" font-size="12">{high:.3g}</text><text x="2" y="{height - 30}" font-size="12">{low:.3g}</text>'
            f'<text x="40" y="{height - 6}" font-size="12">{name}, {max(steps)} steps</text></svg>')
