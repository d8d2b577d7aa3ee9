//! Colours of the ground, linear light.

mod fixtures;
mod kerbed;
mod lane;
mod litter;
mod materials;
mod pattern;
mod standing;
mod strips;
mod varied;

use self::fixtures::Fixtures;
use self::lane::Lane;
pub(crate) use self::lane::LocalPlace;
use self::materials::{Materials, PavementGround};
use self::strips::Strips;
use self::varied::{Covering, KERB_M, Varied, covered};
use crate::TrafficSide;
use crate::conditions::{Conditions, Markings};
use crate::ground::GroundPoint;
use crate::light::mixed;
use crate::mouth_lines::MouthLine;
use crate::roads::{RoadNetwork, Surface};
use crate::roadside::{BesideRoad, Roadside};
use crate::shown::PixelClass;
use crate::street::Street;
use crate::texture::{Grain, Texture};

/// Linear red, green, blue.
pub(crate) type Colour = [f32; 3];

/// How much ground a pixel covers and in which direction it is drawn out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footprint {
    /// Across the line of sight, metres.
    pub(crate) across_m: f32,
    /// Along the line of sight, metres.
    pub(crate) along_m: f32,
    /// Unit vector of the line of sight on the ground.
    pub(crate) sight: [f32; 2],
}

impl Footprint {
    /// Side of a square as large, metres.
    #[inline]
    pub(crate) fn fineness_m(&self) -> f32 {
        (self.across_m * self.along_m).sqrt()
    }

    /// Extent in the direction of a (unit) vector, metres.
    #[inline]
    fn extent_m(&self, [x, y]: [f32; 2]) -> f32 {
        let along = (x * self.sight[0] + y * self.sight[1]) * self.along_m;
        let across = (x * self.sight[1] - y * self.sight[0]) * self.across_m;
        (along * along + across * across).sqrt().max(1e-4)
    }
}

/// The ground in a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Painted {
    /// Share of the pixel that is road.
    pub(crate) road: f32,
    /// Its colour in full light.
    pub(crate) colour: Colour,
    /// Share of the road that lines cover.
    pub(crate) paint: f32,
    /// What the rest of the pixel is.
    pub(crate) beside: PixelClass,
}

/// What takes the verge's place beside a road.
#[derive(Debug, Clone, Copy)]
struct MadeGround {
    colour: Colour,
    /// Share of the pixel that it takes.
    share: f32,
    class: PixelClass,
}

/// Textures and numbers of everything that is painted.
#[derive(Debug, Clone)]
pub(crate) struct Painter {
    asphalt: Texture,
    grass: Texture,
    soil: Texture,
    lanes: Vec<Lane>,
    bare_verge: f32,
    wear: f32,
    varied: Option<Varied>,
    strips: Option<Strips>,
    street: Option<Street>,
    materials: Option<Materials>,
    fixtures: Option<Fixtures>,
    dust: f32,
    worn: f32,
}

/// How far leaves move a shadow's rim, share of its depth.
const FLECKS: f32 = 0.36;
/// How suddenly paint ends at a fleck, and how much of the colour of the paint that is left goes with all of it worn.
const FLECK_STEEPNESS: f32 = 3.5;
const FADES: f32 = 0.5;
/// Colour of dust that lies on the ground.
const DUST: Colour = [0.42, 0.345, 0.25];

impl Painter {
    /// Paint for these roads.
    pub(crate) fn new(seed: u64, conditions: &Conditions, roads: &RoadNetwork, traffic: TrafficSide) -> Self {
        let lanes = roads.strokes().iter().map(|stroke| Lane::new(stroke, conditions, traffic));
        let mut lanes: Vec<Lane> = lanes.collect();
        let materials = Materials::new(seed, &conditions.streetscape);
        if let Some(materials) = &materials {
            for lane in &mut lanes {
                lane.ground = materials.road(lane.chain);
            }
        }
        if conditions.markings == Markings::Streets {
            for (stroke, line) in MouthLine::drawn(seed, roads, traffic) {
                lanes[stroke].add_mouth(line);
            }
        }
        Self {
            asphalt: Texture::new(seed, Grain::Asphalt),
            grass: Texture::new(seed, Grain::Grass),
            soil: Texture::new(seed, Grain::Soil),
            lanes,
            bare_verge: conditions.bare_verge as f32,
            wear: conditions.road_wear as f32,
            varied: Varied::new(seed, conditions.stretch_m as f32, conditions.pavements as f32),
            strips: Strips::new(seed, conditions.strips as f32),
            street: Street::new(seed, conditions),
            materials,
            fixtures: Fixtures::new(seed, conditions.streetscape.fixtures as f32),
            dust: conditions.dust as f32,
            worn: conditions.lanes.worn as f32,
        }
    }

