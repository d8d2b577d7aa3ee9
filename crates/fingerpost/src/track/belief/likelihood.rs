//! How probable what was seen of the ground is, given where a feature lies and what is not known of it.
//!
//! The ground under the feature's outline looks like road, but for a share of it; what lies just beside looks like none, but
//! for a larger share; farther off anything may lie. Every cell of the map thus adds a log-likelihood that depends on its
//! signed distance from the edge alone, held against that of ground of which nothing is known. Neighbouring cells err together: only so many square
//! metres of ground are one witness. And whole stretches err, in shade or behind parked cars: each shows or is hidden.

use std::ops::Range;

use nalgebra::{Isometry2, Point2, SMatrix, Vector2};

use super::ground_memory::{GroundCell, SPEAKS_FOR_M2};
use super::junction_shape::{
    FORWARD, HEADING, LEFT, MOST_ARMS, PITCH, ROLL, SCALE, STRETCHES, Surroundings, UNKNOWNS, Unknowns,
};
use crate::ground_view::Viewpoint;

/// Ground that errs together, square metres: with it error / sigma is about one where the surface is that of the truth.
const WITNESS_M2: f64 = 1.0;
/// Softness of an edge of the road surface, metres: cells and pixels at 10 m.
const SHARP_M: f64 = 0.15;
/// An edge is felt so many times its softness away: a logistic distribution has an eighth of its mass beyond, on either side.
const FELT_SOFTNESSES: f64 = 2.0;
/// Width of the ground beside a road that is held for none, metres.
const BESIDE_M: f64 = 1.5;
/// Share of the road that looks like none: parked cars, shadows, paint.
const ROAD_UNLIKE: f64 = 0.05;
/// Share of the ground beside it that looks like road: drives, forecourts.
const BESIDE_ALIKE: f64 = 0.1;
/// Share of ground of which nothing is known that looks like road.
const ANYWHERE_ALIKE: f64 = 0.3;

/// Information about the unknowns.
pub(super) type Information = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// The pose of the feature among the unknowns.
pub(super) fn pose_of(unknowns: &Unknowns) -> Isometry2<f64> {
    Isometry2::new(Vector2::new(unknowns[FORWARD], unknowns[LEFT]), unknowns[HEADING])
}

/// Puts the pose of the feature among the unknowns.
pub(super) fn set_pose(unknowns: &mut Unknowns, pose: &Isometry2<f64>) {
    (unknowns[FORWARD], unknowns[LEFT]) = (pose.translation.x, pose.translation.y);
    unknowns[HEADING] = pose.rotation.angle();
}

/// Logarithm of the sum of two numbers that are given by theirs.
pub(super) fn log_sum(a: f64, b: f64) -> f64 {
    a.max(b) + libm::log1p(libm::exp(-(a - b).abs()))
}

/// A piece of ground with all that does not depend on the unknowns.
#[derive(Debug, Clone, Copy)]
struct Witness {
    place: Point2<f64>,
    odds: f64,
    log_anywhere: f64,
    witnesses: f64,
    /// How far a row of the picture reaches there, metres: what an edge across the view is blurred by.
    blur_m: f64,
    /// How far inside the road an edge across the view is seen there, metres.
    inset_m: f64,
    /// How far pitch, roll and scale of one move the true place.
    moves: [Vector2<f64>; 3],
}

/// A square of cells.
#[derive(Debug, Clone)]
struct Square {
    /// All of them as one.
    whole: Witness,
    cells: Range<usize>,
    /// Log-likelihoods far inside the road, and beside it.
    on_road: f64,
    beside: f64,
}

/// Angles that a row of the camera's picture spans, and one of what the road's detector looks at where that is a reduced picture, radians.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowAngles {
    pub(super) picture_rad: f64,
    pub(super) reduced_rad: f64,
}

/// What is seen of the ground, weighed.
#[derive(Debug, Default)]
pub(super) struct Ground {
    squares: Vec<Square>,
    cells: Vec<Witness>,
}

/// The cells that are near an edge, and what the others say.
#[derive(Debug)]
pub(super) struct NearGround {
    cells: Vec<Witness>,
    /// Log-likelihood of the other squares, by the stretch of an arm that they lie beside.
    rest: [f64; STRETCHES],
    /// Probability that each stretch shows, as of the last look.
    shows: [f64; STRETCHES],
    blocks: Blocks,
}

