//! Route features: the places of a route that can be told in a picture, with the course of every road that meets there.

use serde::{Deserialize, Serialize};

use crate::{LatLon, RoadClass, Roadside};

/// Roads at a node, and arms of a feature: no junction has more.
pub(crate) const MOST_ARMS: usize = 16;

/// A junction, side road or bend of a route.
#[derive(Debug, Clone, PartialEq)]
pub struct RouteFeature {
    /// OSM's number of the node.
    pub id: i64,
    /// Where the node is.
    pub at: LatLon,
    /// Names of the roads that meet ("Neckarstrasse x Kniebisstrasse"), the route's first.
    pub name: String,
    /// What it is.
    pub kind: FeatureKind,
    /// Turn of the route at the node, radians, positive left: from the approach arm's direction to the exit arm's.
    pub turn_rad: f64,
    /// The roads that leave the node: the approach, the exit, then the others anticlockwise from the exit.
    pub arms: Vec<Arm>,
    /// Distance along the route, metres.
    pub route_m: f64,
}

/// What a route feature is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FeatureKind {
    /// The route turns, or four and more roads meet.
    Junction,
    /// The route goes about straight past one other road.
    SideRoad,
    /// The road itself turns sharply.
    Bend,
}

/// One road that leaves the node of a feature.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    /// Its part in the route.
    pub role: ArmRole,
    /// Heading of leaving the node along the arm, map frame, radians anticlockwise from east.
    pub bearing_rad: f64,
    /// Course from the node (first point) outwards along the map's own nodes.
    pub points: Vec<LatLon>,
    /// Width of the road, metres.
    pub width_m: f64,
    /// Surface as tagged.
    pub surface: Option<String>,
    /// What lies on its left and right when one looks outwards from the node.
    pub beside: [Roadside; 2],
}

/// Part of an arm in the route.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ArmRole {
    /// The route comes along it.
    Approach,
    /// The route leaves along it.
    Exit,
    /// The route passes it by.
    Side,
}

/// How a route is cut into features.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureOptions {
    /// Turn from which three roads are a junction and not a side road, radians (default 30 degrees: less is no more
    /// than what a road does by itself when another one meets it).
    pub junction_turn_rad: f64,
    /// Turn within [`Self::bend_reach_m`] of a node from which a road's bend is a feature, radians (default 35 degrees).
    pub bend_turn_rad: f64,
    /// How far before and behind a node a bend's turn is counted, metres (default 6, a bend of about 20 m radius at
    /// the default turn).
    pub bend_reach_m: f64,
    /// A bend nearer than this to another feature along the route is left out, metres (default 12): the course of that
    /// feature's arm holds it.
    pub bend_clearance_m: f64,
    /// Length of an arm that its direction is measured over, metres (default 8: mappers round corners off within it).
    pub direction_m: f64,
    /// Course of an arm that is followed where the road is that long, metres (default 45: the farthest corner of any
    /// usual ground view).
    pub course_m: f64,
    /// Roads of these classes are no arms unless the route follows them (default none).
    pub excluded: Vec<RoadClass>,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self {
            junction_turn_rad: 30_f64.to_radians(),
            bend_turn_rad: 35_f64.to_radians(),
            bend_reach_m: 6.0,
            bend_clearance_m: 12.0,
            direction_m: 8.0,
            course_m: 45.0,
            excluded: Vec::new(),
        }
    }
}