    /// The ground in a pixel.
    #[inline]
    pub(crate) fn ground(&self, x: f32, y: f32, point: &GroundPoint, footprint: &Footprint) -> Painted {
        let road = if point.edge_m.abs() > footprint.along_m {
            // The edge is farther away than the pixel reaches in any direction.
            if point.edge_m < 0.0 { 1.0 } else { 0.0 }
        } else {
            (0.5 - point.edge_m / footprint.extent_m(point.edge_slope)).clamp(0.0, 1.0)
        };
        let fineness = footprint.fineness_m();
        let (mut colour, mut paint, mut beside) = ([0.0; 3], 0.0, PixelClass::Verge);
        if road > 0.0 {
            (colour, paint) = self.road(x, y, point, footprint, fineness);
        }
        if road < 1.0 {
            let mut verge = self.verge(x, y, point, fineness);
            let made = [
                self.roadside(x, y, point, footprint, fineness),
                self.kerbed(x, y, point, footprint, fineness),
            ];
            for made in made.into_iter().flatten() {
                verge = mixed(verge, made.colour, made.share);
                beside = if made.share >= 0.5 { made.class } else { beside };
            }
            for i in 0..3 {
                colour[i] = verge[i] + (colour[i] - verge[i]) * road;
            }
        }
        if self.materials.is_some() {
            colour = self.littered(colour, [x, y], point, footprint);
        }
        if self.dust > 0.0 {
            colour = self.dusted(colour, x, y, point, fineness);
        }
        Painted { road, colour, paint: paint * road, beside }
    }

    #[inline]
    fn road(
        &self,
        x: f32,
        y: f32,
        point: &GroundPoint,
        footprint: &Footprint,
        fineness: f32,
    ) -> (Colour, f32) {
        let lane = point.stroke.map(|index| &self.lanes[index as usize]);
        let covering = self.covering(lane, x, y);
        let ground = lane.and_then(|lane| lane.ground);
        let look = ground.map(|ground| ground.look).or(covering.look());
        let as_mapped = lane.is_some_and(|lane| lane.surface == Surface::Loose);
        let loose = look.map_or(as_mapped, |look| look.loose);
        let texture = if loose { &self.soil } else { &self.asphalt };
        let grain = texture.sample(x, y, fineness);
        // The same tile turned and enlarged by irrational numbers: together they do not repeat within sight.
        let other = texture.sample(0.49 * x - 0.33 * y + 3.1, 0.33 * x + 0.49 * y + 7.7, 0.6 * fineness);
        let wear = look.map_or(self.wear, |look| self.wear * look.wear);
        let bright = 1.0 + wear * (0.40 * grain[0] + 0.30 * other[0] + 0.55 * point.tone);
        let warm = 0.5 * point.hue + 0.35 * grain[1] + 0.25 * other[1];
        let mapped = if loose { [0.36, 0.30, 0.225] } else { [0.200, 0.208, 0.222] };
        let base = look.map_or(mapped, |look| look.base);
        let bright = bright.max(0.15);
        let mut colour = [
            base[0] * bright * (1.0 + 0.10 * warm),
            base[1] * bright,
            base[2] * bright * (1.0 - 0.12 * warm),
        ];
        if let (Some(materials), Some(lane), Some(ground)) = (&self.materials, lane, ground) {
            let place = lane.place(x, y);
            colour = materials.laid(colour, ground.pattern, &place, footprint);
            let grass = ground.pattern.grass(place.left_m + 0.3 * grain[0], place.extents_m(footprint)[1]);
            if grass > 0.0 {
                let open = GroundPoint { edge_m: 1.0, ..*point };
                colour = mixed(colour, self.verge(x, y, &open, fineness), grass);
            }
            if let Some((width_m, shade)) = ground.gutter {
                let inside = (point.edge_m + width_m) / footprint.extent_m(point.edge_slope) + 0.5;
                colour = mixed(colour, colour.map(|c| c * shade), inside.clamp(0.0, 1.0));
            }
        }
        let mut painted = 0.0;
        if let Some(lane) = lane.filter(|_| !loose) {
            if let Some(varied) = &self.varied {
                colour = varied.repair(colour, covering, &lane.place(x, y), footprint, grain[0]);
            }
            if let Some(strips) = &self.strips {
                colour = strips.laid(colour, &lane.place(x, y), footprint, grain[0]);
            }
            let (share, paint) = lane.paint(x, y, point, footprint);
            let share = share * (0.92 + 0.5 * grain[0].min(0.0));
            let share =
                if self.worn > 0.0 { share * self.left_of_paint(x, y, point, fineness) } else { share };
            painted = share.clamp(0.0, 1.0);
            colour = mixed(colour, paint, painted);
            // Near another road its own coordinates say where things are.
            if let Some(fixtures) = self.fixtures.filter(|_| point.other_m > 0.0) {
                let (laid, share) = fixtures.laid(colour, &lane.place(x, y), footprint);
                colour = laid;
                painted = painted.max(share);
            }
        }
        (colour, painted)
    }