impl Ground {
    /// Takes squares of cells in place of those before.
    pub(super) fn take<'a>(
        &mut self,
        squares: impl Iterator<Item = &'a [GroundCell]>,
        viewpoint: Viewpoint,
        rows: RowAngles,
    ) {
        self.squares.clear();
        self.cells.clear();
        for cells in squares {
            let start = self.cells.len();
            let count = cells.len().max(1) as f64;
            let mean = |of: fn(&GroundCell) -> f64| cells.iter().map(of).sum::<f64>() / count;
            let whole = GroundCell {
                place: Point2::new(mean(|cell| cell.place.x), mean(|cell| cell.place.y)),
                log_odds: mean(|cell| cell.log_odds),
                trust: count * mean(|cell| cell.trust),
                seen_ahead_m: mean(|cell| cell.seen_ahead_m),
            };
            self.cells.extend(cells.iter().map(|cell| Witness::new(cell, viewpoint, rows)));
            let of = |alike: f64| self.cells[start..].iter().map(|cell| cell.log_likelihood(alike)).sum();
            let (on_road, beside) = (of(1.0 - ROAD_UNLIKE), of(BESIDE_ALIKE));
            let (whole, cells) = (Witness::new(&whole, viewpoint, rows), start..self.cells.len());
            self.squares.push(Square { whole, cells, on_road, beside });
        }
    }

    /// Log-likelihood of ground that is paved all over.
    pub(super) fn log_likelihood_paved(&self) -> f64 {
        self.squares.iter().map(|square| square.on_road).sum()
    }

    /// Log-likelihood with edges as soft as `soft_m`, by every `every`-th square.
    pub(super) fn score(
        &self,
        around: &Surroundings<'_>,
        unknowns: &Unknowns,
        soft_m: f64,
        every: usize,
    ) -> f64 {
        let (feature_from_vehicle, outline) = (pose_of(unknowns).inverse(), around.outlines(unknowns));
        let mut by_stretch = [0.0; STRETCHES];
        for square in self.squares.iter().step_by(every) {
            let place = feature_from_vehicle * square.whole.at(unknowns);
            let Some(edge) = outline.distance(place) else { continue };
            by_stretch[edge.stretch] +=
                every as f64 * square.whole.term(edge.distance_m, soft_m.max(edge.soft_m)).0;
        }
        by_stretch.into_iter().map(|stretch| shown_or_hidden(stretch).0).sum()
    }
}

impl Default for NearGround {
    fn default() -> Self {
        Self { cells: Vec::new(), rest: [0.0; STRETCHES], shows: [0.0; STRETCHES], blocks: Blocks::default() }
    }
}

impl NearGround {
    /// Takes the cells of `ground` that are within `near_m` of an edge; the others are held for what they are with these
    /// unknowns.
    pub(super) fn take(
        &mut self,
        ground: &Ground,
        around: &Surroundings<'_>,
        unknowns: &Unknowns,
        near_m: f64,
    ) {
        let (feature_from_vehicle, outline) = (pose_of(unknowns).inverse(), around.outlines(unknowns));
        self.rest = [0.0; STRETCHES];
        self.cells.clear();
        for square in &ground.squares {
            let Some(edge) = outline.distance(feature_from_vehicle * square.whole.at(unknowns)) else {
                continue;
            };
            let near_m = near_m + FELT_SOFTNESSES * edge.soft_m;
            if edge.distance_m < -near_m {
                self.rest[edge.stretch] += square.on_road;
            } else if edge.distance_m <= near_m {
                self.cells.extend_from_slice(&ground.cells[square.cells.clone()]);
            } else if edge.distance_m <= BESIDE_M {
                self.rest[edge.stretch] += square.beside;
            }
        }
    }

