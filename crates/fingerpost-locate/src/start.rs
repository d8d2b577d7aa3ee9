//! What is known of the vehicle's place before it has moved.

use std::f64::consts::TAU;

use fingerpost_geometry::wrap_angle;
use fingerpost_map::RoadGraph;
use nalgebra::{Matrix2, Point2};

use crate::belief::{Belief, OFF_MAP_AT_START, OFFSET_MODEL};
use crate::hypothesis::Hypothesis;
use crate::path::ROUNDING_M;
use crate::roads::{Edge, Traffic};
use crate::seeding::{EdgeSeeds, HEADING_SIGMA, Seeding};
use crate::state::HEADING;

/// A place that the vehicle starts near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// The place, metres in the plane of the map's graph.
    pub place_m: Point2<f64>,
    /// Its standard deviation east and north, metres.
    pub sigma_m: f64,
    /// Heading, radians anticlockwise from east, and its standard deviation; none where it is not known.
    pub heading_rad: Option<[f64; 2]>,
}

impl Start {
    /// Weighs a hypothesis by the start and moves it towards it.
    fn weigh(&self, hypothesis: &mut Hypothesis) {
        let variance_m2 = self.sigma_m * self.sigma_m;
        let innovation = self.place_m - hypothesis.state.place();
        let expected = hypothesis.state.place_covariance() + Matrix2::identity() * variance_m2;
        let squared = expected
            .try_inverse()
            .map_or(f64::INFINITY, |precision| innovation.dot(&(precision * innovation)));
        hypothesis.log_weight -= 0.5 * (squared + libm::log(expected.determinant().max(f64::MIN_POSITIVE)));
        if let Some([heading_rad, sigma_rad]) = self.heading_rad {
            let off_rad = wrap_angle(heading_rad - hypothesis.state.mean[HEADING]);
            let variance = hypothesis.state.covariance[(HEADING, HEADING)] + sigma_rad * sigma_rad;
            hypothesis.log_weight -= 0.5 * (off_rad * off_rad / variance + libm::log(TAU * variance));
        }
        hypothesis.state.take_place(innovation, variance_m2);
    }

    /// The largest logarithm of a weight that a hypothesis of an edge can have once it is weighed.
    fn most_log_weight(&self, edge: &Edge, seeds: &EdgeSeeds) -> f64 {
        // Rounding its corners moves a course off its line by no more than it averages over.
        let distance_m = (edge.line.nearest(self.place_m).left_m.abs() - ROUNDING_M).max(0.0);
        let [along_m2, beside_m2] = [seeds.sigma_m, OFFSET_MODEL.sigma_m]
            .map(|sigma_m| sigma_m * sigma_m + self.sigma_m * self.sigma_m);
        let of_place = distance_m * distance_m / along_m2.max(beside_m2) + libm::log(along_m2 * beside_m2);
        let of_heading = self.heading_rad.map_or(0.0, |[_, sigma_rad]| {
            libm::log(TAU * (HEADING_SIGMA * HEADING_SIGMA + sigma_rad * sigma_rad))
        });
        seeds.log_weight - 0.5 * (of_place + of_heading)
    }
}