    #[inline]
    fn verge(&self, x: f32, y: f32, point: &GroundPoint, fineness: f32) -> Colour {
        let grass = self.grass.sample(x, y, fineness);
        let tufts = self.grass.sample(0.31 * x + 0.22 * y, 0.31 * y - 0.22 * x, 0.4 * fineness);
        // Soil in a ragged strip along the road and in patches beyond.
        let strip = (1.0 - point.edge_m * (1.0 / 0.9)).clamp(0.0, 1.0);
        let patches = point.hue * 0.9 + 0.8 * tufts[1] + 0.4 * grass[1];
        let bare = ((self.bare_verge - 0.5) * 2.0 + patches + 1.1 * strip).clamp(0.0, 1.0);
        let bright = (1.0 + 0.45 * grass[0] + 0.30 * tufts[0] + 0.4 * point.tone).max(0.2);
        let (green, brown) = match &self.materials {
            None => ([0.135 + 0.05 * point.tone, 0.195, 0.062], [0.275, 0.205, 0.130]),
            Some(materials) => {
                let [one, other] = materials.vegetation;
                (mixed(one, other, (0.5 + 1.2 * point.hue).clamp(0.0, 1.0)), materials.soil)
            }
        };
        let grass_colour = green.map(|c| c * bright);
        if bare <= 0.0 {
            return grass_colour;
        }
        let stones = self.soil.sample(y, x, fineness);
        let earth = (1.0 + 0.45 * stones[0] + 0.3 * point.tone).max(0.2);
        [0, 1, 2].map(|i| grass_colour[i] + (brown[i] * earth - grass_colour[i]) * bare)
    }

    /// The ground at a place with the edge of an unmade road where it wanders to.
    #[inline]
    pub(crate) fn ragged(&self, x: f32, y: f32, point: GroundPoint) -> GroundPoint {
        let ragged_m = match (&self.materials, point.stroke) {
            (Some(_), Some(stroke)) => {
                self.lanes[stroke as usize].ground.map_or(0.0, |ground| ground.ragged_m)
            }
            _ => 0.0,
        };
        if ragged_m <= 0.0 || point.edge_m.abs() > 2.0 * ragged_m {
            return point;
        }
        let bays = self.soil.sample(0.5 * x, 0.5 * y, 0.05)[0];
        GroundPoint { edge_m: point.edge_m + ragged_m * bays, ..point }
    }

    /// Colour of a pavement that is not the usual one, and the road's own there.
    fn pavement(
        &self,
        [x, y]: [f32; 2],
        point: &GroundPoint,
        footprint: &Footprint,
        asphalt: Colour,
    ) -> Option<Colour> {
        let materials = self.materials.as_ref()?;
        let place = self.lanes[point.stroke? as usize].place(x, y);
        let fineness = footprint.fineness_m();
        let grain = self.asphalt.sample(y, x, fineness)[0];
        Some(match materials.pavement(&place) {
            PavementGround::Road(shade) => asphalt.map(|c| c * shade),
            PavementGround::Laid(base, pattern) => {
                let stained = base.map(|c| c * (1.0 + 0.25 * grain + 0.25 * point.tone));
                materials.laid(stained, pattern, &place, footprint)
            }
            PavementGround::Verge => self.verge(x, y, point, fineness),
        })
    }

    /// The covering at a place of a road.
    #[inline]
    fn covering(&self, lane: Option<&Lane>, x: f32, y: f32) -> Covering {
        match (&self.varied, lane) {
            (Some(varied), Some(lane)) => varied.covering(&lane.place(x, y)),
            _ => Covering::Map,
        }
    }

