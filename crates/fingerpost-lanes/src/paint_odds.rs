//! The odds of paint against all else that is brighter than the road: kerbs, bare soil at the asphalt's edge, seams.
//!
//! Paint lies on one surface, which goes on beyond it; it stands out from that; lines are painted in few widths and are even
//! curves; and where one line of a lane is painted, the other one mostly is. Each of these is weighed by how it is distributed
//! over paint and over what else bounds a bar, place by place along the line.

use super::lane_filter::EdgePoint;
use super::paint::{PAINT_WIDTH_M, PaintEdge, PaintSides};

/// Length of road that counts as one place, metres.
pub(super) const PLACE_M: f64 = 0.5;
/// Places, 2 m of them, over which what bounds a line is the same, a kerb's stone or a worn stretch of paint: they count once.
const SAME_PLACES: f64 = 4.0;

/// How much the surfaces on both sides of a bar differ against how much the bar differs from them. Paint is that of the marked
/// clips and of simulated markings, worn and in rain; the other bars are kerbs, soil and seams of KITTI's odometry drive 00 and
/// of simulated unmarked roads.
const SIDES_DIFFER: LogNormals = LogNormals { paint: 0.11, other: 0.5, spread: 0.85 };
/// What a picture's noise lets the sides differ by.
const SIDES_DIFFER_NOISE: f64 = 0.03;
/// How much a bar differs from its sides, as the root mean square of the logarithms of the channels' ratios, likewise.
const CONTRAST: LogNormals = LogNormals { paint: 0.55, other: 0.25, spread: 0.65 };
/// Root mean square distance of a paint's and of another bar's inner edge from the fit, in its standard deviations, likewise.
const OFF_LINE_SIGMAS: [f64; 2] = [0.6, 1.3];
/// Widths of lines, metres: ordinary ones (0.10 to 0.15 m), wide ones (0.25 to 0.30 m: RMS-1; twice an ordinary one: MUTCD
/// 3A.06), their spread with wear and blur, and the shares of both; the rest, and what else bounds a bar, has any width.
const LINE_WIDTHS_M: [f64; 2] = [0.125, 0.275];
const LINE_WIDTH_SPREAD_M: f64 = 0.03;
const LINE_SHARES: [f64; 2] = [0.80, 0.15];
/// Share of the places of a painted line whose bar is another one's all the same: in its gaps, in puddles, on reflectors.
const OTHER_SHARE: f64 = 0.1;
/// Share of the lines that are painted where the other line of the lane is: nearly all on the same marked drives, not counted.
const PAINTED_SHARE: f64 = 0.95;

/// Two log-normal distributions of one spread, by their medians: the densities' ratio has no tails in which all else wins.
struct LogNormals {
    paint: f64,
    other: f64,
    /// Of the logarithm.
    spread: f64,
}

impl LogNormals {
    /// Logarithm of the ratio of paint's density to the other one.
    fn log_ratio(&self, value: f64) -> f64 {
        let middle = (self.paint * self.other).sqrt();
        libm::log(self.paint / self.other) * libm::log(value / middle) / (self.spread * self.spread)
    }
}

/// Looks at the bar that a line bounds, sums over them, each weighed as the fit weighs it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct BarLooks {
    weight: f64,
    sides: PaintSides,
    width_m: f64,
    /// Squared distances from the fit, in its standard deviations.
    squares: f64,
}

impl BarLooks {
    /// Whether there are any.
    pub(super) fn is_seen(&self) -> bool {
        self.weight > 0.0
    }

    /// A look; `px_per_m` is the picture's scale across the lane, `point` what the fit made of it.
    pub(super) fn at(paint: &PaintEdge, px_per_m: f64, point: &EdgePoint) -> Self {
        let weight = point.weight;
        let colour = |levels: [f64; 3]| levels.map(|level| weight * level);
        let PaintSides { inside, paint: bar, outside } = paint.sides;
        Self {
            weight,
            sides: PaintSides { inside: colour(inside), paint: colour(bar), outside: colour(outside) },
            width_m: weight * paint.width_px / px_per_m,
            squares: weight * point.squared_deviation(),
        }
    }

    /// Adds looks.
    pub(super) fn merge(&mut self, more: &Self) {
        self.weight += more.weight;
        self.width_m += more.width_m;
        self.squares += more.squares;
        let Self { sides: PaintSides { inside, paint, outside }, .. } = self;
        let others = [more.sides.inside, more.sides.paint, more.sides.outside];
        for (sum, colour) in [inside, paint, outside].into_iter().zip(others) {
            sum.iter_mut().zip(colour).for_each(|(sum, level)| *sum += level);
        }
    }

