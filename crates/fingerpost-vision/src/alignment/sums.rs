//! Residuals of a warp and the sums over them.

#[cfg(target_arch = "x86_64")]
mod avx512;
mod step;

use step::{ENTRIES, StepPoints, StepSums, accumulate};

use super::{LANES, Lanes, ProjectiveMap, Target, Template, UNKNOWNS};
use crate::picture::Plane;
#[cfg(target_arch = "x86_64")]
use crate::simd::InstructionSet;
use crate::simd::{CodePath, simd_kernel};

/// Degrees of freedom of Student's t distribution, by which the scale is measured: heavy tails, as residuals of pictures
/// have (Kerl et al. 2013). With x the residual in standard deviations, a weight is 1 / (1 + x^2 / 5)^4: close to Welsch's
/// exp(-4 x^2 / 5), and the same to the bit everywhere.
const FREEDOM: f32 = 5.0;
/// How the newer picture's grey follows from the older one's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brightness {
    /// Factor.
    pub gain: f32,
    /// Grey levels added.
    pub offset: f32,
}

impl Default for Brightness {
    fn default() -> Self {
        Self { gain: 1.0, offset: 0.0 }
    }
}

/// What a warp leaves of each point, and the sums of it that need no derivatives.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Residuals {
    residual: Vec<Lanes>,
    weight: Vec<Lanes>,
    /// Number of points that were led to seen pixels.
    pub seen: f32,
    /// Sum of the weights.
    pub weight_sum: f32,
    /// Sum of the residuals squared, each with its weight in the scale of a t distribution, grey levels squared.
    pub square_sum: f32,
    /// Sum of weight times residual.
    pub residual_sum: f32,
    /// Sum of weight times residual times the template's grey.
    pub grey_residual_sum: f32,
    /// Sum of weight times the template's grey.
    pub grey_sum: f32,
    /// Sum of weight times the template's grey squared.
    pub grey_square_sum: f32,
}

/// The sums of a Gauss-Newton step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sums {
    /// Weighted products of the steepest-descent images, symmetric.
    pub hessian: [[f32; UNKNOWNS]; UNKNOWNS],
    /// Weighted products of them with the residuals.
    pub gradient: [f32; UNKNOWNS],
    /// What the Hessian's first entry would be had every seen point a weight of 1.
    pub unweighted: f32,
}

impl Residuals {
    /// Samples `target` where `warp` leads each point of `template`. `scale` is the residuals' standard deviation, grey
    /// levels, from which their weights follow.
    pub fn measure(
        &mut self,
        template: &Template,
        target: &Target,
        warp: &ProjectiveMap,
        brightness: Brightness,
        scale: f32,
    ) {
        self.measure_with(CodePath::fastest(), template, target, warp, brightness, scale);
    }

    pub(super) fn measure_with(
        &mut self,
        path: CodePath,
        template: &Template,
        target: &Target,
        warp: &ProjectiveMap,
        brightness: Brightness,
        scale: f32,
    ) {
        for lanes in [&mut self.residual, &mut self.weight] {
            lanes.reserve(template.u.capacity().saturating_sub(lanes.len()));
            lanes.resize(template.u.len(), [0.0; LANES]);
        }
        let points = SamplePoints {
            places: [&template.u, &template.v],
            grey: &template.grey,
            trust: &template.trust,
            warp,
            brightness,
            inverse_variance: 1.0 / (scale * scale).max(f32::MIN_POSITIVE),
        };
        let (cells, residuals, weights) = (&target.cells, &mut self.residual[..], &mut self.weight[..]);
        let sums = match path.instruction_set() {
            // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
            // Benefit: see the function.
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            InstructionSet::Avx512 => unsafe { avx512::sample(&points, cells, residuals, weights) },
            _ => sample(path, &points, cells, residuals, weights),
        };
        [
            self.seen,
            self.weight_sum,
            self.square_sum,
            self.residual_sum,
            self.grey_residual_sum,
            self.grey_sum,
            self.grey_square_sum,
        ] = sums.map(|lanes| total(&lanes));
    }

    /// The sums for a Gauss-Newton step of the template that was measured last.
    #[must_use]
    pub fn sums(&self, template: &Template) -> Sums {
        self.sums_with(CodePath::fastest(), template)
    }

    pub(super) fn sums_with(&self, path: CodePath, template: &Template) -> Sums {
        let points = StepPoints {
            descent: template.descent.each_ref().map(Vec::as_slice),
            residuals: &self.residual,
            weights: &self.weight,
            trust: &template.trust,
        };
        let StepSums { products, gradient, unweighted } = match path.instruction_set() {
            // SAFETY: a `CodePath` exists only where the processor has its instruction set, and these are its features.
            // Benefit: see the function.
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code)]
            InstructionSet::Avx512 => unsafe { avx512::accumulate(&points) },
            _ => accumulate(path, &points),
        };
        let mut hessian = [[0.0; UNKNOWNS]; UNKNOWNS];
        for ((row, column), product) in ENTRIES.into_iter().zip(products) {
            hessian[row][column] = total(&product);
            hessian[column][row] = hessian[row][column];
        }
        Sums { hessian, gradient: gradient.map(|lanes| total(&lanes)), unweighted: total(&unweighted) }
    }

    /// Weight of a point, 0 (unseen) to 1; `None` beyond the last.
    #[must_use]
    pub fn weight(&self, point: usize) -> Option<f32> {
        Some(self.weight.get(point / LANES)?[point % LANES])
    }

    /// Residual of a point, grey levels; `None` beyond the last.
    #[must_use]
    pub fn residual(&self, point: usize) -> Option<f32> {
        Some(self.residual.get(point / LANES)?[point % LANES])
    }
}