    /// Share of the paint that wear has left: flecks are gone, more of them in some stretches, and what is left is pale.
    #[inline(never)]
    fn left_of_paint(&self, x: f32, y: f32, point: &GroundPoint, fineness: f32) -> f32 {
        let chips = self.soil.sample(1.3 * x, 1.3 * y, 1.3 * fineness)[0];
        let flakes = self.soil.sample(0.37 * y, -0.37 * x, 0.37 * fineness)[1];
        let stretches = 0.3 * point.tone;
        // Half of the paint is gone from ground that is neither chipped nor spared at a wear of a half.
        let left = 0.5 + FLECK_STEEPNESS * (0.55 - self.worn + 0.5 * chips + 0.5 * flakes + stretches);
        left.clamp(0.0, 1.0) * (1.0 - FADES * self.worn)
    }

    /// Whether a stroke's covering bears paint at a place: no loose one does.
    pub(crate) fn bears_paint(&self, stroke: u32, x: f32, y: f32) -> bool {
        let lane = &self.lanes[stroke as usize];
        let as_mapped = lane.surface == Surface::Loose;
        let look = lane.ground.map(|ground| ground.look).or(self.covering(Some(lane), x, y).look());
        !look.map_or(as_mapped, |look| look.loose)
    }

    /// A flat pavement or a shoulder of gravel.
    #[inline(never)]
    fn roadside(
        &self,
        x: f32,
        y: f32,
        point: &GroundPoint,
        footprint: &Footprint,
        fineness: f32,
    ) -> Option<MadeGround> {
        let varied = self.varied.as_ref()?;
        let lane = &self.lanes[point.stroke? as usize];
        let grain = self.asphalt.sample(y, x, fineness)[0];
        let made = varied.roadside(&lane.place(x, y), point, footprint, grain);
        if made.class == PixelClass::Raised && self.materials.is_some() && made.share > 0.0 {
            let unpainted = GroundPoint { other_m: 0.0, ..*point };
            let (asphalt, _) = self.road(x, y, &unpainted, footprint, fineness);
            let own = self.pavement([x, y], point, footprint, asphalt).unwrap_or(made.colour);
            let behind_stone = ((point.edge_m - KERB_M) / fineness + 0.5).clamp(0.0, 1.0);
            return Some(MadeGround { colour: mixed(made.colour, own, behind_stone), ..made });
        }
        Some(made)
    }

    /// Dust over a colour: more of it in drifts and beside the road than where wheels roll.
    #[inline(never)]
    fn dusted(&self, colour: Colour, x: f32, y: f32, point: &GroundPoint, fineness: f32) -> Colour {
        let drifts = self.soil.sample(0.21 * x + 0.13 * y, 0.21 * y - 0.13 * x, 0.25 * fineness)[0];
        let beside = (1.0 + point.edge_m).clamp(0.0, 1.0);
        let share = self.dust * (0.62 + 0.35 * beside + 0.45 * drifts + 0.5 * point.tone);
        let grain = self.soil.sample(x, y, fineness)[1];
        mixed(colour, DUST.map(|c| c * (1.0 + 0.15 * grain)), share.clamp(0.0, 0.95))
    }

    /// Dapples and edges of a shadow: leaves that let sun through in flecks, rims from soft to hard.
    #[inline(never)]
    pub(crate) fn detailed_shadow(&self, x: f32, y: f32, point: &GroundPoint, fineness: f32) -> f32 {
        let leaves = self.grass.sample(0.37 * x, 0.37 * y, 0.37 * fineness)[0];
        // One in the softest places, six in the hardest.
        let steepness = 3.5 + 2.5 * (2.5 * point.hue).clamp(-1.0, 1.0);
        ((point.shadow - 0.5 + FLECKS * leaves) * steepness + 0.5).clamp(0.0, 1.0)
    }

    /// Share of the sunlight that posts and rails take from a place.
    #[inline(never)]
    pub(crate) fn roadside_shadow(
        &self,
        roadside: &Roadside,
        x: f32,
        y: f32,
        point: &GroundPoint,
        footprint: &Footprint,
    ) -> f32 {
        let Some(stroke) = point.stroke else { return 0.0 };
        let place = self.lanes[stroke as usize].place(x, y);
        let LocalPlace { chain, along_m, left_m, half_width_m, direction } = place;
        let beside = BesideRoad { chain, along_m, left_m, half_width_m, direction };
        roadside.shadow(&beside, place.extents_m(footprint), covered)
    }

    /// Fine unevenness of the ground at a place.
    pub(crate) fn grain(&self, x: f32, y: f32, fineness: f32) -> [f32; 2] {
        self.asphalt.sample(x, y, fineness)
    }
}
