//! Lines: votes for every angle and distance, and their local maxima.

use std::cmp::Reverse;
use std::f64::consts::FRAC_PI_2;
use std::ops::{Range, RangeInclusive};

use super::{HoughError, HoughLine, HoughParams};
use crate::bit_plane::{BitPlane, WORD_PX};
use crate::picture::PlaneView;
use crate::simd::{CodePath, simd_kernel};

/// Angles that are voted for together. A vote waits for the last one in its bin, so that neighbours on a line hold each
/// other up; four independent ones fill the wait, and their bins still fit the fastest cache.
const ANGLES_TOGETHER: usize = 4;
/// Bins that are asked together whether one of them has enough votes.
const BINS_TOGETHER: usize = 128;
/// Lines for which there is room from the start; a window of a road shows fewer.
const USUAL_LINES: usize = 1024;
/// 1.5 * 2^23: a sum with it has no room for a fraction, so a small number plus this is rounded to the nearest whole one,
/// halves to even, and stands in the lowest bits.
const ROUNDING: f32 = 12_582_912.0;

/// Finds straight lines, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::hough::{HoughLines, HoughParams};
/// use fingerpost_vision::picture::Plane;
/// let mut edges = Plane::new(40, 30, 0_u8);
/// edges.row_mut(7).fill(255);
/// let params = HoughParams { rho_step_px: 1.0, theta_step_rad: 1_f64.to_radians(), votes: 20 };
/// let mut finder = HoughLines::new(params)?;
/// let strongest = finder.find(edges.view())[0];
/// assert_eq!((strongest.rho_px, strongest.votes), (7.0, 40));
/// assert!((strongest.theta_rad.to_degrees() - 90.0).abs() < 1e-9);
/// # Ok::<(), fingerpost_vision::hough::HoughError>(())
/// ```
#[derive(Debug, Clone)]
pub struct HoughLines {
    params: HoughParams,
    /// Of every angle, its cosine and sine in steps of rho.
    normals: Vec<[f32; 2]>,
    /// Columns a row of the lines of every angle; endless where they are level.
    slopes: Vec<f64>,
    bits: BitPlane,
    /// Columns and rows of the pixels that vote.
    pub(super) places: [Vec<f32>; 2],
    /// Of each of a few angles, the bins that the pixels vote for.
    bins: [Vec<u32>; ANGLES_TOGETHER],
    /// Votes of all bins of an angle, then of the next.
    votes: Vec<u32>,
    /// Indices in `votes` of the lines found.
    found: Vec<usize>,
    pub(super) lines: Vec<HoughLine>,
}

impl HoughLines {
    /// A finder with the given steps.
    ///
    /// # Errors
    /// [`HoughError`] when a step is too fine, too large or no number.
    pub fn new(params: HoughParams) -> Result<Self, HoughError> {
        params.check()?;
        let normal = |angle: f64| {
            [(libm::cos(angle) / params.rho_step_px) as f32, (libm::sin(angle) / params.rho_step_px) as f32]
        };
        Ok(Self {
            params,
            normals: params.angles().map(normal).collect(),
            slopes: params.angles().map(|angle| -libm::tan(angle)).collect(),
            bits: BitPlane::default(),
            places: [Vec::new(), Vec::new()],
            bins: Default::default(),
            votes: Vec::new(),
            found: Vec::with_capacity(USUAL_LINES),
            lines: Vec::with_capacity(USUAL_LINES),
        })
    }

    /// Finds the lines through the pixels of `edges` that are not 0: all that have more votes than the four lines beside
    /// them in rho and theta, those with most votes first.
    pub fn find(&mut self, edges: PlaneView<'_, u8>) -> &[HoughLine] {
        self.find_on(CodePath::fastest(), edges)
    }

    /// The same lines, but those alone that lean to the right, downwards, by so many columns a row.
    pub fn find_leaning(
        &mut self,
        edges: PlaneView<'_, u8>,
        columns_per_row: RangeInclusive<f64>,
    ) -> &[HoughLine] {
        self.find_leaning_on(CodePath::fastest(), edges, columns_per_row)
    }

    pub(super) fn find_on(&mut self, path: CodePath, edges: PlaneView<'_, u8>) -> &[HoughLine] {
        let all = 0..self.normals.len();
        self.find_among(path, edges, [all.clone(), all.end..all.end])
    }

    fn find_leaning_on(
        &mut self,
        path: CodePath,
        edges: PlaneView<'_, u8>,
        columns_per_row: RangeInclusive<f64>,
    ) -> &[HoughLine] {
        // Angles up to a right one lean to the left, the more the larger they are, and further ones to the right, the less.
        let upright = self.params.angles().take_while(|angle| *angle <= FRAC_PI_2).count();
        let among = |angles: Range<usize>| {
            let leans = |angle: &usize| columns_per_row.contains(&self.slopes[*angle]);
            let first = angles.clone().find(leans).unwrap_or(angles.end);
            first..angles.rev().find(leans).map_or(first, |last| last + 1)
        };
        let angles = [among(0..upright), among(upright..self.normals.len())];
        self.find_among(path, edges, angles)
    }