impl Belief {
    /// The vehicle may be on any road near a place, either way: what [`Belief::anywhere`] comes to where it is weighed by the
    /// start, without hypotheses on roads that are too far away to matter.
    pub(crate) fn near(graph: &RoadGraph, traffic: Traffic, seed: u64, start: &Start) -> Self {
        let mut belief = Self::off_map_alone(graph, traffic, seed);
        let mass = 1.0 - OFF_MAP_AT_START;
        let seeding = Seeding::draw(&mut belief, mass);
        let mut edges: Vec<(f64, u32, EdgeSeeds)> = (0..belief.roads.edges().len() as u32)
            .filter_map(|index| {
                let seeds = seeding.of_edge(&belief, index)?;
                Some((start.most_log_weight(belief.roads.edge(index), &seeds), index, seeds))
            })
            .collect();
        edges.sort_by(|a, b| b.0.total_cmp(&a.0));
        // What is less than this part of the largest changes no sum, of weights or of anything that they weigh.
        let matters = libm::log(f64::EPSILON);
        let mut largest = f64::NEG_INFINITY;
        let mut near = Vec::new();
        for (most, index, seeds) in edges {
            if most < largest + matters {
                break;
            }
            belief.seed_edge(index, &seeds);
            for mut hypothesis in belief.hypotheses.drain(..) {
                start.weigh(&mut hypothesis);
                largest = largest.max(hypothesis.log_weight);
                near.push((index, hypothesis));
            }
        }
        near.sort_by_key(|(index, _)| *index);
        belief.hypotheses.extend(near.into_iter().map(|(_, hypothesis)| hypothesis));
        let weights = belief.hypotheses.iter().map(|hypothesis| libm::exp(hypothesis.log_weight));
        belief.log_off_map += libm::log(weights.sum::<f64>().max(f64::MIN_POSITIVE) / mass);
        belief.normalise();
        belief
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_map::{LatLon, OsmData, TangentPlane};

    use super::*;

    /// Streets 150 m apart, 6 km of them in either direction, each with a node at every crossing.
    fn grid() -> RoadGraph {
        let plane = TangentPlane::new(LatLon { lat_deg: 47.0, lon_deg: 9.0 });
        let (streets, apart_m) = (40, 150.0);
        let mut text = String::from("<osm version=\"0.6\">");
        for node in 0..streets * streets {
            let place = Point2::new((node % streets) as f64, (node / streets) as f64) * apart_m;
            let at = plane.wgs84_from_map(place);
            text += &format!("<node id=\"{}\" lat=\"{}\" lon=\"{}\"/>", node + 1, at.lat_deg, at.lon_deg);
        }
        let mut street = |number: usize, nodes: &mut dyn Iterator<Item = usize>| {
            let nodes: String = nodes.map(|node| format!("<nd ref=\"{}\"/>", node + 1)).collect();
            text += &format!("<way id=\"{number}\">{nodes}<tag k=\"highway\" v=\"residential\"/></way>");
        };
        for along in 0..streets {
            street(2 * along + 1, &mut (0..streets).map(|across| across + along * streets));
            street(2 * along + 2, &mut (0..streets).map(|across| across * streets + along));
        }
        text += "</osm>";
        RoadGraph::from_osm(&OsmData::from_bytes(text.as_bytes()).unwrap()).unwrap()
    }

    #[test]
    fn what_is_left_out_near_a_place_is_what_would_not_matter() {
        let graph = grid();
        let middle = graph.nodes()[graph.nodes().len() / 2].p_in_map;
        for (off_m, sigma_m) in
            [([0.0, 0.0], 15.0), ([60.0, 70.0], 3.0), ([400.0, -7.0], 150.0), ([9e4, 0.0], 20.0)]
        {
            for heading_rad in [None, Some([0.3, 0.2])] {
                let place_m = Point2::new(middle.x + off_m[0], middle.y + off_m[1]);
                let start = Start { place_m, sigma_m, heading_rad };
                let mut all = Belief::anywhere(&graph, Traffic::Right, 7);
                let roads = all.hypotheses.len();
                all.weigh(|hypothesis| start.weigh(hypothesis));
                let near = Belief::near(&graph, Traffic::Right, 7, &start);
                assert!(near.hypotheses.len() < roads / 4);
                assert_eq!(near.hypotheses.is_empty(), off_m[0] > 1e4, "{start:?}");
                assert_eq!(near.hypotheses.len(), all.hypotheses.len(), "{start:?}");
                assert!((near.log_off_map - all.log_off_map).abs() < 1e-9, "{start:?}");
                for (one, other) in near.hypotheses.iter().zip(&all.hypotheses) {
                    assert_eq!((&one.course.edges, one.along_m), (&other.course.edges, other.along_m));
                    assert!((one.log_weight - other.log_weight).abs() < 1e-9, "{start:?}");
                }
            }
        }
    }
}
