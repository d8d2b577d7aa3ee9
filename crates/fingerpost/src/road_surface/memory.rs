//! Memory: the road of the last seconds, carried along under the vehicle.
//!
//! Paper 2, section 7.1: what the camera cannot see from here was often seen before. Another detector's probabilities are
//! gathered in a [`RoadMap`] of log-odds, which stays fixed in the odometry frame while the vehicle moves over it (S. Thrun, W. Burgard
//! and D. Fox, "Probabilistic Robotics", 2005, chapter 9). Where the picture shows the road now, picture and memory are
//! fused; where it does not, the memory stands alone and the surface says that it is remembered.
//!
//! Limits: a map moved by a wrong motion is wrong. So it fades with the motion's uncertainty and the distance driven, the
//! picture outvotes it within a few frames where it sees, and a cell that says next to nothing counts as unknown. Things that
//! move leave their trace for as long. In a camera picture there are no metres: there the memory does nothing.

mod road_map;
mod rolling_grid;
mod sensor_model;

use std::ops::Range;

use fingerpost_vision::fusion::fuse;
use fingerpost_vision::picture::{Plane, Run, ValidityMask};
use fingerpost_vision::road_network::RoadNetwork;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::perspective::clear_unseen;
use super::{
    Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput, RoadMethod, RoadSurface, SurfaceFile,
};
use crate::ground_view::GroundView;
use crate::motion::Motion;
use road_map::RoadMap;
use sensor_model::SensorModel;

/// Settings of the memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct MemoryConfig {
    /// Detector whose surfaces are remembered.
    pub of: RememberedMethod,
    /// Side of a cell of the map, metres; rounded to whole pixels of the ground view.
    #[schemars(range(min = 0.02, max = 2.0))]
    pub cell_m: f64,
    /// Doubt that is left about any pixel of a single frame: its probability counts as at least this and at most 1
    /// less this.
    #[schemars(range(min = 0.01, max = 0.4))]
    pub doubt: f64,
    /// Distance from the camera at which a pixel adds half as much to the map as a near one, metres.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub half_trust_m: f64,
    /// Share of what a cell says that is left when it is seen anew; up to a half, a frame that is sure outvotes the
    /// surest memory.
    #[schemars(range(min = 0.0, max = 0.95))]
    pub keep_seen: f64,
    /// Distance driven over which what is not seen any more fades to a third, metres.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub fade_m: f64,
    /// Probability of road or of none from which a cell that is not seen counts as known.
    #[schemars(range(min = 0.5, max = 0.95))]
    pub min_known: f64,
}

impl Default for MemoryConfig {
    fn default() -> Self {
        Self {
            of: RememberedMethod::default(),
            cell_m: 0.2,
            doubt: 0.2,
            half_trust_m: 12.0,
            keep_seen: 0.5,
            fade_m: 20.0,
            min_known: 0.65,
        }
    }
}

/// Detectors whose surfaces can be remembered.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RememberedMethod {
    /// The papers' histogram back-projection.
    Backprojection,
    /// Whatever looks like a known surface.
    Bank,
    /// A classifier trained as the drive goes.
    Online,
    /// The small network that comes with the program.
    Network,
    /// A segmentation network that a user brings, in programs built for it.
    Onnx,
    /// The network's evidence and the drive's own together: back-projection where colours tell the road, and elsewhere "online",
    /// sharpened by the colours of what it finds; in camera pictures "online".
    #[default]
    Fused,
}

/// What the memory added.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MemoryEvidence {
    /// Share of the ground view that the picture shows, 0 to 1.
    pub seen_share: f64,
    /// Share that is remembered alone, 0 to 1; the rest is unknown.
    pub remembered_share: f64,
    /// Share of what the map said that was left after the vehicle's last motion, 0 to 1.
    pub kept: f64,
}

/// Distance by which the map may be off before its kerbs lie elsewhere, metres: the motion's uncertainty fades the map by a
/// third when it reaches it.
const SHARP_M: f64 = 0.2;
/// What is left when nothing is known of the motion: a frame or two were lost, the vehicle is near where it was.
const KEPT_WITHOUT_MOTION: f64 = 0.5;

/// Another detector with a memory.
pub struct Memory {
    method: RoadMethod,
    config: MemoryConfig,
    seeing: Box<dyn RoadDetector>,
    map: RoadMap,
    /// What is seen in this frame.
    seen: Plane<u8>,
    /// What the map says of each square of the view, 256 standing for 1, and where it says anything.
    prior: Plane<u8>,
    known: Plane<u8>,
    known_pixels: ValidityMask,
    /// A row of the view.
    prior_row: Vec<u8>,
}

impl Memory {
    /// A memory of what `seeing` finds, which calls itself `method`.
    pub fn new(method: RoadMethod, config: &MemoryConfig, seeing: Box<dyn RoadDetector>) -> Self {
        let model = SensorModel::new(config);
        Self {
            method,
            config: config.clone(),
            seeing,
            map: RoadMap::new(model),
            seen: Plane::default(),
            prior: Plane::default(),
            known: Plane::default(),
            known_pixels: ValidityMask::default(),
            prior_row: Vec::new(),
        }
    }

