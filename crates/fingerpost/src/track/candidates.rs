//! Candidate poses of a feature, and the best of them.
//!
//! The search for a new feature puts the vehicle on the feature's approach, at every distance, offset and heading that
//! is possible; bracketing (paper 1, section VI; paper 2, section 7.2) tries poses about a prediction. Either way
//! P(F) is flat over the poses that keep the masks on the road, so the middle of the best ones is taken, not the
//! first. Of those that reach the threshold the ones whose arms stand out most from their verges are the best: a wide
//! street is road under any mask.
//! Candidates are laid in rows of pixels and scored a row at a time, each row against the best of those before it.

use std::ops::RangeInclusive;

use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Vector2};

use super::expectation::Expectation;
use super::reach::Reach;
use super::{PoseFilter, TrackConfig};
use crate::feature_masks::{MaskCache, node_pixel};
use crate::feature_model::FeatureModel;
use crate::matching::{LaidSurface, PoseRun};

/// The outcome of trying candidate poses.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tried {
    /// How many were tried.
    pub count: usize,
    /// Best pose and its P(F); none when no candidate reached the threshold.
    pub best: Option<(Isometry2<f64>, f64)>,
    /// The pose that came nearest to the threshold, whether it reached it or not.
    pub closest: Option<Isometry2<f64>>,
}

/// Candidates within this of the best are as good as it: the noise of the road surface.
const AS_GOOD: f64 = 0.03;
/// Candidates farther than this from the best one belong to another place that also matches, metres.
const SAME_PLACE_M: f64 = 1.5;

/// Least reach of the search across the road, metres: maps lie up to this far beside the road and make it too narrow.
pub(super) const MIN_LEFT_REACH_M: f64 = 2.0;
/// Weight of P(F) against the contrast with the verge in the ranking of candidates that reach the threshold: on real
/// streets P(F) falls with the distance by more than it differs between road and forecourt; the contrast does not.
const P_WEIGHT: f64 = 0.25;

/// The best of the candidates that were scored together.
#[derive(Debug, Clone, Copy)]
struct Ranked {
    pose: Isometry2<f64>,
    p: f64,
    /// Row of pixels of the feature's node.
    row: i32,
    /// How good it is; minus infinity where that was not looked at.
    rank: f64,
}

/// Tries candidate poses; its memory is reused from search to search.
#[derive(Debug, Default)]
pub struct CandidateSearch {
    run: PoseRun,
    /// The poses of the run.
    poses: Vec<Isometry2<f64>>,
    /// Best pose so far and its P(F).
    best: Option<(Isometry2<f64>, f64)>,
    /// Poses of the run that are as good as the best of them.
    as_good: Vec<(Isometry2<f64>, f64)>,
    /// The best of each run that reached the threshold.
    ranked: Vec<Ranked>,
}

/// Which candidates can be scored together: those with the same drawn masks and the same row of the node's pixel.
type RunKey = (i64, i32);

