"""What a training came to: a page with its figures, curves and pictures."""

import base64
import glob
import html
import io

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image

from labelled import first_row, log_odds

# Colours of what is drawn over a picture: road, raised ground, hidden ground, paint.
COLOURS = {0: (40, 200, 90), 2: (230, 60, 200), 3: (40, 80, 230), 1: (255, 230, 0)}
# Pictures of a set on the page, and the size of one.
SHOWN, TILE = 24, (320, 180)


def pictures(pattern):
    """The pictures of the folders that a pattern names."""
    return sorted(glob.glob(f"{pattern}/*"))


def overlay(network, path):
    """A picture with what the network says of each place over it, as strongly as it is sure."""
    width, height = TILE
    top = first_row(height)
    y = F.interpolate(log_odds(network, path)[None], size=(height - top, width), mode="bilinear")
    y = torch.sigmoid(y)[0].numpy()
    picture = np.asarray(Image.open(path).convert("RGB").resize(TILE, Image.BILINEAR)).astype(np.float32)
    for output, colour in COLOURS.items():
        share = 0.6 * np.clip(2 * y[output] - 1, 0, 1)[..., None]
        picture[top:] = picture[top:] * (1 - share) + np.array(colour, np.float32) * share
    return Image.fromarray(picture.astype(np.uint8))


def sheet(network, paths, columns=4):
    """A contact sheet of overlays of some of the pictures, spread evenly over all."""
    some = [paths[i] for i in np.unique(np.linspace(0, len(paths) - 1, min(SHOWN, len(paths))).astype(int))]
    page = Image.new("RGB", (TILE[0] * columns, TILE[1] * -(-len(some) // columns)))
    for i, path in enumerate(some):
        page.paste(overlay(network, path), (i % columns * TILE[0], i // columns * TILE[1]))
    return page


def curve(points, name, width=640, height=220):
    """A line of an SVG over the steps; values between their least and largest."""
    steps = [p["step"] for p in points]
    values = [p[name] for p in points]
    low, high = min(values), max(values)
    place = lambda s, v: f"{40 + (width - 50) * s / max(steps):.1f},{10 + (height - 40) * (high - v) / max(high - low, 1e-9):.1f}"
    line = " ".join(place(s, v) for s, v in zip(steps, values))
    return (f'<svg width="{width}" height="{height}" role="img" aria-label="{html.escape(name)} over the steps">'
            f'<polyline points="{line}" fill="none" stroke="#1565c0" stroke-width="2"/>'
            f'<text x="2" y="16" font-size="12">{high:.3g}</text><text x="2" y="{height - 30}" font-size="12">{low:.3g}</text>'
            f'<text x="40" y="{height - 6}" font-size="12">{html.escape(name)}, {max(steps)} steps</text></svg>')


def diagram(bins, name, size=220):
    """A reliability diagram: how much of what was called so likely is true; right is the diagonal."""
    place = lambda p, h: (30 + (size - 40) * p, size - 30 - (size - 40) * h)
    line = " ".join("{:.1f},{:.1f}".format(*place(b[0], b[1])) for b in bins if b)
    (x0, y0), (x1, y1) = place(0, 0), place(1, 1)
    return (f'<svg width="{size}" height="{size}" role="img" aria-label="reliability of {html.escape(name)}">'
            f'<line x1="{x0}" y1="{y0}" x2="{x1}" y2="{y1}" stroke="#999"/><polyline points="{line}" fill="none" stroke="#c62828" stroke-width="2"/>'
            f'<text x="30" y="{size - 8}" font-size="12">{html.escape(name)}: called so, is so</text></svg>')


def embedded(picture):
    data = io.BytesIO()
    picture.save(data, "JPEG", quality=85)
    return f'<img alt="" src="data:image/jpeg;base64,{base64.b64encode(data.getvalue()).decode()}">'


def write(path, facts, network, sets):
    """The page. `sets` are pairs of a name and paths of pictures."""
    rows = "".join(f"<tr><td>{html.escape(name)}<td>{s['best']:.3f}<td>{s['at_even_odds']:.3f}" for name, s in facts["tests"].items())
    curves = [curve(facts["curve"], name) for name in facts["curve"][-1] if name != "step"]
    diagrams = [diagram(bins, name) for name, bins in facts["reliability"]["by_output"].items()]
    parts = [
        '<!doctype html><meta charset="utf-8"><title>Road network</title><body style="font-family:sans-serif;max-width:1300px;margin:1em auto">',
        "<h1>Road network</h1><p>Trained on pictures of the simulator alone. "
        f"{facts['parameters']} parameters, {facts['steps']} steps of {facts['batch']} pictures. On worlds that were not trained on, on days of their "
        f"own, intersection over union of road is {facts['reliability']['road_iou']:.3f} at even odds.</p>",
        f"<table><tr><th>labelled pictures<th>best threshold<th>even odds{rows}</table>", *curves, "<h2>Is it right as often as it says?</h2>", *diagrams,
        "<h2>Pictures</h2><p>Green: road; yellow: paint; purple: raised ground; blue: ground that something hides.</p>",
        *(f"<h3>{html.escape(name)}</h3>{embedded(sheet(network, paths))}" for name, paths in sets if paths),
    ]
    with open(path, "w") as file:
        file.write("\n".join(parts))