    /// Carries the map along; the share of it that is left.
    fn carry(&mut self, view: &GroundView, motion: Option<&Motion>) -> f64 {
        let Some(motion) = motion else {
            self.map.fade(KEPT_WITHOUT_MOTION);
            return KEPT_WITHOUT_MOTION;
        };
        let moved_m = motion.previous_from_current.translation.vector.norm();
        let middle_m = 0.5 * (view.grid().near_m() + view.grid().far_m());
        let [forward, left, yaw] = [0, 1, 2].map(|axis| motion.covariance[(axis, axis)].max(0.0));
        let off_m = (forward + left + middle_m * middle_m * yaw).sqrt();
        let kept = libm::exp(-moved_m / self.config.fade_m - off_m * off_m / (SHARP_M * SHARP_M));
        self.map.carry(&motion.previous_from_current);
        self.map.fade(kept);
        kept
    }

    /// Fuses what is seen with what is remembered.
    fn fuse(&mut self, validity: &ValidityMask, fused: &mut Plane<u8>) -> Result<(), RoadError> {
        let (width, height) = self.seen.size();
        if fused.size() != (width, height) {
            fused.reset(width, height, 0);
        }
        let side = self.map.side_px();
        let doubt = (255.0 * self.config.doubt).round() as u8;
        self.known_pixels.set_to_union(validity, &self.known, side);
        clear_unseen(&self.known_pixels, fused);
        self.prior_row.resize(width, 0);
        for row in 0..height {
            if row % side == 0 {
                spread(self.prior.row(row / side), side, &mut self.prior_row);
            }
            let (seen, fused) = (self.seen.row(row), fused.row_mut(row));
            let known = self.known_pixels.runs(row);
            let mut done = 0;
            for run in validity.runs(row) {
                let pixels = run.start..run.end;
                copy_runs(known, done..run.start, &self.prior_row, fused);
                fuse(&seen[pixels.clone()], &self.prior_row[pixels.clone()], doubt, &mut fused[pixels])?;
                done = run.end;
            }
            copy_runs(known, done..width, &self.prior_row, fused);
        }
        Ok(())
    }
}

/// Copies what of `runs` lies within `columns`.
fn copy_runs(runs: &[Run], columns: Range<usize>, from: &[u8], to: &mut [u8]) {
    for run in runs {
        let (start, end) = (run.start.max(columns.start), run.end.min(columns.end));
        if start < end {
            to[start..end].copy_from_slice(&from[start..end]);
        }
    }
}

/// Repeats each value `side` times.
fn spread(values: &[u8], side: usize, out: &mut [u8]) {
    // Known sides become copies of whole registers.
    match side {
        2 => spread_by::<2>(values, out),
        3 => spread_by::<3>(values, out),
        4 => spread_by::<4>(values, out),
        _ => out.chunks_mut(side).zip(values).for_each(|(place, value)| place.fill(*value)),
    }
}

fn spread_by<const SIDE: usize>(values: &[u8], out: &mut [u8]) {
    let (places, rest) = out.as_chunks_mut::<SIDE>();
    let (whole, last) = values.split_at(places.len().min(values.len()));
    places.iter_mut().zip(whole).for_each(|(place, value)| *place = [*value; SIDE]);
    rest.fill(last.first().copied().unwrap_or(0));
}

impl RoadDetector for Memory {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let Perspective::Ground { view, .. } = input.perspective else {
            let evidence = self.seeing.estimate(input, probability)?;
            return Ok(RoadEvidence { detector: self.method.name(), ..evidence });
        };
        let mut evidence = self.seeing.estimate(input, &mut self.seen)?;
        evidence.detector = self.method.name();
        self.map.lie_under(view, self.config.cell_m);
        let kept = self.carry(view, input.motion);
        self.map.read(&mut self.prior, &mut self.known);
        self.fuse(input.validity, probability)?;
        self.map.add(&self.seen, input.validity);
        let pixels = (self.seen.as_slice().len() as f64).max(1.0);
        let (known, seen) = (self.known_pixels.seen() as f64, input.validity.seen() as f64);
        evidence.memory = Some(MemoryEvidence {
            seen_share: seen / pixels,
            remembered_share: (known - seen) / pixels,
            kept,
        });
        Ok(evidence)
    }

    fn detect(&mut self, input: RoadInput<'_>, surface: &mut RoadSurface) -> Result<RoadEvidence, RoadError> {
        let evidence = self.estimate(input, &mut surface.probability)?;
        surface.uninformed_log_odds = evidence.uninformed_log_odds;
        surface.reduced_rows = evidence.reduced_rows;
        let known = match input.perspective {
            Perspective::Camera { .. } => input.validity,
            Perspective::Ground { .. } => &self.known_pixels,
        };
        surface.sums.rebuild(surface.probability.view(), known)?;
        Ok(evidence)
    }

    fn know(&mut self, surfaces: &SurfaceFile) -> Result<(), RoadError> {
        self.seeing.know(surfaces)
    }

    fn known_surfaces(&self) -> Option<SurfaceFile> {
        self.seeing.known_surfaces()
    }

    fn network(&self) -> Option<&RoadNetwork> {
        self.seeing.network()
    }

    fn reset(&mut self) {
        self.seeing.reset();
        self.map.forget();
    }
}