impl CandidateSearch {
    /// Tries poses along the approach: the node `before_m` ahead along it, the vehicle anywhere across the road. Of places
    /// that look alike the most expected one is the best.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub fn along_approach(
        &mut self,
        config: &TrackConfig,
        laid: &LaidSurface<'_>,
        feature: &FeatureModel,
        masks: &mut MaskCache,
        before_m: &RangeInclusive<f64>,
        expectation: Expectation<'_>,
    ) -> Result<Tried, SpanError> {
        self.best_of(
            (laid, expectation),
            masks,
            config.detect_threshold_at_verge,
            poses_along_approach(config, feature, before_m),
        )
    }

    /// Tries poses about a prediction; only those with P(F) from `threshold` on can be the best.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub fn about(
        &mut self,
        config: &TrackConfig,
        laid: &LaidSurface<'_>,
        masks: &mut MaskCache,
        threshold: f64,
        (predicted, reach): (&PoseFilter, Reach),
    ) -> Result<Tried, SpanError> {
        let expectation = Expectation::About(predicted);
        self.best_of((laid, expectation), masks, threshold, poses_about(config, predicted.pose(), reach))
    }

    fn best_of(
        &mut self,
        (laid, expectation): (&LaidSurface<'_>, Expectation<'_>),
        masks: &mut MaskCache,
        threshold: f64,
        poses: impl Iterator<Item = Isometry2<f64>>,
    ) -> Result<Tried, SpanError> {
        self.start_run();
        self.ranked.clear();
        self.best = None;
        let mut count = 0;
        let mut key: RunKey = (0, 0);
        for pose in poses {
            count += 1;
            let (column, row) = node_pixel(laid.grid(), &pose);
            let key_of_pose = (masks.key(pose.rotation.angle()), row);
            if key_of_pose != key {
                self.score_run(laid, masks, threshold, key.1)?;
                key = key_of_pose;
            }
            self.poses.push(pose);
            self.run.push(column);
        }
        self.score_run(laid, masks, threshold, key.1)?;
        let closest = self.best.map(|(pose, _)| pose);
        let Some(best) = rank_all((laid, expectation), masks, &mut self.ranked)? else {
            return Ok(Tried { count, best: None, closest });
        };
        let middle = middle_of(&self.ranked, &best);
        // The good poses may surround a hole; then the best itself stands.
        let best = match laid.score(masks, &middle, threshold)? {
            Some(p) if rank((laid, expectation), masks, &middle, p)? >= best.rank - 2.0 * AS_GOOD => {
                (middle, p)
            }
            _ => (best.pose, best.p),
        };
        Ok(Tried { count, best: Some(best), closest: Some(best.0) })
    }

    fn start_run(&mut self) {
        self.run.clear();
        self.poses.clear();
    }

    /// Scores the poses of the run, all of which lie in `row`, and starts the next.
    fn score_run(
        &mut self,
        laid: &LaidSurface<'_>,
        masks: &mut MaskCache,
        threshold: f64,
        row: i32,
    ) -> Result<(), SpanError> {
        let Some(first) = self.poses.first() else { return Ok(()) };
        let masks = masks.at(first.rotation.angle())?;
        let at_least = self.best.map_or(0.0, |(_, p)| (p - AS_GOOD).clamp(0.0, threshold));
        let scores = laid.score_run(masks, row, &mut self.run, at_least);
        for (&pose, score) in self.poses.iter().zip(scores) {
            let Some(p) = score else { continue };
            if p >= threshold {
                self.as_good.push((pose, p));
            }
            if self.best.is_none_or(|(_, best_p)| p > best_p) {
                self.best = Some((pose, p));
            }
        }
        self.keep_middle(row);
        self.start_run();
        Ok(())
    }

    /// Keeps the middle one of the poses of the run that are as good as its best.
    fn keep_middle(&mut self, row: i32) {
        let highest = self.as_good.iter().map(|(_, p)| *p).fold(0.0, f64::max);
        self.as_good.retain(|(_, p)| *p >= highest - AS_GOOD);
        let middle = self.as_good.get(self.as_good.len() / 2);
        self.ranked.extend(middle.map(|&(pose, p)| Ranked { pose, p, row, rank: f64::NEG_INFINITY }));
        self.as_good.clear();
    }
}

/// How good a candidate is that reaches the threshold.
fn rank(
    (laid, expectation): (&LaidSurface<'_>, Expectation<'_>),
    masks: &mut MaskCache,
    pose: &Isometry2<f64>,
    p: f64,
) -> Result<f64, SpanError> {
    let contrast = laid.contrast(masks, pose)?.unwrap_or(0.0).max(0.0);
    Ok(contrast + P_WEIGHT * p - expectation.penalty(pose))
}

