#!/usr/bin/env python3
"""Writes the golden files of fingerpost-vision: what OpenCV makes of the same pictures.

    pip install "opencv-python-headless==5.0.0.*" numpy
    python3 tools/golden/opencv_golden.py crates/fingerpost-vision/tests/golden DATA

DATA is the folder that FINGERPOST_DATA names in the tests on real data; KITTI's pictures are read from it and never
written, only the flow between their ground views. All numbers are little-endian.

    synthetic_N_previous.grey, _next.grey   WIDTH x HEIGHT bytes
    synthetic_N.flow, kitti_FROM_TO.flow    f32 pairs (dx, dy) at every STEP-th (KITTI_STEP-th)
                                            column of every such row
    colour.bin                              grey, hue, saturation of each colour of a LEVELS^3 grid, blue fastest
    warp.grey                               synthetic_1_previous resampled by warp_place, 0 where it looks outside
    gaussian_5.grey, box_15.grey,           synthetic_1_previous smoothed, and dilated by an ellipse: every STEP-th column
    dilated_5.grey                          of every such row
    sobel.i16                               the same of its slopes: dx, dy
    canny_l1.bits, canny_l2.bits            edges of it smoothed, eight pixels a byte, the first in the highest bit
    components.i32                          of the components of canny_l1, by their first pixels: left, top, width, height,
                                            area
    lines.f32                               of the LINES strongest lines in canny_l1: rho, theta, votes
"""

import pathlib
import sys

import cv2
import numpy as np

WIDTH, HEIGHT = 128, 160  # columns and rows of every ground view, pixels
STEP = 4  # one flow vector is kept every so many pixels, to keep the files small
KITTI_STEP = 8  # coarser for recorded drives, whose licence lets only such samples ship
LINES = 12  # lines kept
CANNY = (80, 160)  # thresholds
LEVELS = range(0, 256, 15)  # levels of each channel in the grid of colours
FLOW = dict(pyr_scale=0.5, levels=3, winsize=15, iterations=3, poly_n=5, poly_sigma=1.2, flags=0)

# Ground view of KITTI odometry 00: level camera 1.65 m above the road; nearest row just inside the picture.
FOCAL_PX, CX_PX, CY_PX, CAMERA_HEIGHT_M = 718.856, 607.1928, 185.2157, 1.65
FAR_M, METRES_PER_PX = 14.3, 0.05
# Straight road fast and slow, and the right turn.
KITTI_PAIRS = [(0, 1), (40, 41), (85, 86), (104, 105), (112, 113)]


def canvas():
    """A road from above, 512 x 512 pixels: asphalt of three grains, a kerb, a dashed line, patches."""
    random = np.random.default_rng(7)
    picture = np.full((512, 512), 105.0)
    for grain_px, contrast in ((1.2, 22.0), (3.0, 14.0), (9.0, 12.0)):
        noise = cv2.GaussianBlur(random.standard_normal((512, 512)), (0, 0), grain_px)
        picture += contrast * noise / noise.std()
    picture[:, :190] += 35.0
    picture[:, 186:190] = 190.0
    for top in range(0, 512, 60):
        picture[top : top + 30, 262:266] = 215.0
    for _ in range(25):
        x, y = random.integers(0, 500, 2)
        cv2.ellipse(picture, (int(x), int(y)), (9, 5), int(x), 0, 360, float(random.integers(40, 90)), -1)
    return cv2.GaussianBlur(picture, (0, 0), 0.7)


def resample(picture, u, v):
    """Bilinear, at places in steps of 1/32 pixel as fingerpost-vision keeps them."""
    u, v = (np.rint(32 * place).astype(np.float32) / 32 for place in (u, v))
    return cv2.remap(picture, u, v, cv2.INTER_LINEAR)


def view(source, right_px, down_px, turn_deg):
    """A WIDTH x HEIGHT window on the canvas, its centre moved and turned."""
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    x, y = np.meshgrid(np.arange(WIDTH) - WIDTH / 2, np.arange(HEIGHT) - HEIGHT / 2)
    u = 256 + right_px + cos * x - sin * y
    v = 256 + down_px + sin * x + cos * y
    return cv2.remap(source, u.astype(np.float32), v.astype(np.float32), cv2.INTER_CUBIC)


def synthetic_pairs():
    source = canvas()
    random = np.random.default_rng(11)
    noisy = lambda picture: picture + 2.0 * random.standard_normal(picture.shape)

    # Driving straight on; the ground comes towards the vehicle.
    yield noisy(view(source, 0, 0, 0)), noisy(view(source, 0, -6.4, 0))
    # Turning.
    yield noisy(view(source, 0, 0, 0)), noisy(view(source, 1.5, -4.0, 3.0))
    # Fast and sideways.
    yield noisy(view(source, 0, 0, 0)), noisy(view(source, 8.0, -13.0, -1.0))
    # Something else moves through the view and hides the ground.
    previous, following = view(source, -30, 20, 0), view(source, -30, 16, 0)
    other = view(source, 90, -120, 40)[:40, :36] - 45.0
    previous[50:90, 40:76], following[58:98, 34:70] = other, other
    yield noisy(previous), noisy(following)
    # It gets darker, and both upper corners are unseen.
    previous, following = view(source, 0, 60, 2), 0.85 * view(source, 0.7, 55, 1.5)
    for picture in (previous, following):
        cv2.fillPoly(picture, [np.array([[0, 0], [38, 0], [0, 110]]), np.array([[127, 0], [95, 0], [127, 90]])], 0.0)
    yield noisy(previous), noisy(following)


