"""OpenCV as a peer: does on request what a kernel of Fingerpost does, and says how long it took.

Requests come on standard input, answers go to standard output: a line of JSON, followed by the bytes of the arrays that
the line announces as [type, shape] pairs. `prepare` hands over inputs and names an operation; `time` runs it and answers
with nanoseconds a call; `outputs` runs it once and answers with its arrays. Output arrays are allocated once where OpenCV
takes one, and every call is made once untimed first, so that nothing but the operation is timed.
"""
import collections
import json
import math
import sys
import time

import cv2
import numpy as np

HUE_SATURATION_RANGES = [0, 180, 0, 256]


def fixed_maps(map_x, map_y):
    """The remap tables that OpenCV is fastest with."""
    return cv2.convertMaps(map_x, map_y, cv2.CV_16SC2)


def remap(p, rgb, map_x, map_y):
    coordinates, weights = fixed_maps(map_x, map_y)
    out = np.empty((*map_x.shape, 3), np.uint8)
    return lambda: [cv2.remap(rgb, coordinates, weights, cv2.INTER_LINEAR, out)]


def ground(p, rgb, map_x, map_y):
    coordinates, weights = fixed_maps(map_x, map_y)
    colour = np.empty((*map_x.shape, 3), np.uint8)
    hsv, grey = np.empty_like(colour), np.empty(map_x.shape, np.uint8)

    def run():
        cv2.remap(rgb, coordinates, weights, cv2.INTER_LINEAR, colour)
        cv2.cvtColor(colour, cv2.COLOR_RGB2HSV, hsv)
        cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY, grey)
        return [colour, hsv, grey]

    return run


def grey(p, rgb):
    out = np.empty(rgb.shape[:2], np.uint8)
    return lambda: [cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY, out)]


def hsv(p, rgb):
    out = np.empty_like(rgb)
    return lambda: [cv2.cvtColor(rgb, cv2.COLOR_RGB2HSV, out)]


def histogram(p, hsv):
    return lambda: [cv2.calcHist([hsv], [0, 1], None, p["bins"], HUE_SATURATION_RANGES)]


def back_projection(p, hsv, histogram):
    out = np.empty(hsv.shape[:2], np.uint8)
    return lambda: [cv2.calcBackProject([hsv], [0, 1], histogram, HUE_SATURATION_RANGES, 1, out)]


def correlation(p, plane, kernel):
    out = np.empty_like(plane)
    return lambda: [cv2.filter2D(plane, -1, kernel, out)]


def integral(p, plane):
    out = np.empty((plane.shape[0] + 1, plane.shape[1] + 1), np.int32)
    return lambda: [cv2.integral(plane, out)]


def gaussian(p, plane):
    out = np.empty_like(plane)
    side = (p["side"], p["side"])
    return lambda: [cv2.GaussianBlur(plane, side, p["sigma"], out)]


def box_mean(p, plane):
    out = np.empty_like(plane)
    side = (p["side"], p["side"])
    border = cv2.BORDER_REPLICATE if p.get("replicate") else cv2.BORDER_DEFAULT
    return lambda: [cv2.boxFilter(plane, -1, side, out, borderType=border)]


def sobel(p, plane):
    out = np.empty(plane.shape, np.int16)
    return lambda: [cv2.Sobel(plane, cv2.CV_16S, 1, 0, out, 3)]


def canny(p, plane):
    out = np.empty_like(plane)
    return lambda: [cv2.Canny(plane, p["low"], p["high"], out, 3, bool(p["l2"]))]


def dilation(p, plane):
    shape = {"rectangle": cv2.MORPH_RECT, "ellipse": cv2.MORPH_ELLIPSE}[p["shape"]]
    element = cv2.getStructuringElement(shape, (p["side"], p["side"]))
    out = np.empty_like(plane)
    return lambda: [cv2.dilate(plane, element, out)]


def components(p, plane):
    labels = np.empty(plane.shape, np.int32)

    def run():
        count, _ = cv2.connectedComponents(plane, labels, 8, cv2.CV_32S)
        return [np.int32([count]), labels]

    return run


def component_statistics(p, plane):
    def run():
        count, labels, stats, _ = cv2.connectedComponentsWithStats(plane, None, None, None, 8, cv2.CV_32S)
        return [np.int32([count]), labels, np.ascontiguousarray(stats)]

    return run


def hough_lines(p, plane):
    def run():
        lines = cv2.HoughLines(plane, 1, np.pi / 180, p["votes"])
        return [np.float32([] if lines is None else lines.reshape(-1, 2))]

    return run


def hough_segments(p, plane):
    def run():
        found = cv2.HoughLinesP(plane, 1, np.pi / 180, p["votes"], None, p["min_length"], p["max_gap"])
        return [np.int32([] if found is None else found.reshape(-1, 4))]

    return run


