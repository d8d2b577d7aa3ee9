//! What changes over a run, gathered frame by frame in bounded memory and made short enough for a page.

/// Points that a curve on a page has at most, about: two for every pixel of a laptop's width.
pub(crate) const MAX_POINTS: usize = 2000;

/// A point of a curve: where on the page, and the value.
type Point = (f64, f64);

/// What is kept of some points in a row.
#[derive(Debug, Clone, Copy)]
struct Bucket {
    /// Which of all buckets of its size it is; those without a value are not kept.
    number: usize,
    first: Point,
    low: Point,
    high: Point,
    last: Point,
}

impl Bucket {
    fn of(number: usize, point: Point) -> Self {
        Self { number, first: point, low: point, high: point, last: point }
    }

    fn join(&mut self, later: &Self) {
        self.low = if later.low.1 < self.low.1 { later.low } else { self.low };
        self.high = if later.high.1 > self.high.1 { later.high } else { self.high };
        self.last = later.last;
    }
}

/// A curve that keeps its extremes and is cut where it has no value.
///
/// A long one is cut into equal stretches of which the lowest and the highest point are kept; gaps shorter than such a
/// stretch are passed over. The stretches double as the curve grows, so that what is kept of it is bounded.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    points: usize,
    stretch: usize,
    buckets: Vec<Bucket>,
}

impl Default for Series {
    fn default() -> Self {
        Self { points: 0, stretch: 1, buckets: Vec::new() }
    }
}

impl Series {
    /// Goes on with the next point; `y` is none where there is no value.
    pub(crate) fn push(&mut self, x: f64, y: Option<f64>) {
        let number = self.points / self.stretch;
        self.points += 1;
        let Some(y) = y.filter(|y| y.is_finite()) else { return };
        self.take(Bucket::of(number, (x, y)));
        // A bucket gives two points, or one where it holds but one.
        while self.buckets.len() > MAX_POINTS / 2 {
            self.stretch *= 2;
            for mut bucket in std::mem::take(&mut self.buckets) {
                bucket.number /= 2;
                self.take(bucket);
            }
        }
    }

    fn take(&mut self, bucket: Bucket) {
        match self.buckets.last_mut() {
            Some(last) if last.number == bucket.number => last.join(&bucket),
            _ => self.buckets.push(bucket),
        }
    }

    /// Whether it has no value at all.
    pub(crate) fn is_empty(&self) -> bool {
        self.buckets.is_empty()
    }

    /// Least and greatest value.
    pub(crate) fn extent(&self) -> Option<(f64, f64)> {
        let ends = self.buckets.iter().map(|bucket| (bucket.low.1, bucket.high.1));
        ends.reduce(|all, one| (all.0.min(one.0), all.1.max(one.1)))
    }

    /// The curve's pieces.
    pub(crate) fn pieces(&self) -> Vec<Vec<Point>> {
        let cut = |before: &Bucket, after: &Bucket| after.number == before.number + 1;
        self.buckets.chunk_by(cut).map(piece).collect()
    }
}

/// The first and last point, and the lowest and the highest of every bucket, in their order.
fn piece(buckets: &[Bucket]) -> Vec<Point> {
    let mut kept = Vec::with_capacity(2 * buckets.len() + 2);
    kept.extend(buckets.first().map(|bucket| bucket.first));
    for Bucket { low, high, .. } in buckets {
        kept.extend(if low.0 <= high.0 { [*low, *high] } else { [*high, *low] });
    }
    kept.extend(buckets.last().map(|bucket| bucket.last));
    kept.dedup();
    kept
}

/// A stretch of a run with one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch<T> {
    /// Index of its first frame.
    first: usize,
    /// Where that is on the page.
    pub(crate) start: f64,
    /// The value.
    pub(crate) value: T,
}

/// Stretches of equal values; where they are many, short ones join the one before.
#[derive(Debug, Clone)]
pub(crate) struct Stretches<T> {
    frames: usize,
    found: Vec<Stretch<T>>,
}