/// Ranks the candidates that can be the best, which is returned: first the most probable one of each row of pixels, then
/// all about the best of those.
fn rank_all(
    seen: (&LaidSurface<'_>, Expectation<'_>),
    masks: &mut MaskCache,
    candidates: &mut [Ranked],
) -> Result<Option<Ranked>, SpanError> {
    for i in 0..candidates.len() {
        let Ranked { pose, p, row, .. } = candidates[i];
        let more_probable =
            |(j, other): (usize, &Ranked)| other.row == row && (other.p > p || j < i && other.p >= p);
        if !candidates.iter().enumerate().any(more_probable) {
            candidates[i].rank = rank(seen, masks, &pose, p)?;
        }
    }
    let Some(best) = highest(candidates) else { return Ok(None) };
    let near_px = SAME_PLACE_M / seen.0.grid().metres_per_pixel();
    for candidate in candidates.iter_mut() {
        if candidate.rank == f64::NEG_INFINITY && f64::from((candidate.row - best.row).abs()) < near_px {
            candidate.rank = rank(seen, masks, &candidate.pose, candidate.p)?;
        }
    }
    Ok(highest(candidates))
}

/// The first of the candidates with the highest rank.
fn highest(candidates: &[Ranked]) -> Option<Ranked> {
    candidates.iter().copied().reduce(|best, other| if other.rank > best.rank { other } else { best })
}

/// Poses along the approach, the farthest first.
fn poses_along_approach(
    config: &TrackConfig,
    feature: &FeatureModel,
    before_m: &RangeInclusive<f64>,
) -> impl Iterator<Item = Isometry2<f64>> {
    let half_width_m = feature.approach().map_or(0.0, |arm| 0.5 * arm.width_m).max(MIN_LEFT_REACH_M);
    let (step_m, left_step_m) = (config.search_forward_step_m, config.search_left_step_m);
    let (nearest_m, farthest_m) = (*before_m.start(), *before_m.end());
    let forward_steps = ((farthest_m - nearest_m) / step_m).floor().max(0.0) as usize;
    spread(config.search_heading_deg.to_radians(), config.search_heading_step_deg.to_radians()).flat_map(
        move |heading| {
            (0..=forward_steps).flat_map(move |i| {
                let before_m = farthest_m - step_m * i as f64;
                spread(half_width_m, left_step_m)
                    .map(move |left| feature.vehicle_from_feature(before_m, left, heading))
            })
        },
    )
}

/// Poses about a prediction.
fn poses_about(
    config: &TrackConfig,
    predicted: &Isometry2<f64>,
    reach: Reach,
) -> impl Iterator<Item = Isometry2<f64>> {
    let (reach_m, step_m) = (reach.forward_m, 0.5 * config.search_forward_step_m);
    let (left_reach_m, left_step_m) = (reach.left_m, 0.5 * config.search_left_step_m);
    let (predicted_place, predicted_heading) = (predicted.translation.vector, predicted.rotation.angle());
    spread(reach.heading_rad, config.search_heading_step_deg.to_radians()).flat_map(move |heading| {
        spread(reach_m, step_m).flat_map(move |forward| {
            spread(left_reach_m, left_step_m).map(move |left| {
                Isometry2::new(predicted_place + Vector2::new(forward, left), predicted_heading + heading)
            })
        })
    })
}

/// Values from `-reach` to `reach`, at most `step` apart, zero among them.
fn spread(reach: f64, step: f64) -> impl Iterator<Item = f64> {
    let steps = (reach / step.max(1e-3)).ceil() as i32;
    (-steps..=steps).map(move |k| if steps == 0 { 0.0 } else { reach * f64::from(k) / f64::from(steps) })
}

/// The middle of the candidates at the place of the best one that are as good as it.
fn middle_of(ranked: &[Ranked], best: &Ranked) -> Isometry2<f64> {
    let near = ranked.iter().filter(|other| {
        other.rank >= best.rank - AS_GOOD
            && (other.pose.translation.vector - best.pose.translation.vector).norm() < SAME_PLACE_M
    });
    let (mut count, mut place, mut turn) = (0.0, Vector2::zeros(), 0.0);
    for Ranked { pose, .. } in near {
        count += 1.0;
        place += pose.translation.vector;
        turn += best.pose.rotation.angle_to(&pose.rotation);
    }
    Isometry2::new(place / count, best.pose.rotation.angle() + turn / count)
}

#[cfg(test)]
mod tests;