    /// Log-likelihood, its gradient, and the information of the cells about the unknowns: the sum of the outer products of
    /// the gradients of single witnesses, each as far as its stretch showed at the last look (Berndt, Hall, Hall, Hausman: Estimation and inference in nonlinear structural models, 1974).
    pub(super) fn linearised(
        &mut self,
        around: &Surroundings<'_>,
        unknowns: &Unknowns,
    ) -> (f64, Unknowns, Information) {
        let vehicle_from_feature = pose_of(unknowns);
        let (feature_from_vehicle, outline) = (vehicle_from_feature.inverse(), around.outlines(unknowns));
        let (mut by_stretch, mut gradient, mut information) =
            (self.rest, Unknowns::zeros(), Information::zeros());
        for cell in &self.cells {
            let place = cell.at(unknowns);
            let Some(edge) = outline.distance(feature_from_vehicle * place) else { continue };
            let normal = vehicle_from_feature.rotation * edge.by_place;
            let shown_m = edge.distance_m + cell.inset_m * normal.x.abs();
            let (term, by_distance) = cell.term(shown_m, softness_m(cell.blur_m * normal.x, edge.soft_m));
            by_stretch[edge.stretch] += term;
            let by_distance = self.shows[edge.stretch] * by_distance;
            if by_distance.abs() < NEGLIGIBLE * cell.witnesses {
                continue;
            }
            // A feature that moves forward moves the place backward in its frame; one that turns left turns it right.
            let from_node = place.coords - vehicle_from_feature.translation.vector;
            let [pitch, roll, scale] = cell.moves.map(|moves| normal.dot(&moves));
            let by_heading = normal.x * from_node.y - normal.y * from_node.x;
            let mut parts = Parts::default();
            for (index, by) in [
                (FORWARD, -normal.x),
                (LEFT, -normal.y),
                (HEADING, by_heading),
                (PITCH, pitch),
                (ROLL, roll),
                (SCALE, scale),
            ] {
                parts.push(index, by);
            }
            outline.each_derivative(&edge, |index, by| parts.push(index, by));
            self.blocks.add(&parts, by_distance, by_distance * by_distance / cell.witnesses);
        }
        self.blocks.empty_into(&mut gradient, &mut information);
        let mut sum = 0.0;
        for (stretch, shows) in by_stretch.into_iter().zip(&mut self.shows) {
            let (log_likelihood, probability) = shown_or_hidden(stretch);
            sum += log_likelihood;
            *shows = probability;
        }
        (sum, gradient, information)
    }
}

/// Rows of the picture by which an edge of the road surface is off, one standard deviation.
const BLURRED_ROWS: f64 = 0.5;
/// Rows of a reduced picture by which an edge is seen too far inside the road, because ground beside it is surer than road, and
/// log-odds are interpolated: with it the town's junctions are 0.13 m too far ahead in the mean, 15 to 20 m before them, without it
/// 0.27 m, and those of two recorded streets are placed better as well.
pub(super) const INSET_ROWS: f64 = 0.65;
/// Share of stretches of arms that are hidden, or that the surface errs about as a whole: in shade, behind parked cars.
const HIDDEN: f64 = 0.05;

/// Log-likelihood of a stretch that shows with this one, or is hidden and then says nothing; and the probability that it shows.
fn shown_or_hidden(log_likelihood: f64) -> (f64, f64) {
    let odds_hidden = HIDDEN / (1.0 - HIDDEN) * libm::exp(-log_likelihood);
    let shows = 1.0 / (1.0 + odds_hidden);
    let sum = if odds_hidden > 1.0 {
        libm::log(HIDDEN) + libm::log1p(1.0 / odds_hidden)
    } else {
        libm::log(1.0 - HIDDEN) + log_likelihood + libm::log1p(odds_hidden)
    };
    (sum, shows)
}

/// Softness of an edge that is blurred by so much besides, and is soft itself, metres.
fn softness_m(blurred_m: f64, soft_m: f64) -> f64 {
    (SHARP_M * SHARP_M + blurred_m * blurred_m + soft_m * soft_m).sqrt()
}

/// Derivatives smaller than this share of a witness move nothing.
const NEGLIGIBLE: f64 = 1e-4;
/// Most unknowns that concern one cell: pose, camera, width and offset of two arms, a corner.
const MOST_PARTS: usize = 12;

/// Most kinds of cells: beside either edge of an arm, in the corner between two, where one of both edges may not matter, and about
/// another feature.
const MOST_BLOCKS: usize = 5 * MOST_ARMS + 1;

/// The unknowns that concern a cell, with the derivatives of its distance.
#[derive(Debug, Default)]
struct Parts {
    indices: [usize; MOST_PARTS],
    by: [f64; MOST_PARTS],
    count: usize,
}

impl Parts {
    fn push(&mut self, index: usize, by: f64) {
        if let (Some(place), Some(value)) = (self.indices.get_mut(self.count), self.by.get_mut(self.count)) {
            (*place, *value) = (index, by);
            self.count += 1;
        }
    }
}

/// Sums over the cells that the same unknowns concern: as dense as they are, they need no look-ups.
#[derive(Debug)]
struct Block {
    indices: [usize; MOST_PARTS],
    count: usize,
    gradient: [f64; MOST_PARTS],
    information: [[f64; MOST_PARTS]; MOST_PARTS],
}

/// The sums of all cells, block by block; their memory is reused.
#[derive(Debug, Default)]
struct Blocks {
    blocks: Vec<Block>,
    used: usize,
    last: usize,
}