/// The sum of the lanes, by halves: the same on every path.
#[inline(always)]
fn total(lanes: &Lanes) -> f32 {
    let mut lanes = *lanes;
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}

/// See [`split`].
const WHOLE: f32 = 8_388_608.0;

/// The pixel at or before a place of 0 or more, and how far the place lies beyond it, 0 to 1.
///
/// A float of 2^23 or more has no digits behind the point: adding that much rounds, and leaves the whole number in the low
/// bits. Casts to integers would have to treat what does not fit, which no vector instruction does.
#[inline(always)]
fn split(place: f32) -> (u32, f32) {
    let before = place - 0.5;
    let shifted = if before > 0.0 { before } else { 0.0 } + WHOLE;
    (shifted.to_bits() & 0x7f_ffff, place - (shifted - WHOLE))
}

/// What is sampled: points, and how they are led to the newer picture.
struct SamplePoints<'a> {
    places: [&'a [Lanes]; 2],
    grey: &'a [Lanes],
    trust: &'a [Lanes],
    warp: &'a ProjectiveMap,
    brightness: Brightness,
    inverse_variance: f32,
}

simd_kernel! {
    /// Fills residuals and weights, and returns the sums of [`Residuals`], lane by lane.
    fn sample(
        points: &SamplePoints<'_>, cells: &Plane<u32>, residuals: &mut [Lanes], weights: &mut [Lanes],
    ) -> [Lanes; 7] {
        let SamplePoints { places: [u, v], grey, trust, warp, brightness, inverse_variance } = *points;
        let groups = residuals.len();
        let [u, v, grey, trust] = [u, v, grey, trust].map(|lanes| &lanes[..groups]);
        let weights = &mut weights[..groups];
        let (cells, size) = (cells.as_slice(), [cells.width(), cells.height()]);
        // The last pixel has no right neighbour: its cell is unseen.
        let nowhere = cells.len().saturating_sub(1) as u32;
        let (right, bottom) = (size[0].saturating_sub(1) as f32, size[1].saturating_sub(1) as f32);
        let mut sums = [[0.0_f32; LANES]; 7];
        for group in 0..groups {
            let (u, v, grey, trust) = (&u[group], &v[group], &grey[group], &trust[group]);
            let (mut share_u, mut share_v) = ([0.0_f32; LANES], [0.0_f32; LANES]);
            let mut index = [0_u32; LANES];
            for lane in 0..LANES {
                let [place_u, place_v] = warp.at(u[lane], v[lane]);
                let inside = (place_u >= 0.0) & (place_u < right) & (place_v >= 0.0) & (place_v < bottom);
                let ((column, right_share), (row, lower_share)) = (split(place_u), split(place_v));
                share_u[lane] = right_share;
                share_v[lane] = lower_share;
                let at = row.wrapping_mul(size[0] as u32).wrapping_add(column);
                index[lane] = if inside { at } else { nowhere };
            }
            let mut cell = [0_u32; LANES];
            for lane in 0..LANES {
                cell[lane] = cells.get(index[lane] as usize).copied().unwrap_or(0);
            }
            let (residual_out, weight_out) = (&mut residuals[group], &mut weights[group]);
            for lane in 0..LANES {
                let corner = |shift: u32| ((cell[lane] >> shift) & 0xff) as i32 as f32;
                let (a, b, c, d) = (corner(0), corner(8), corner(16), corner(24));
                let upper = a + (b - a) * share_u[lane];
                let lower = c + (d - c) * share_u[lane];
                let sampled = upper + (lower - upper) * share_v[lane];
                let visible = a.min(b).min(c.min(d)) > 0.0;
                let seen = if visible { 1.0 } else { 0.0 };
                let expected = brightness.gain * grey[lane] + brightness.offset;
                let residual = if visible { sampled - expected } else { 0.0 };
                let square = residual * residual;
                let share = FREEDOM / (FREEDOM + square * inverse_variance);
                let square_share = share * share;
                let weight = (seen * trust[lane]) * (square_share * square_share);
                let weighted = weight * residual;
                residual_out[lane] = residual;
                weight_out[lane] = weight;
                sums[0][lane] += seen;
                sums[1][lane] += weight;
                sums[2][lane] += ((FREEDOM + 1.0) / FREEDOM) * (share * square);
                sums[3][lane] += weighted;
                sums[4][lane] += weighted * grey[lane];
                sums[5][lane] += weight * grey[lane];
                sums[6][lane] += (weight * grey[lane]) * grey[lane];
            }
        }
        sums
    }
}