    /// The lines of two ranges of angles, the second behind the first.
    fn find_among(
        &mut self,
        path: CodePath,
        edges: PlaneView<'_, u8>,
        angles: [Range<usize>; 2],
    ) -> &[HoughLine] {
        self.bits.fill_from(path, edges);
        self.collect_places();
        self.lines.clear();
        // No line has more votes than there are pixels.
        if self.places[0].len() <= self.params.votes as usize {
            return &self.lines;
        }
        // Bins on either side of rho 0 so that no pixel falls beyond, and one more at either end that gets no vote.
        let diagonal_px = libm::hypot(edges.width() as f64, edges.height() as f64);
        let middle = (diagonal_px / self.params.rho_step_px).ceil() as usize + 1;
        let bins = 2 * middle + 1;
        self.votes.resize(bins * self.normals.len(), 0);
        for of_pixels in &mut self.bins {
            of_pixels.resize(self.places[0].len(), 0);
        }
        let mut voted = 0;
        for angles in angles.iter().filter(|angles| !angles.is_empty()) {
            // Lines have more votes than those of the angles beside them, which are asked too.
            let with_neighbours = angles.start.saturating_sub(1)..(angles.end + 1).min(self.normals.len());
            self.vote(path, bins, middle, with_neighbours.start.max(voted)..with_neighbours.end);
            voted = with_neighbours.end;
        }
        self.found.clear();
        for angles in angles {
            self.collect_maxima(path, bins, angles);
        }
        let votes = &self.votes;
        self.found.sort_unstable_by_key(|&index| (Reverse(votes[index]), index));
        self.lines.extend(self.found.iter().map(|&index| HoughLine {
            rho_px: ((index % bins) as f64 - middle as f64) * self.params.rho_step_px,
            theta_rad: (index / bins) as f64 * self.params.theta_step_rad,
            votes: self.votes[index],
        }));
        &self.lines
    }

    fn collect_places(&mut self) {
        let [columns, rows] = &mut self.places;
        columns.clear();
        rows.clear();
        for (y, words) in self.bits.rows().enumerate() {
            for (index, &word) in words.iter().enumerate() {
                let mut word = word;
                while word != 0 {
                    columns.push((index * WORD_PX) as f32 + word.trailing_zeros() as f32);
                    word &= word - 1;
                }
            }
            rows.resize(columns.len(), y as f32);
        }
    }

    /// Lets the pixels vote for the lines of some angles.
    fn vote(&mut self, path: CodePath, bins: usize, middle: usize, angles: Range<usize>) {
        let [columns, rows] = &self.places;
        let Some(votes) = self.votes.get_mut(bins * angles.start..bins * angles.end) else { return };
        votes.fill(0);
        let normals = self.normals.get(angles).unwrap_or_default();
        for (votes, normals) in votes.chunks_mut(bins * ANGLES_TOGETHER).zip(normals.chunks(ANGLES_TOGETHER))
        {
            for (of_pixels, &normal) in self.bins.iter_mut().zip(normals) {
                bins_of(path, columns, rows, normal, middle as u32, of_pixels);
            }
            if votes.len() == bins * ANGLES_TOGETHER {
                count_together(votes, bins, self.bins.each_ref().map(Vec::as_slice));
            } else {
                for (votes, of_pixels) in votes.chunks_mut(bins).zip(&self.bins) {
                    of_pixels.iter().for_each(|&bin| count(votes, bin));
                }
            }
        }
    }

    /// Finds the bins of some angles that have enough votes, more than those before them and as many as those behind them.
    fn collect_maxima(&mut self, path: CodePath, bins: usize, angles: Range<usize>) {
        let (votes, enough) = (&self.votes, self.params.votes);
        let at = |index: Option<usize>| index.and_then(|index| votes.get(index)).copied().unwrap_or(0);
        let first = bins * angles.start;
        let of_angles = votes.get(first..bins * angles.end).unwrap_or_default();
        for (number, together) in of_angles.chunks(BINS_TOGETHER).enumerate() {
            if !any_above(path, together, enough) {
                continue;
            }
            for (offset, &own) in together.iter().enumerate() {
                let index = first + number * BINS_TOGETHER + offset;
                // The first and the last bin of every angle are empty, so the neighbours are of the same angle.
                if own > enough
                    && own > at(index.checked_sub(1))
                    && own >= at(index.checked_add(1))
                    && own > at(index.checked_sub(bins))
                    && own >= at(index.checked_add(bins))
                {
                    self.found.push(index);
                }
            }
        }
    }
}

#[inline(always)]
fn count(votes: &mut [u32], bin: u32) {
    if let Some(votes) = votes.get_mut(bin as usize) {
        *votes += 1;
    }
}

/// Counts the pixels' votes for [`ANGLES_TOGETHER`] angles with `bins_an_angle` bins each.
fn count_together(votes: &mut [u32], bins_an_angle: usize, bins: [&[u32]; ANGLES_TOGETHER]) {
    let (votes_0, rest) = votes.split_at_mut(bins_an_angle);
    let (votes_1, rest) = rest.split_at_mut(bins_an_angle);
    let (votes_2, votes_3) = rest.split_at_mut(bins_an_angle);
    let [bins_0, bins_1, bins_2, bins_3] = bins;
    for (((&bin_0, &bin_1), &bin_2), &bin_3) in bins_0.iter().zip(bins_1).zip(bins_2).zip(bins_3) {
        count(votes_0, bin_0);
        count(votes_1, bin_1);
        count(votes_2, bin_2);
        count(votes_3, bin_3);
    }
}

simd_kernel! {
    /// The bin of each place's rho, where rho 0 has the bin `middle`.
    fn bins_of(columns: &[f32], rows: &[f32], normal: [f32; 2], middle: u32, bins: &mut [u32]) {
        let first = ROUNDING.to_bits().wrapping_sub(middle);
        let [cos, sin] = normal;
        for ((bin, &u), &v) in bins.iter_mut().zip(columns).zip(rows) {
            *bin = (u * cos + v * sin + ROUNDING).to_bits().wrapping_sub(first);
        }
    }
}

simd_kernel! {
    fn any_above(votes: &[u32], limit: u32) -> bool {
        votes.iter().fold(false, |any, &votes| any | (votes > limit))
    }
}