    /// Logarithm of the odds of paint by these looks; 0 where no bar has been seen.
    pub(super) fn log_odds(&self) -> f64 {
        if !self.is_seen() {
            return 0.0;
        }
        let level = |sum: f64| libm::log(sum / self.weight + 1.0);
        let PaintSides { inside, paint, outside } = self.sides;
        let [inside, paint, outside] = [inside, paint, outside].map(|colour| colour.map(level));
        let mean_square = |of: &dyn Fn(usize) -> f64| (0..3).map(|i| of(i) * of(i)).sum::<f64>() / 3.0;
        let contrast = mean_square(&|i| paint[i] - 0.5 * (inside[i] + outside[i])).sqrt().max(f64::EPSILON);
        let differ = mean_square(&|i| outside[i] - inside[i]).sqrt() / contrast;
        let [paint_off, other_off] = OFF_LINE_SIGMAS;
        let squares = self.squares / self.weight;
        let off_line =
            libm::log(other_off / paint_off) - 0.5 * squares * (paint_off.powi(-2) - other_off.powi(-2));
        SIDES_DIFFER.log_ratio(libm::hypot(differ, SIDES_DIFFER_NOISE))
            + CONTRAST.log_ratio(contrast)
            + off_line
            + width(self.width_m / self.weight)
    }
}

/// The odds of a line, by its places from one end to the other.
#[derive(Debug, Default)]
pub(super) struct LineOdds {
    place: usize,
    bars: BarLooks,
    looks: f64,
    log_odds: f64,
}

impl LineOdds {
    /// Adds the bars that were seen at a place, counted along the line, in so many looks at it.
    pub(super) fn add(&mut self, place: usize, bars: &BarLooks, looks: f64) {
        if place != self.place {
            self.end_place();
            self.place = place;
        }
        self.bars.merge(bars);
        self.looks += looks;
    }

    /// The same in a frame, in which the looks are those that showed a bar.
    pub(super) fn add_seen(&mut self, place: usize, bars: &BarLooks) {
        self.add(place, bars, bars.weight);
    }

    /// Logarithm of the odds of paint.
    pub(super) fn log_odds(mut self) -> f64 {
        self.end_place();
        self.log_odds
    }

    fn end_place(&mut self) {
        let (bars, looks) = (std::mem::take(&mut self.bars), std::mem::take(&mut self.looks));
        if bars.is_seen() {
            // A look that showed no bar on the line says nothing either way.
            let share = (bars.weight / looks).min(1.0);
            let odds = (1.0 - OTHER_SHARE) * libm::exp(bars.log_odds()) + OTHER_SHARE;
            self.log_odds += share * libm::log(odds) / SAME_PLACES;
        }
    }
}

/// Logarithms of the odds that either line of a lane is painted, given those of its own looks. A road may be marked or not; on a
/// marked one most lines are painted, on the other none is.
pub(super) fn of_both(log_odds: [f64; 2]) -> [f64; 2] {
    let odds = log_odds.map(libm::exp);
    [0, 1].map(|line: usize| {
        // What both show if the road is marked, against what they show if it is not, which is as likely.
        let other = PAINTED_SHARE * odds[1 - line] + 1.0 - PAINTED_SHARE;
        libm::log(PAINTED_SHARE * odds[line] * other / ((1.0 - PAINTED_SHARE) * other + 1.0))
    })
}