def resize_half(p, plane):
    size = (plane.shape[1] // 2, plane.shape[0] // 2)
    out = np.empty(size[::-1], plane.dtype)
    return lambda: [cv2.resize(plane, size, out, interpolation=cv2.INTER_LINEAR)]


def pyramid_reduction(p, plane):
    size = ((plane.shape[1] + 1) // 2, (plane.shape[0] + 1) // 2)
    out = np.empty(size[::-1], plane.dtype)
    return lambda: [cv2.pyrDown(plane, out, size)]


def flow_of(previous, current, flow):
    return cv2.calcOpticalFlowFarneback(previous, current, flow, 0.5, 3, 15, 3, 5, 1.2, 0)


def farneback(p, previous, current):
    out = np.zeros((*previous.shape, 2), np.float32)
    return lambda: [flow_of(previous, current, out)]


class Localisation:
    """The localisation loop as an OpenCV user writes it: one frame a call, stage by stage."""

    def __init__(self, p, frames, map_x, map_y, seen):
        self.frames, self.seen, self.next = frames, seen, 0
        self.maps = fixed_maps(map_x, map_y)
        self.side, self.flow_side = seen.shape[0], p["flow_side"]
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5)).astype(np.float32)
        self.disc = disc / disc.sum()
        self.recent = collections.deque(maxlen=5)
        self.previous = None
        self.stages = {}

    def masks(self, right, down):
        """Two arms, the approach and the way through a crossroads, drawn where the node would be."""
        n = self.side
        node = (n // 2 + right, n // 2 + down)
        masks = []
        for end in [(node[0], 2 * n), (-n, node[1]), (2 * n, node[1])]:
            mask = np.zeros((n, n), np.uint8)
            cv2.line(mask, node, end, 255, n // 24)
            masks.append(mask & self.seen)
        t = np.linspace(0, 1, 32)[:, None]
        start, middle, end = np.float32([[node[0], node[1] + n // 3], node, [node[0] + n // 3, node[1]]])
        curve = (1 - t) ** 2 * start + 2 * t * (1 - t) * middle + t**2 * end
        mask = np.zeros((n, n), np.uint8)
        cv2.polylines(mask, [curve.astype(np.int32)], False, 255, n // 14)
        return masks + [mask & self.seen]

    def match(self, road, right, down):
        return min(cv2.mean(road, mask)[0] / 255 for mask in self.masks(right, down))

    def __call__(self):
        n, r = self.side, self.flow_side
        laps = [time.perf_counter_ns()]
        rgb = self.frames[self.next % len(self.frames)]
        self.next += 1
        ground = cv2.remap(rgb, *self.maps, cv2.INTER_LINEAR)
        laps.append(time.perf_counter_ns())
        hsv = cv2.cvtColor(ground, cv2.COLOR_RGB2HSV)
        grey = cv2.cvtColor(ground, cv2.COLOR_RGB2GRAY)
        laps.append(time.perf_counter_ns())
        near = hsv[n - n // 6 :, n // 2 - n // 12 : n // 2 + n // 12]
        self.recent.append(cv2.calcHist([near], [0, 1], None, [32, 32], HUE_SATURATION_RANGES))
        model = np.mean(self.recent, axis=0)
        cv2.normalize(model, model, 0, 255, cv2.NORM_MINMAX)
        laps.append(time.perf_counter_ns())
        road = cv2.calcBackProject([hsv], [0, 1], model, HUE_SATURATION_RANGES, 1)
        road = cv2.filter2D(road, -1, self.disc)
        laps.append(time.perf_counter_ns())
        self.match(road, 0, 0)
        laps.append(time.perf_counter_ns())
        rows, columns = slice(n - r, n), slice(n // 2 - r // 2, n // 2 + r // 2)
        right = down = 0.0
        if self.previous is not None:
            flow = flow_of(self.previous[rows, columns], grey[rows, columns], None)
            right, down = flow[r // 4 : -r // 4, r // 4 : -r // 4].reshape(-1, 2).mean(0)
        laps.append(time.perf_counter_ns())
        self.match(road, int(right), int(down))
        laps.append(time.perf_counter_ns())
        self.previous = grey
        names = ["warp", "colour", "histogram", "back-projection", "match", "motion", "match again"]
        self.stages = {name: b - a for name, a, b in zip(names, laps, laps[1:])}
        return [grey]


class LaneDetection:
    """The lane path as an OpenCV user writes it: one frame a call; the columns of both edges in rows of the region come out.

    `rows` has for every row of the region: the columns between which edges may lie, the column straight ahead, and the
    stretch of the horizon to which a lane can lead, with its row.
    """

    def __init__(self, p, frames, rows):
        self.p, self.frames, self.rows = p, frames, rows
        self.wanted = np.arange(rows.shape[0] - 1, 0, -p["point_rows"])[::-1].astype(np.float64)
        self.start()
        self.stages = {}

    def start(self):
        self.next, self.mean, self.previous = 0, None, [{}, {}]

    def smooth_mean(self):
        grey = cv2.cvtColor(self.frames[self.next][self.p["top_row"] :], cv2.COLOR_RGB2GRAY)
        self.next += 1
        if self.mean is None:
            self.mean = grey.astype(np.float32)
        cv2.accumulateWeighted(grey, self.mean, 1 / min(self.next, self.p["buffer_frames"]))
        return cv2.GaussianBlur(cv2.convertScaleAbs(self.mean), (5, 5), 0)

    def threshold(self, smooth):
        """The upper threshold, raised in steps above the texture of the road."""
        across = cv2.absdiff(smooth[1:-1:4, :-2:4], smooth[1:-1:4, 2::4])
        common = np.searchsorted(np.bincount(across.ravel(), minlength=256).cumsum(), 0.9 * across.size)
        high = self.p["canny_high"]
        return high * 1.25 ** math.floor(math.log(max(4 * 1.5 * common / high, 1), 1.25))

    def oriented(self, edges, dx, dy):
        """The edges that are brighter outside and lead to where a lane can."""
        kept = np.zeros_like(edges)
        points = cv2.findNonZero(edges)
        if points is None:
            return kept
        xs, ys = points.reshape(-1, 2).T
        left, right, ahead, horizon_left, horizon_right, horizon_row = self.rows[ys].T
        gx, gy = dx[ys, xs].astype(np.float32), dy[ys, xs].astype(np.float32)
        inside = (xs >= left) & (xs < right) & (np.where(xs < ahead, -gx, gx) > 0)
        slope = np.divide(gy, gx, out=np.zeros_like(gx), where=gx != 0)
        up = ys - horizon_row
        to = xs + slope * up
        slack = np.abs(slope) * self.p["slack_rows"] + up * (1 + slope * slope) * np.float32(self.p["direction_rad"])
        inside &= (to > horizon_left - slack) & (to < horizon_right + slack)
        kept[ys[inside], xs[inside]] = 255
        return kept

    def large(self, dilated):
        count, labels, stats, _ = cv2.connectedComponentsWithStats(dilated, None, None, None, 8, cv2.CV_32S)
        keep = np.where(stats[:, cv2.CC_STAT_AREA] >= self.p["min_area_px"], 255, 0).astype(np.uint8)
        keep[0] = 0
        return np.take(keep, labels, mode="clip")

    def candidates(self, thin, section, side):
        """The strongest lines of a section's side as columns at its lower and upper end."""
        upper, lower = section
        ahead = int(self.rows[(upper + lower) // 2, 2])
        first, part = (0, thin[upper:lower, :ahead]) if side < 0 else (ahead, thin[upper:lower, ahead:])
        lines = cv2.HoughLines(part, 1, np.pi / 180, max(7, int(0.22 * (lower - upper))))
        found = []
        for rho, theta in [] if lines is None else lines.reshape(-1, 2)[:32].tolist():
            cosine = math.cos(theta)
            if abs(cosine) < 0.05:
                continue
            line = first + (rho - (lower - upper) * math.sin(theta)) / cosine, first + rho / cosine
            if all(max(abs(line[0] - other[0]), abs(line[1] - other[1])) >= 5 for other in found):
                found.append(line)
            if len(found) == 4:
                break
        return found

    def select(self, thin, side):
        """The innermost line of every section that a lane's edge can be; where there is none, the one of before."""
        chosen, before = self.previous[side > 0], None
        for index, (upper, lower) in enumerate(self.p["sections"]):
            best, largest = None, 0.0
            left, right, ahead = self.rows[lower - 1, :3]
            for at_lower, at_upper in self.candidates(thin, (upper, lower), side):
                angle = math.atan2(lower - upper, -side * (at_upper - at_lower))
                _, _, _, horizon_left, horizon_right, horizon_row = self.rows[upper]
                at_horizon = at_lower + (at_upper - at_lower) * (lower - horizon_row) / (lower - upper)
                possible = horizon_left < at_horizon < horizon_right and left <= at_lower < right
                if before is not None:
                    possible &= abs(at_lower - before[0]) < 20 and abs(angle - before[1]) < math.radians(8)
                if possible and side * (at_lower - ahead) > -20 and angle > largest:
                    best, largest = (at_lower, at_upper), angle
            if best is not None:
                chosen[index] = (*best, self.next)
                before = best[1], largest
        last = self.next - self.p["keep_frames"]
        self.previous[side > 0] = {index: line for index, line in chosen.items() if line[2] >= last}
        return self.previous[side > 0]

    def spline(self, chosen):
        """The columns of the shape-preserving cubic (Fritsch and Carlson) through the sections' ends."""
        knots = {}
        for index, (at_lower, at_upper, _) in chosen.items():
            upper, lower = self.p["sections"][index]
            knots.setdefault(lower, []).append(at_lower)
            knots.setdefault(upper, []).append(at_upper)
        if not knots:
            return np.full(self.wanted.size, np.nan)
        x = np.array(sorted(knots), np.float64)
        y = np.array([sum(knots[row]) / len(knots[row]) for row in sorted(knots)])
        h = np.diff(x)
        d = np.diff(y) / h
        slopes = np.concatenate([d[:1], np.zeros(d.size - 1), d[-1:]])
        for i in range(1, d.size):
            if d[i - 1] * d[i] > 0:
                w1, w2 = 2 * h[i] + h[i - 1], h[i] + 2 * h[i - 1]
                slopes[i] = (w1 + w2) / (w1 / d[i - 1] + w2 / d[i])
        i = np.clip(np.searchsorted(x, self.wanted, "right") - 1, 0, d.size - 1)
        t = (self.wanted - x[i]) / h[i]
        cubic = (1 + 2 * t) * (1 - t) ** 2 * y[i] + t * t * (3 - 2 * t) * y[i + 1]
        cubic += h[i] * t * (1 - t) * ((1 - t) * slopes[i] - t * slopes[i + 1])
        cubic[(self.wanted < x[0]) | (self.wanted > x[-1])] = np.nan
        return cubic

    def __call__(self):
        if self.next == len(self.frames):
            self.start()
        laps = [time.perf_counter_ns()]
        smooth = self.smooth_mean()
        laps.append(time.perf_counter_ns())
        high = self.threshold(smooth)
        dx, dy = cv2.spatialGradient(smooth)
        edges = cv2.Canny(dx, dy, self.p["canny_low_share"] * high, high)
        laps.append(time.perf_counter_ns())
        kept = self.oriented(edges, dx, dy)
        laps.append(time.perf_counter_ns())
        large = self.large(cv2.dilate(kept, np.ones((3, 3), np.uint8)))
        laps.append(time.perf_counter_ns())
        thin = cv2.ximgproc.thinning(large, None, cv2.ximgproc.THINNING_ZHANGSUEN)
        laps.append(time.perf_counter_ns())
        chosen = [self.select(thin, side) for side in (-1, 1)]
        laps.append(time.perf_counter_ns())
        columns = np.float32([self.spline(lines) for lines in chosen])
        laps.append(time.perf_counter_ns())
        names = ["mean and blur", "edges", "orientation", "dilation and area", "thinning", "lines", "spline"]
        self.stages = {name: b - a for name, a, b in zip(names, laps, laps[1:])}
        return [columns]


OPERATIONS = {
    operation.__name__: operation
    for operation in [
        remap, ground, grey, hsv, histogram, back_projection, correlation, integral, gaussian, box_mean, sobel, canny,
        dilation, components, component_statistics, hough_lines, hough_segments, resize_half, pyramid_reduction,
        farneback,
    ]
} | {"localisation": Localisation, "lane_detection": LaneDetection}


def read_arrays(kinds):
    arrays = []
    for kind, shape in kinds:
        count = int(np.prod(shape)) * np.dtype(kind).itemsize
        arrays.append(np.frombuffer(bytearray(sys.stdin.buffer.read(count)), kind).reshape(shape))
    return arrays


def answer(line, arrays=()):
    line["arrays"] = [[array.dtype.str[1:], list(array.shape)] for array in arrays]
    sys.stdout.buffer.write(json.dumps(line).encode() + b"\n")
    for array in arrays:
        sys.stdout.buffer.write(np.ascontiguousarray(array).tobytes())
    sys.stdout.buffer.flush()


def timed(run, calls):
    run()
    nanoseconds, stages = [], collections.defaultdict(list)
    for _ in range(calls):
        start = time.perf_counter_ns()
        run()
        nanoseconds.append(time.perf_counter_ns() - start)
        for name, lap in getattr(run, "stages", {}).items():
            stages[name].append(lap)
    return {"nanoseconds": nanoseconds, "stages": stages}


def main():
    cv2.setNumThreads(1)
    prepared = None
    while line := sys.stdin.buffer.readline():
        request = json.loads(line)
        match request["do"]:
            case "describe":
                answer({"opencv": cv2.__version__, "python": sys.version.split()[0]})
            case "prepare":
                arrays = read_arrays(request["arrays"])
                prepared = OPERATIONS[request["operation"]](request["parameters"], *arrays)
                answer({})
            case "time":
                answer(timed(prepared, request["calls"]))
            case "outputs":
                answer({}, prepared())


if __name__ == "__main__":
    main()
