//! Lines, polygons and discs.

use super::{Canvas, Paint};

/// Scan lines in a row of pixels when a polygon is filled.
const SCAN_LINES: usize = 4;
/// Length of an arrow's head as a share of the arrow.
const HEAD_SHARE: f64 = 0.35;
/// Longest head of an arrow, pixels.
const MAX_HEAD_PX: f64 = 7.0;

impl Canvas {
    /// A line through `points` with round caps.
    pub(crate) fn polyline(&mut self, points: &[[f64; 2]], width_px: f64, paint: Paint) {
        for ends in points.windows(2) {
            self.cover_segment(ends[0], ends[1], 0.5 * width_px);
        }
        self.lay(paint);
    }

    /// A line through `points` of pieces `on_px` long, `off_px` apart.
    pub(crate) fn dashed(
        &mut self,
        points: &[[f64; 2]],
        width_px: f64,
        [on_px, off_px]: [f64; 2],
        paint: Paint,
    ) {
        let mut walked = 0.0;
        for ends in points.windows(2) {
            let (from, to) = (ends[0], ends[1]);
            let length = libm::hypot(to[0] - from[0], to[1] - from[1]);
            // A line beyond any picture has no pieces that could be told apart.
            if !(length > 0.0 && length < 1e5) {
                continue;
            }
            let at = |along: f64| [0, 1].map(|i| from[i] + (to[i] - from[i]) * along / length);
            let period = on_px + off_px;
            let mut start = -(walked % period);
            while start < length {
                let (first, last) = (start.max(0.0), (start + on_px).min(length));
                if first < last {
                    self.cover_segment(at(first), at(last), 0.5 * width_px);
                }
                start += period;
            }
            walked += length;
        }
        self.lay(paint);
    }

    /// The inside of the closed line through `corners`, by the nonzero winding rule.
    pub(crate) fn polygon(&mut self, corners: &[[f64; 2]], paint: Paint) {
        if corners.len() < 3 || corners.iter().flatten().any(|c| !c.is_finite()) {
            return;
        }
        let (top, bottom) = corners
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(c[1]), high.max(c[1])));
        let clip = self.clip;
        let mut row_coverage = vec![0.0; clip.width];
        for y in self.rows(top - 0.5, bottom + 0.5) {
            row_coverage.fill(0.0);
            for line in 0..SCAN_LINES {
                let scan_y = y as f64 - 0.5 + (line as f64 + 0.5) / SCAN_LINES as f64;
                for (from, to) in inside(corners, scan_y) {
                    add_stretch(&mut row_coverage, from - clip.x as f64, to - clip.x as f64);
                }
            }
            for (i, share) in row_coverage.iter().enumerate() {
                if *share > 0.0 {
                    self.cover(clip.x + i, y, *share);
                }
            }
        }
        self.lay(paint);
    }

    /// A filled circle.
    pub(crate) fn disc(&mut self, centre: [f64; 2], radius_px: f64, paint: Paint) {
        self.cover_segment(centre, centre, radius_px);
        self.lay(paint);
    }

    /// A circle.
    pub(crate) fn ring(&mut self, centre: [f64; 2], radius_px: f64, width_px: f64, paint: Paint) {
        // Corners less than two pixels apart cannot be seen.
        let corners = (std::f64::consts::TAU * radius_px / 2.0).ceil().clamp(12.0, 200.0);
        let points: Vec<[f64; 2]> = (0..=corners as usize)
            .map(|i| libm::sincos(i as f64 / corners * std::f64::consts::TAU))
            .map(|(sine, cosine)| [centre[0] + radius_px * cosine, centre[1] + radius_px * sine])
            .collect();
        self.polyline(&points, width_px, paint);
    }

    /// A line with a head at `to`.
    pub(crate) fn arrow(&mut self, from: [f64; 2], to: [f64; 2], width_px: f64, paint: Paint) {
        self.cover_segment(from, to, 0.5 * width_px);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = libm::hypot(dx, dy);
        if length > 2.0 {
            let head = (HEAD_SHARE * length).min(MAX_HEAD_PX) / length;
            for side in [-0.5, 0.5] {
                let tip = [to[0] - head * (dx + side * dy), to[1] - head * (dy - side * dx)];
                self.cover_segment(to, tip, 0.5 * width_px);
            }
        }
        self.lay(paint);
    }

    /// Covers all places within `half_px` of the segment from `a` to `b`.
    fn cover_segment(&mut self, a: [f64; 2], b: [f64; 2], half_px: f64) {
        if !(a.iter().chain(&b).all(|c| c.is_finite()) && half_px.is_finite()) {
            return;
        }
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length_squared = dx * dx + dy * dy;
        let reach = half_px + 0.5;
        for y in self.rows(a[1].min(b[1]) - reach, a[1].max(b[1]) + reach) {
            let row = y as f64;
            // The part of the segment that comes near this row.
            let (mut first, mut last) = (0.0, 1.0);
            if dy.abs() > 1e-9 {
                let (t0, t1) = ((row - reach - a[1]) / dy, (row + reach - a[1]) / dy);
                (first, last) = (t0.min(t1).clamp(0.0, 1.0), t0.max(t1).clamp(0.0, 1.0));
            }
            let (x0, x1) = (a[0] + first * dx, a[0] + last * dx);
            for x in self.columns(x0.min(x1) - reach, x0.max(x1) + reach) {
                let (px, py) = (x as f64 - a[0], row - a[1]);
                let along = if length_squared > 0.0 {
                    ((px * dx + py * dy) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let distance = libm::hypot(px - along * dx, py - along * dy);
                if distance < reach {
                    self.cover(x, y, reach - distance);
                }
            }
        }
    }
}

/// The stretches of the scan line at `y` inside the polygon.
fn inside(corners: &[[f64; 2]], y: f64) -> Vec<(f64, f64)> {
    let mut crossings: Vec<(f64, i32)> = Vec::new();
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        if (a[1] <= y) != (b[1] <= y) {
            let x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            crossings.push((x, if b[1] > a[1] { 1 } else { -1 }));
        }
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut winding, mut start, mut stretches) = (0, 0.0, Vec::new());
    for (x, turn) in crossings {
        if winding == 0 {
            start = x;
        }
        winding += turn;
        if winding == 0 {
            stretches.push((start, x));
        }
    }
    stretches
}

/// Adds one scan line's stretch to the coverage of a row's pixels, pixel `i` reaching from `i - 0.5` to `i + 0.5`.
fn add_stretch(row: &mut [f64], from: f64, to: f64) {
    let (from, to) = ((from + 0.5).max(0.0), (to + 0.5).min(row.len() as f64));
    if from >= to {
        return;
    }
    let first = from as usize;
    for (i, coverage) in row.iter_mut().enumerate().take(to.ceil() as usize).skip(first) {
        let covered = to.min(i as f64 + 1.0) - from.max(i as f64);
        *coverage += covered / SCAN_LINES as f64;
    }
}