def kitti_view(folder, frame):
    grey = cv2.imread(str(folder / f"{frame:06}.jpg"), cv2.IMREAD_GRAYSCALE)
    if grey is None:
        sys.exit(f"cannot read frame {frame} in {folder}; give the data folder as the second argument")
    forward_m = FAR_M - METRES_PER_PX * np.arange(HEIGHT)[:, None]
    right_m = METRES_PER_PX * (np.arange(WIDTH) - (WIDTH - 1) / 2)[None, :]
    u = FOCAL_PX * right_m / forward_m + CX_PX
    v = np.broadcast_to(FOCAL_PX * CAMERA_HEIGHT_M / forward_m + CY_PX, u.shape)
    return resample(grey, u, v)


def warp_place(col, row):
    return 0.9 * col + 0.13 * row - 4.0, 1.1 * row - 0.07 * col - 2.5 + 0.002 * col * row


def flow_between(previous, following):
    return cv2.calcOpticalFlowFarneback(previous, following, None, **FLOW)


def save_flow(path, flow, step):
    path.write_bytes(flow[::step, ::step].astype("<f4").tobytes())


def save_edges(out, picture):
    def save(name, values, kind):
        (out / name).write_bytes(np.ascontiguousarray(values).astype(kind).tobytes())

    ellipse = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
    blurred = cv2.GaussianBlur(picture, (5, 5), 1.1)
    save("gaussian_5.grey", blurred[::STEP, ::STEP], "u1")
    save("box_15.grey", cv2.boxFilter(picture, -1, (15, 15))[::STEP, ::STEP], "u1")
    save("dilated_5.grey", cv2.dilate(picture, ellipse)[::STEP, ::STEP], "u1")
    slopes = [cv2.Sobel(picture, cv2.CV_16S, right, 1 - right)[::STEP, ::STEP] for right in (1, 0)]
    save("sobel.i16", np.dstack(slopes), "<i2")
    edges = cv2.Canny(blurred, *CANNY)
    save("canny_l1.bits", np.packbits(edges > 0, axis=1), "u1")
    save("canny_l2.bits", np.packbits(cv2.Canny(blurred, *CANNY, L2gradient=True) > 0, axis=1), "u1")
    _, labels, stats, _ = cv2.connectedComponentsWithStats(edges, connectivity=8)
    found, first_pixels = np.unique(labels, return_index=True)
    in_order = [label for _, label in sorted(zip(first_pixels, found)) if label > 0]
    save("components.i32", stats[in_order], "<i4")
    lines = cv2.HoughLinesWithAccumulator(edges, 1, np.pi / 180, 20)
    save("lines.f32", lines[:LINES], "<f4")


def main():
    out, data = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    for number, pair in enumerate(synthetic_pairs(), 1):
        previous, following = (np.clip(np.rint(picture), 0, 255).astype(np.uint8) for picture in pair)
        (out / f"synthetic_{number}_previous.grey").write_bytes(previous.tobytes())
        (out / f"synthetic_{number}_next.grey").write_bytes(following.tobytes())
        save_flow(out / f"synthetic_{number}.flow", flow_between(previous, following), STEP)
        if number == 1:
            save_edges(out, previous)
            col, row = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
            u, v = warp_place(col, row)
            seen = (u >= 0) & (u <= WIDTH - 1) & (v >= 0) & (v <= HEIGHT - 1)
            warped = resample(previous, u, v)
            (out / "warp.grey").write_bytes(np.where(seen, warped, 0).astype(np.uint8).tobytes())
    for first, second in KITTI_PAIRS:
        folder = data / "kitti" / "frames00"
        flow = flow_between(kitti_view(folder, first), kitti_view(folder, second))
        save_flow(out / f"kitti_{first}_{second}.flow", flow, KITTI_STEP)
    grid = np.array([(r, g, b) for r in LEVELS for g in LEVELS for b in LEVELS], np.uint8)[None]
    hsv, grey = cv2.cvtColor(grid, cv2.COLOR_RGB2HSV), cv2.cvtColor(grid, cv2.COLOR_RGB2GRAY)
    (out / "colour.bin").write_bytes(np.dstack([grey, hsv[:, :, 0], hsv[:, :, 1]]).tobytes())


if __name__ == "__main__":
    main()
