//! The named days on roads with marked lanes.

use super::{Conditions, LaneMarkings, LinePattern, LineStyle, Markings};

impl Conditions {
    /// A clear day on a road with a continuous line to either side of the lane.
    pub const LANE_CONTINUOUS: Self = Self {
        markings: Markings::Lanes,
        lanes: LaneMarkings { between: LineStyle::white(LinePattern::Continuous), ..LaneMarkings::WHITE },
        // What the driver does is in the plan.
        wander_m: 0.0,
        houses_per_100_m: 0.4,
        trees_per_100_m: 3.0,
        clearance_m: 4.0,
        ..Self::CLEAR
    };

    /// Broken lines to either side, with short dashes between the lanes and long ones along the edge.
    pub const LANE_BROKEN: Self = Self {
        lanes: LaneMarkings {
            between: LineStyle::white(LinePattern::Broken),
            edge: LineStyle::white(LinePattern::LongBroken),
            ..LaneMarkings::WHITE
        },
        ..Self::LANE_CONTINUOUS
    };

    /// A double line between the lanes, the nearer one with gaps.
    pub const LANE_DOUBLE: Self = Self {
        lanes: LaneMarkings {
            between: LineStyle::white(LinePattern::DoubleInnerBroken),
            line_width_m: 0.12,
            ..LaneMarkings::WHITE
        },
        ..Self::LANE_CONTINUOUS
    };

    /// Half of the paint gone.
    pub const LANE_WORN: Self = Self {
        lanes: LaneMarkings { worn: 0.5, ..LaneMarkings::WHITE },
        road_wear: 1.5,
        ..Self::LANE_CONTINUOUS
    };

    /// Two yellow lines between the lanes, white ones along the edges, as in North America.
    pub const LANE_YELLOW: Self = Self {
        lanes: LaneMarkings {
            between: LineStyle::yellow(LinePattern::Double),
            line_width_m: 0.10,
            lane_width_m: 3.6,
            ..LaneMarkings::WHITE
        },
        ..Self::LANE_CONTINUOUS
    };

    /// No lines.
    pub const LANE_NONE: Self = Self { markings: Markings::None, ..Self::LANE_CONTINUOUS };

    /// A broken line and other vehicles: ahead, in the next lane, oncoming, standing beside the road.
    pub const LANE_TRAFFIC: Self =
        Self { lanes: LaneMarkings::WHITE, traffic: 1.0, parked_per_100_m: 1.5, ..Self::LANE_CONTINUOUS };

    /// Night on an unlit road: the low beam, a noisy picture, the lamps of other vehicles.
    pub const LANE_NIGHT: Self = Self {
        lanes: LaneMarkings::WHITE,
        sky_light: 0.004,
        sun_light: 0.0,
        overcast: 0.9,
        headlights: 0.34,
        headlight_fading: 2,
        // Glass beads in the paint throw several times as much light back as a white wall.
        retroreflection: 5.0,
        noise_levels: 5.0,
        vignette: 0.30,
        traffic: 0.8,
        lamps: 1.0,
        ..Self::LANE_CONTINUOUS
    };

    /// A shower: wet road, drops on the windscreen, haze, lamps on.
    pub const LANE_RAIN: Self = Self {
        lanes: LaneMarkings::WHITE,
        wetness: 0.9,
        overcast: 1.0,
        sky_light: 1.3,
        sun_light: 0.0,
        haze_m: 110.0,
        rain: 1.0,
        traffic: 0.6,
        lamps: 0.5,
        noise_levels: 3.0,
        ..Self::LANE_CONTINUOUS
    };

    /// Low sun from the side: shadows of trees and posts across the road, of a guard rail along it.
    pub const LANE_SHADOWS: Self = Self {
        lanes: LaneMarkings::WHITE,
        shadow_strength: 1.0,
        shadow_detail: 1.0,
        sky_light: 0.5,
        sun_elevation_rad: 0.5,
        sun_azimuth_rad: -1.3,
        trees_per_100_m: 12.0,
        clearance_m: 2.0,
        posts_per_100_m: 3.0,
        guard_rails: 0.6,
        ..Self::LANE_CONTINUOUS
    };

    /// Strips of new asphalt, sealed cracks and seams along the lane.
    pub const LANE_PATCHES: Self =
        Self { lanes: LaneMarkings::WHITE, strips: 1.0, road_wear: 1.3, ..Self::LANE_CONTINUOUS };
}
