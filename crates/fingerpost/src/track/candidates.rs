//! Candidate poses of a feature, and the best of them.
//!
//! The search for a new feature puts the vehicle on the feature's approach, at every distance, offset and heading that
//! is possible; bracketing (paper 1, section VI; paper 2, section 7.2) tries poses about a prediction. Either way
//! P(F) is flat over the poses that keep the masks on the road, so the middle of the best ones is taken, not the
//! first.

use std::ops::RangeInclusive;

use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Vector2};

use super::TrackConfig;
use crate::feature_masks::MaskCache;
use crate::feature_model::FeatureModel;
use crate::matching::LaidSurface;

/// The outcome of trying candidate poses.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tried {
    /// How many were tried.
    pub(super) count: usize,
    /// Best pose and its P(F); none when no candidate reached the threshold.
    pub(super) best: Option<(Isometry2<f64>, f64)>,
    /// The pose that came nearest to the threshold, whether it reached it or not.
    pub(super) closest: Option<Isometry2<f64>>,
}

/// Candidates within this of the best P(F) are as good as it: the noise of the road surface.
const AS_GOOD: f64 = 0.03;
/// Candidates farther than this from the best one belong to another place that also matches, metres.
const SAME_PLACE_M: f64 = 2.5;

/// Tries candidate poses; its memory is reused from search to search.
#[derive(Debug, Default)]
pub(super) struct CandidateSearch {
    /// The candidates that reached the threshold, with their P(F).
    good: Vec<(Isometry2<f64>, f64)>,
}

impl CandidateSearch {
    /// Tries poses along the approach: the node `before_m` ahead along it, the vehicle anywhere across the road.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub(super) fn along_approach(
        &mut self,
        config: &TrackConfig,
        laid: &LaidSurface<'_>,
        feature: &FeatureModel,
        masks: &mut MaskCache,
        before_m: &RangeInclusive<f64>,
    ) -> Result<Tried, SpanError> {
        let half_width = feature.approach().map_or(2.5, |arm| 0.5 * arm.width_m);
        let headings =
            spread(config.search_heading_deg.to_radians(), config.search_heading_step_deg.to_radians());
        let forward_steps =
            ((before_m.end() - before_m.start()) / config.search_forward_step_m).floor().max(0.0) as usize;
        let poses = headings.flat_map(|heading| {
            (0..=forward_steps).flat_map(move |i| {
                let before = before_m.end() - config.search_forward_step_m * i as f64;
                spread(half_width, config.search_left_step_m)
                    .map(move |left| feature.vehicle_from_feature(before, left, heading))
            })
        });
        self.best_of(laid, masks, config.detect_threshold, poses)
    }

    /// Tries poses about a prediction.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub(super) fn about(
        &mut self,
        config: &TrackConfig,
        laid: &LaidSurface<'_>,
        masks: &mut MaskCache,
        threshold: f64,
        predicted: &Isometry2<f64>,
    ) -> Result<Tried, SpanError> {
        let headings =
            spread(config.bracket_heading_deg.to_radians(), config.search_heading_step_deg.to_radians());
        let poses = headings.flat_map(|heading| {
            spread(config.bracket_forward_m, 0.5 * config.search_forward_step_m).flat_map(move |forward| {
                spread(config.bracket_left_m, 0.5 * config.search_left_step_m).map(move |left| {
                    let p = predicted.translation.vector + Vector2::new(forward, left);
                    Isometry2::new(p, predicted.rotation.angle() + heading)
                })
            })
        });
        self.best_of(laid, masks, threshold, poses)
    }

    fn best_of(
        &mut self,
        laid: &LaidSurface<'_>,
        masks: &mut MaskCache,
        threshold: f64,
        poses: impl Iterator<Item = Isometry2<f64>>,
    ) -> Result<Tried, SpanError> {
        let mut tried = Tried::default();
        self.good.clear();
        let mut best: Option<(Isometry2<f64>, f64)> = None;
        for pose in poses {
            tried.count += 1;
            let at_least = best.map_or(0.0, |(_, p)| (p - AS_GOOD).max(0.0));
            let Some(p) = laid.score(masks, &pose, at_least)? else { continue };
            if p >= threshold {
                self.good.push((pose, p));
            }
            if best.is_none_or(|(_, best_p)| p > best_p) {
                best = Some((pose, p));
            }
        }
        tried.closest = best.map(|(pose, _)| pose);
        let Some((best_pose, best_p)) = best.filter(|&(_, p)| p >= threshold) else { return Ok(tried) };
        let near = self.good.iter().filter(|(pose, p)| {
            *p >= best_p - AS_GOOD
                && (pose.translation.vector - best_pose.translation.vector).norm() < SAME_PLACE_M
        });
        let (mut count, mut place, mut turn) = (0.0, Vector2::zeros(), 0.0);
        for (pose, _) in near {
            count += 1.0;
            place += pose.translation.vector;
            turn += best_pose.rotation.angle_to(&pose.rotation);
        }
        let middle = Isometry2::new(place / count, best_pose.rotation.angle() + turn / count);
        // The good poses may surround a hole; then the best itself stands.
        tried.best = Some(match laid.score(masks, &middle, threshold)? {
            Some(p) if p >= best_p - 2.0 * AS_GOOD => (middle, p),
            _ => (best_pose, best_p),
        });
        Ok(tried)
    }
}

/// Values from `-reach` to `reach`, at most `step` apart, zero among them.
fn spread(reach: f64, step: f64) -> impl Iterator<Item = f64> {
    let steps = (reach / step.max(1e-3)).ceil() as i32;
    (-steps..=steps).map(move |k| if steps == 0 { 0.0 } else { reach * f64::from(k) / f64::from(steps) })
}