/// Logarithm of the ratio of the densities of a bar's width.
fn width(width_m: f64) -> f64 {
    let any = 1.0 / (PAINT_WIDTH_M[1] - PAINT_WIDTH_M[0]);
    let bell = |middle_m: f64| {
        let off = (width_m - middle_m) / LINE_WIDTH_SPREAD_M;
        libm::exp(-0.5 * off * off) / (LINE_WIDTH_SPREAD_M * std::f64::consts::TAU.sqrt())
    };
    let lines: f64 = LINE_WIDTHS_M.iter().zip(LINE_SHARES).map(|(&m, share)| share * (bell(m) - any)).sum();
    libm::log((any + lines) / any)
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::Pixel;

    use super::*;
    use crate::Side;

    fn point(weight: f64) -> EdgePoint {
        let pixel = Pixel::new(0.0, 0.0);
        EdgePoint { side: Side::Left, pixel, sigma_px: 1.0, column_sigma_px: 1.0, weight }
    }

    fn look(inside: [f64; 3], paint: [f64; 3], outside: [f64; 3], width_m: f64, weight: f64) -> BarLooks {
        let sides = PaintSides { inside, paint, outside };
        let paint = PaintEdge { u: 0.0, width_px: 100.0 * width_m, step: 50.0, second_px: None, sides };
        BarLooks::at(&paint, 100.0, &point(weight))
    }

    /// The odds of a bar by its colours, inside, on and outside it, and its width, as far off the line as other bars mostly are.
    fn log_odds(inside: [f64; 3], paint: [f64; 3], outside: [f64; 3], width_m: f64) -> f64 {
        look(inside, paint, outside, width_m, 0.9).log_odds()
    }

    #[test]
    fn white_and_yellow_paint_is_paint_on_asphalt_and_on_concrete() {
        let white = log_odds([93.0, 87.0, 88.0], [244.0, 241.0, 236.0], [94.0, 87.0, 88.0], 0.13);
        let yellow = log_odds([96.0, 82.0, 68.0], [244.0, 198.0, 64.0], [99.0, 84.0, 74.0], 0.13);
        let on_concrete = log_odds([182.0, 160.0, 138.0], [237.0, 192.0, 94.0], [185.0, 166.0, 148.0], 0.11);
        assert!(white > 4.0 && yellow > 4.0 && on_concrete > 1.0, "{white}, {yellow}, {on_concrete}");
    }

    #[test]
    fn kerbs_and_soil_between_asphalt_and_grass_are_none() {
        let kerb = log_odds([30.0; 3], [99.0; 3], [63.0; 3], 0.10);
        let pale_kerb = log_odds([172.0, 171.0, 169.0], [202.0, 197.0, 190.0], [169.0, 163.0, 153.0], 0.09);
        let soil = log_odds([119.0, 120.0, 122.0], [140.0, 126.0, 98.0], [110.0, 120.0, 80.0], 0.17);
        assert!(kerb < 0.0 && pale_kerb < -1.0 && soil < -1.0, "{kerb}, {pale_kerb}, {soil}");
    }

    #[test]
    fn lines_have_few_widths() {
        let line = |width_m| log_odds([93.0; 3], [180.0; 3], [90.0; 3], width_m);
        assert!(line(0.12) > line(0.27) && line(0.27) > line(0.20) && line(0.27) > line(0.40));
    }

    #[test]
    fn what_winds_beside_the_line_is_rather_a_kerb() {
        let of = |weight| look([93.0; 3], [150.0; 3], [90.0; 3], 0.12, weight).log_odds();
        assert!(of(0.95) > of(0.7) + 1.0, "{}, {}", of(0.95), of(0.7));
    }

    #[test]
    fn a_place_counts_once_however_often_it_is_seen_and_less_where_it_often_is_not() {
        let look = look([93.0; 3], [180.0; 3], [90.0; 3], 0.12, 0.95);
        let of_places = |places: &[usize]| {
            let mut line = LineOdds::default();
            places.iter().for_each(|&place| line.add_seen(place, &look));
            line.log_odds()
        };
        let four = of_places(&[0, 1, 2, 3]);
        assert!(four > 3.0, "{four}");
        assert!((of_places(&[0, 0, 1, 1, 2, 3]) - four).abs() < 1e-9);
        assert!(of_places(&[]).abs() < 1e-12);
        let mut seen_once_in_four = LineOdds::default();
        (0..4).for_each(|place| seen_once_in_four.add(place, &look, 4.0 * 0.95));
        assert!((seen_once_in_four.log_odds() - 0.25 * four).abs() < 1e-9);
    }

    #[test]
    fn a_painted_line_speaks_for_the_other_one() {
        let [alone, _] = of_both([1.0, 0.0]);
        let [beside, sure] = of_both([1.0, 8.0]);
        assert!(
            (0.8..1.0).contains(&alone) && beside > alone + 2.0 && sure > 7.0,
            "{alone}, {beside}, {sure}"
        );
        assert!(of_both([-5.0, 8.0])[0] < 0.0 && of_both([500.0, -2000.0])[1] < -100.0);
    }

    #[test]
    fn what_has_not_been_seen_says_nothing() {
        assert!(BarLooks::default().log_odds().abs() < 1e-12);
        assert!(log_odds([0.0; 3], [0.0; 3], [0.0; 3], 0.12).is_finite());
    }
}