impl<T> Default for Stretches<T> {
    fn default() -> Self {
        Self { frames: 0, found: Vec::new() }
    }
}

impl<T: PartialEq + Clone> Stretches<T> {
    /// Goes on with the next frame.
    pub(crate) fn push(&mut self, at: f64, value: T) {
        let first = self.frames;
        self.frames += 1;
        if self.found.last().is_none_or(|last| last.value != value) {
            self.found.push(Stretch { first, start: at, value });
        }
        if self.found.len() > 2 * MAX_POINTS {
            self.found = self.joined();
        }
    }

    /// The stretches, so few that a page can show them.
    pub(crate) fn joined(&self) -> Vec<Stretch<T>> {
        let shortest = self.frames.div_ceil(MAX_POINTS);
        let mut kept: Vec<Stretch<T>> = Vec::new();
        for next in &self.found {
            let flickers = |last: &Stretch<T>| next.first - last.first < shortest;
            if kept.len() > 1 && kept.last().is_some_and(flickers) {
                kept.pop();
            }
            if kept.last().is_none_or(|last| last.value != next.value) {
                kept.push(next.clone());
            }
        }
        kept
    }
}

/// Places along the route, frame by frame, so far apart that they are few.
#[derive(Debug, Clone, Default)]
pub(crate) struct Places {
    frames: usize,
    step_m: f64,
    /// Frame and place.
    kept: Vec<(usize, f64)>,
}

/// Distance to which places are thinned first, metres: below a pixel of the map for routes longer than a hundred metres.
const FIRST_STEP_M: f64 = 0.1;

impl Places {
    /// Goes on to the next frame's place.
    pub(crate) fn push(&mut self, route_m: f64) {
        self.take((self.frames, route_m));
        self.frames += 1;
        while self.kept.len() > 2 * MAX_POINTS {
            self.step_m = (2.0 * self.step_m).max(FIRST_STEP_M);
            std::mem::take(&mut self.kept).into_iter().for_each(|place| self.take(place));
        }
    }

    fn take(&mut self, place: (usize, f64)) {
        let near = |last: &(usize, f64)| (place.1 - last.1).abs() < self.step_m;
        if place.1.is_finite() && !self.kept.last().is_some_and(near) {
            self.kept.push(place);
        }
    }

    /// The places of the stretches of a run, each with its value and up to where the next one begins.
    pub(crate) fn along<'a, T>(
        &'a self,
        stretches: &'a [Stretch<T>],
    ) -> impl Iterator<Item = (&'a T, Vec<f64>)> {
        stretches.iter().enumerate().map(|(i, stretch)| {
            let next = stretches.get(i + 1);
            let inside = |frame: usize| frame > stretch.first && next.is_none_or(|next| frame < next.first);
            let between = self.kept.iter().filter(move |(frame, _)| inside(*frame)).map(|(_, place)| *place);
            let places = std::iter::once(stretch.start).chain(between).chain(next.map(|next| next.start));
            (&stretch.value, places.collect())
        })
    }
}

