//! What a feature says of where along the route the vehicle is: the places it may have, where it was looked for and not seen, and how sure
//! it stays once its curve has begun.

use super::{FeatureBelief, MAP_WRONG, Seen};
use crate::progress::{FeatureOutcome, FeaturePlace};
use crate::track::belief::along_route::SeenAlong;
use crate::track::belief::likelihood::log_sum;

/// Most places that are given to the progress, those that lie behind among them.
const MOST_ON_ROUTE: usize = 8;
/// How often a feature does not show though it is there, in shade or in poor light: one in seven on drawn worlds.
const UNSEEN: f64 = 0.15;
/// Where the ground says so much less of the feature than of a plain road it would have been seen, logarithm; and a place that is
/// weighed speaks for so many metres about it.
const UNSEEN_LOG_RATIO: f64 = -2.0;
const SEEN_ABOUT_M: f64 = 1.5;

impl FeatureBelief {
    /// Says of the places, and of the ground where there is none, what the progress is to know.
    pub(super) fn place_on_route(&mut self, seen: Seen<'_>, plain_log_evidence: f64) {
        if self.carried.is_some() {
            self.place_on_way_through(seen, plain_log_evidence);
        } else {
            self.place_ahead(seen, plain_log_evidence);
        }
    }

    /// The same once the curve has begun. What looked like the feature then is as likely another thing as it was, until the ground says
    /// more; that it leaves the view says nothing.
    fn place_on_way_through(&mut self, Seen { stop, .. }: Seen<'_>, plain_log_evidence: f64) {
        let (Some(carried), Some(best)) = (&mut self.carried, self.places.first()) else { return };
        self.on_route.clear();
        self.looked_for = None;
        let log_ratio = best.fit.log_evidence - plain_log_evidence;
        let log_ratio_then = *carried.log_ratio.get_or_insert(log_ratio);
        self.log_said_after = self.log_said_after.max(log_ratio - log_ratio_then);
        let of_places = self.places.iter().map(|place| place.fit.log_evidence);
        let log_all = of_places.fold(f64::NEG_INFINITY, log_sum);
        for place in &mut self.places {
            let log_said = self.log_said_after + place.fit.log_evidence - log_all;
            place.log_share = carried.log_share + log_said;
            place.by_ground = 1.0;
            let log_likelihood = self.log_likelihood + log_said;
            self.on_route.push(SeenAlong::unexpected(&stop.model, &place.fit, log_likelihood).on_map(0.0));
        }
    }

    /// The same before it.
    fn place_ahead(&mut self, Seen { stop, .. }: Seen<'_>, plain_log_evidence: f64) {
        // What lies behind is seen no better than it was, and says on what it said.
        self.on_route.retain(|place| place.ahead_m < 0.0);
        let behind = self.on_route.len();
        for (i, place) in self.places.iter_mut().enumerate() {
            let log_ratio = place.fit.log_evidence - plain_log_evidence;
            let along = SeenAlong::of(&stop.model, &place.fit, &place.expected, log_ratio);
            let log_clutter = along.log_clutter();
            if i == 0 {
                self.log_likelihood = along.log_likelihood(log_clutter);
            }
            place.log_share = place.expected.log_weight + log_ratio - log_clutter;
            place.by_ground = along.probability();
            let on_map = along.on_map(log_clutter);
            if on_map.ahead_m >= 0.0 {
                self.on_route.push(on_map);
            }
        }
        self.look_for();
        for place in self.on_route.iter_mut().skip(behind) {
            let is_looked_for =
                |[nearest_m, farthest_m]: [f64; 2]| place.ahead_m >= nearest_m && place.ahead_m <= farthest_m;
            if !self.looked_for.is_some_and(|(looked_for_m, _)| is_looked_for(looked_for_m)) {
                // There the ground is as it is without the feature, which counts as 1 already.
                place.likelihood = (place.likelihood - 1.0).max(0.0);
            }
        }
        while self.on_route.len() > MOST_ON_ROUTE {
            let least = (0..self.on_route.len())
                .min_by(|&a, &b| self.on_route[a].likelihood.total_cmp(&self.on_route[b].likelihood));
            if let Some(least) = least {
                self.on_route.remove(least);
            }
        }
    }

    /// Says where the feature would have been seen: where the last scan found nothing like it, and behind as far as it was so before.
    fn look_for(&mut self) {
        let mut ahead: Option<([f64; 2], f64)> = None;
        let mut unlikely = f64::NEG_INFINITY;
        for &(ahead_m, log_ratio) in &self.scanned {
            let is_place = |place: &FeaturePlace| (place.ahead_m - ahead_m).abs() < SEEN_ABOUT_M;
            if !self.on_route.iter().any(is_place) {
                if log_ratio > UNSEEN_LOG_RATIO {
                    break;
                }
                unlikely = unlikely.max(log_ratio);
            }
            let nearest_m = ahead.map_or(ahead_m, |([nearest_m, _], _)| nearest_m);
            let missed = MAP_WRONG + (1.0 - MAP_WRONG) * libm::exp(unlikely).max(UNSEEN);
            ahead = Some(([nearest_m, ahead_m], missed));
        }
        let Some(&(first_m, _)) = self.scanned.first() else { return };
        let before = self
            .looked_for
            .map(|([nearest_m, farthest_m], missed)| ([nearest_m, farthest_m.min(first_m)], missed));
        self.looked_for = match (before.filter(|([nearest_m, farthest_m], _)| nearest_m < farthest_m), ahead)
        {
            (Some(([nearest_m, before_m], missed)), Some(([from_m, farthest_m], now_missed)))
                if before_m >= from_m =>
            {
                Some(([nearest_m, farthest_m], missed.max(now_missed)))
            }
            (before, None) => before,
            (_, ahead) => ahead,
        };
    }

    /// What this feature says of the progress.
    pub(in crate::track::belief) fn outcome(&self) -> FeatureOutcome<'_> {
        let (looked_for_m, map_wrong_share) = self.looked_for.unzip();
        let map_wrong_share = map_wrong_share.unwrap_or(MAP_WRONG);
        let log_excess = if self.carried.is_some() { self.log_said_after } else { 0.0 };
        FeatureOutcome { places: &self.on_route, looked_for_m, map_wrong_share, log_excess }
    }

    /// Probability of the feature by what was seen of it alone, for which it was as likely as none.
    pub(in crate::track::belief) fn present_by_sight(&self) -> f64 {
        1.0 / (1.0 + libm::exp(-self.log_likelihood - self.log_said_after))
    }
}