impl Blocks {
    /// Adds a cell whose log-likelihood changes by `slope` for a metre, and that weighs so much.
    fn add(&mut self, parts: &Parts, slope: f64, weight: f64) {
        let serves = |block: &Block| block.count == parts.count && block.indices == parts.indices;
        if !self.blocks[..self.used].get(self.last).is_some_and(serves) {
            self.last = self.blocks[..self.used].iter().position(serves).unwrap_or_else(|| self.begin(parts));
        }
        let Some(block) = self.blocks.get_mut(self.last) else { return };
        for (sums, (gradient, by)) in
            block.information.iter_mut().zip(block.gradient.iter_mut().zip(parts.by))
        {
            *gradient += slope * by;
            let weighted = weight * by;
            sums.iter_mut().zip(parts.by).for_each(|(sum, by)| *sum += weighted * by);
        }
    }

    /// A new block for these unknowns; its place.
    fn begin(&mut self, parts: &Parts) -> usize {
        // So that no later look needs more memory.
        self.blocks.reserve(MOST_BLOCKS.saturating_sub(self.blocks.len()));
        let block = Block {
            indices: parts.indices,
            count: parts.count,
            gradient: [0.0; MOST_PARTS],
            information: [[0.0; MOST_PARTS]; MOST_PARTS],
        };
        match self.blocks.get_mut(self.used) {
            Some(place) => *place = block,
            None => self.blocks.push(block),
        }
        self.used += 1;
        self.used - 1
    }

    /// Adds the sums to those of all unknowns, and forgets them.
    fn empty_into(&mut self, gradient: &mut Unknowns, information: &mut Information) {
        for block in &self.blocks[..self.used] {
            let of_block = &block.indices[..block.count];
            for ((&row, sums), by) in of_block.iter().zip(&block.information).zip(block.gradient) {
                gradient[row] += by;
                of_block.iter().zip(sums).for_each(|(&column, sum)| information[(row, column)] += sum);
            }
        }
        self.used = 0;
    }
}

impl Witness {
    fn new(cell: &GroundCell, viewpoint: Viewpoint, rows: RowAngles) -> Self {
        let odds = libm::exp(cell.log_odds);
        let Viewpoint { foot, height_m } = viewpoint;
        let from_foot = cell.place - foot;
        let (ahead_m, left_m) = (cell.seen_ahead_m, from_foot.y);
        let across = ahead_m * left_m / height_m;
        let by_angle_m = (ahead_m * ahead_m + height_m * height_m) / height_m;
        // A camera that looks lower than it is believed to shows everything too far away (`ground_view/turn.rs`).
        let pitch = -Vector2::new(by_angle_m, across);
        let roll = Vector2::new(across, (left_m * left_m + height_m * height_m) / height_m);
        Self {
            place: cell.place,
            odds,
            log_anywhere: libm::log(ANYWHERE_ALIKE * odds + 1.0 - ANYWHERE_ALIKE),
            blur_m: BLURRED_ROWS * rows.picture_rad * by_angle_m,
            inset_m: INSET_ROWS * rows.reduced_rad * by_angle_m,
            witnesses: cell.trust * SPEAKS_FOR_M2 / WITNESS_M2,
            moves: [pitch, roll, from_foot],
        }
    }

    /// The true place, vehicle frame.
    fn at(&self, unknowns: &Unknowns) -> Point2<f64> {
        let [pitch, roll, scale] = self.moves;
        self.place + pitch * unknowns[PITCH] + roll * unknowns[ROLL] + scale * unknowns[SCALE]
    }

    /// Log-likelihood at a signed distance from the edge, and its derivative.
    fn term(&self, distance_m: f64, soft_m: f64) -> (f64, f64) {
        if distance_m > BESIDE_M {
            return (0.0, 0.0);
        }
        let on_road = 1.0 / (1.0 + libm::exp((distance_m / soft_m).clamp(-30.0, 30.0)));
        let contrast = 1.0 - ROAD_UNLIKE - BESIDE_ALIKE;
        let alike = BESIDE_ALIKE + contrast * on_road;
        let by_alike = (self.odds - 1.0) / (alike * self.odds + 1.0 - alike);
        let by_distance = -contrast * on_road * (1.0 - on_road) / soft_m;
        (self.log_likelihood(alike), self.witnesses * by_alike * by_distance)
    }

    /// Log-likelihood where this share of the ground looks like road, against ground of which nothing is known.
    fn log_likelihood(&self, alike: f64) -> f64 {
        self.witnesses * (libm::log(alike * self.odds + 1.0 - alike) - self.log_anywhere)
    }
}