/// The points of a path that lie at least `step` from the one kept before, and its last.
pub(crate) fn thinned_path(points: impl Iterator<Item = [f64; 2]>, step: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let mut skipped = None;
    for point in points.filter(|p| p[0].is_finite() && p[1].is_finite()) {
        let near = kept.last().is_some_and(|last| libm::hypot(point[0] - last[0], point[1] - last[1]) < step);
        if near {
            skipped = Some(point);
        } else {
            kept.push(point);
            skipped = None;
        }
    }
    kept.extend(skipped);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(values: impl IntoIterator<Item = (f64, Option<f64>)>) -> Series {
        let mut series = Series::default();
        values.into_iter().for_each(|(x, y)| series.push(x, y));
        series
    }

    #[test]
    fn thinning_keeps_the_extremes_and_the_ends() {
        let mut points: Vec<(f64, Option<f64>)> = (0..300_000).map(|i| (f64::from(i), Some(0.5))).collect();
        points[123_456].1 = Some(0.01);
        points[234_567].1 = Some(0.99);
        let series = series(points);
        let curves = series.pieces();
        assert_eq!((curves.len(), series.extent()), (1, Some((0.01, 0.99))));
        assert!(curves[0].len() <= MAX_POINTS + 2, "{}", curves[0].len());
        assert!(curves[0].contains(&(123_456.0, 0.01)) && curves[0].contains(&(234_567.0, 0.99)));
        assert_eq!(curves[0].first(), Some(&(0.0, 0.5)));
        assert_eq!(curves[0].last(), Some(&(299_999.0, 0.5)));
        assert!(curves[0].windows(2).all(|w| w[0].0 < w[1].0), "in order");
    }

    #[test]
    fn short_curves_are_kept_whole_and_cut_at_gaps() {
        let points =
            [(0.0, Some(1.0)), (1.0, Some(2.0)), (2.0, None), (3.0, Some(f64::NAN)), (4.0, Some(3.0))];
        assert_eq!(series(points).pieces(), vec![vec![(0.0, 1.0), (1.0, 2.0)], vec![(4.0, 3.0)]]);
        assert!(series([]).is_empty() && series([]).pieces().is_empty());
    }

    #[test]
    fn a_long_gap_cuts_a_long_curve() {
        let gap = 100_000..150_000;
        let values = series((0..200_000).map(|i| (f64::from(i), (!gap.contains(&i)).then_some(1.0))));
        let curves = values.pieces();
        let ends: Vec<[f64; 2]> = curves.iter().map(|curve| [curve[0].0, curve[curve.len() - 1].0]).collect();
        assert_eq!(ends, [[0.0, 99_999.0], [150_000.0, 199_999.0]]);
    }

    #[test]
    fn paths_keep_their_ends() {
        let path = (0..=100).map(|i| [0.1 * f64::from(i), 0.0]);
        let kept = thinned_path(path, 3.0);
        assert_eq!(kept.first(), Some(&[0.0, 0.0]));
        assert_eq!(kept.last(), Some(&[10.0, 0.0]));
        assert!((4..=5).contains(&kept.len()));
    }

    fn stretches(values: impl Iterator<Item = char>) -> Stretches<char> {
        let mut stretches = Stretches::default();
        values.enumerate().for_each(|(i, value)| stretches.push(i as f64, value));
        stretches
    }

    #[test]
    fn few_stretches_are_kept_as_they_are() {
        let found = stretches("aaabaacc".chars()).joined();
        let found: Vec<(f64, char)> = found.iter().map(|stretch| (stretch.start, stretch.value)).collect();
        assert_eq!(found, [(0.0, 'a'), (3.0, 'b'), (4.0, 'a'), (6.0, 'c')]);
    }

    #[test]
    fn many_stretches_join_and_stay_few() {
        // A second of flicker between two long states.
        let flicker =
            (0..200_000).map(|i| if (90_000..90_025).contains(&i) && i % 2 == 0 { 'b' } else { 'a' });
        let found = stretches(flicker).joined();
        assert_eq!(found.len(), 1, "{found:?}");
        let endless = stretches((0..200_000).map(|i| if i % 3 == 0 { 'b' } else { 'a' }));
        assert!(endless.found.len() <= 2 * MAX_POINTS && endless.joined().len() <= MAX_POINTS + 2);
    }

    #[test]
    fn places_are_few_and_follow_their_stretches() {
        let (mut places, mut states) = (Places::default(), Stretches::default());
        for frame in 0..200_000 {
            // Laps of 50 m.
            let route_m = f64::from(frame % 1000) * 0.05;
            places.push(route_m);
            states.push(route_m, frame >= 100_000);
        }
        assert!(places.kept.len() <= 2 * MAX_POINTS, "{}", places.kept.len());
        let states = states.joined();
        let along: Vec<(&bool, Vec<f64>)> = places.along(&states).collect();
        assert_eq!(along.len(), 2);
        assert!(along.iter().all(|(_, places)| places.len() > 100));
        assert_eq!(along[0].1.last(), along[1].1.first(), "the stretches join");
    }
}
