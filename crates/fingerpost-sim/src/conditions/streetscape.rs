//! What streets are made of and lined with where every one has its own.

use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::error::check_range;

/// How streets differ. All zero: roads are of asphalt or of what the map says, pavements of grey slabs, verges of grass and soil.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Streetscape {
    /// How far the tones of grounds reach from the usual ones, share: 1 for all that is found on streets. 0 for the usual ones alone.
    pub materials: f64,
    /// Share of the roads that are unmade: gravel, sand, clay, earth, two tracks in grass.
    pub unmade: f64,
    /// How far the edges of these wander to either side, metres.
    pub ragged_m: f64,
    /// Snow beside the road, share of the ground that it covers.
    pub snow: f64,
    /// Leaves on the ground, share of it where they gather.
    pub leaves: f64,
    /// Share of the roadsides with house fronts, walls, fences or hedges close to the road.
    pub frontage: f64,
    /// Trees for each 100 m of roadside whose crowns reach over the road.
    pub avenue_per_100_m: f64,
    /// Bins, bollards, signs and people for each 100 m of roadside.
    pub furniture_per_100_m: f64,
    /// Share of the stretches of road with manholes, crossings and arrows.
    pub fixtures: f64,
    /// Share of the route's sides along which vehicles stand in a row.
    pub parked_rows: f64,
    /// Share of the streets whose edges are marked as anywhere in the world: double and yellow lines, up to 0.9 m from the edge. 0 for
    /// single white ones close to it.
    pub edge_paint: f64,
}

impl Streetscape {
    /// None of it.
    pub const USUAL: Self = Self {
        materials: 0.0,
        unmade: 0.0,
        ragged_m: 0.0,
        snow: 0.0,
        leaves: 0.0,
        frontage: 0.0,
        avenue_per_100_m: 0.0,
        furniture_per_100_m: 0.0,
        fixtures: 0.0,
        parked_rows: 0.0,
        edge_paint: 0.0,
    };

    /// Checks every number.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let share = "a share between 0 and 1";
        check_range("streetscape.materials", self.materials, 0.0, 1.0, share)?;
        check_range("streetscape.unmade", self.unmade, 0.0, 1.0, share)?;
        check_range("streetscape.ragged_m", self.ragged_m, 0.0, 1.5, "0 to 1.5 metres")?;
        check_range("streetscape.snow", self.snow, 0.0, 1.0, share)?;
        check_range("streetscape.leaves", self.leaves, 0.0, 1.0, share)?;
        check_range("streetscape.frontage", self.frontage, 0.0, 1.0, share)?;
        check_range("streetscape.avenue_per_100_m", self.avenue_per_100_m, 0.0, 20.0, "0 to 20")?;
        check_range("streetscape.furniture_per_100_m", self.furniture_per_100_m, 0.0, 50.0, "0 to 50")?;
        check_range("streetscape.fixtures", self.fixtures, 0.0, 1.0, share)?;
        check_range("streetscape.parked_rows", self.parked_rows, 0.0, 1.0, share)?;
        check_range("streetscape.edge_paint", self.edge_paint, 0.0, 1.0, share)
    }
}
