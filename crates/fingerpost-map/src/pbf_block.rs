//! A block of OSM PBF (the format's `osmformat.proto`): its nodes and highways.
//!
//! Nothing is taken for a number that the block states; texts are looked up where they lie. Relations are passed over.

use std::collections::BTreeMap;

use crate::LatLon;
use crate::osm::{OsmData, OsmError, OsmNode, OsmWay};
use crate::osm_budget::Budget;
use crate::osm_pbf::broken;
use crate::pbf_fields::{Fields, Packed, Sums, Value, signed};

/// Billionths of a degree in a unit of a block that does not say it.
const GRANULARITY: i64 = 100;

/// Adds what a block holds to `data`.
pub(crate) fn read_block(block: &[u8], data: &mut OsmData, budget: &mut Budget) -> Result<(), OsmError> {
    let reading = Block::of(block, budget)?;
    let taken = reading.texts.len().saturating_mul(size_of::<&[u8]>());
    let mut fields = Fields::of(block);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        if number == 2 {
            reading.group(value.bytes().map_err(broken)?, data, budget)?;
        }
    }
    drop(reading);
    budget.give_back(taken);
    Ok(())
}

/// What the elements of a block refer to.
struct Block<'a> {
    texts: Vec<&'a [u8]>,
    granularity: i64,
    lat_offset: i64,
    lon_offset: i64,
}

impl<'a> Block<'a> {
    fn of(block: &'a [u8], budget: &mut Budget) -> Result<Self, OsmError> {
        let mut made = Self { texts: Vec::new(), granularity: GRANULARITY, lat_offset: 0, lon_offset: 0 };
        let mut table: &[u8] = &[];
        let mut fields = Fields::of(block);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            match (number, value) {
                (1, Value::Bytes(bytes)) => table = bytes,
                (17, Value::Number(number)) => made.granularity = i64::from(number as i32),
                (19, Value::Number(number)) => made.lat_offset = number as i64,
                (20, Value::Number(number)) => made.lon_offset = number as i64,
                _ => {}
            }
        }
        let mut count = 0_usize;
        each_text(table, |_| count += 1)?;
        budget.take(count.saturating_mul(size_of::<&[u8]>()))?;
        made.texts.reserve_exact(count);
        each_text(table, |text| made.texts.push(text))?;
        Ok(made)
    }

    fn group(&self, group: &[u8], data: &mut OsmData, budget: &mut Budget) -> Result<(), OsmError> {
        let mut fields = Fields::of(group);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            match (number, value) {
                (1, Value::Bytes(node)) => self.node(node, data, budget)?,
                (2, Value::Bytes(nodes)) => self.dense_nodes(nodes, data, budget)?,
                (3, Value::Bytes(way)) => self.way(way, data, budget)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn node(&self, node: &[u8], data: &mut OsmData, budget: &mut Budget) -> Result<(), OsmError> {
        let (mut id, mut lat, mut lon) = (None, None, None);
        let mut fields = Fields::of(node);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            match (number, value) {
                (1, Value::Number(number)) => id = Some(signed(number)),
                (8, Value::Number(number)) => lat = Some(signed(number)),
                (9, Value::Number(number)) => lon = Some(signed(number)),
                _ => {}
            }
        }
        let (Some(id), Some(lat), Some(lon)) = (id, lat, lon) else {
            return Err(broken("a node without number or place"));
        };
        self.place(id, lat, lon, data, budget)
    }

    fn dense_nodes(&self, nodes: &[u8], data: &mut OsmData, budget: &mut Budget) -> Result<(), OsmError> {
        let [ids, lats, lons] = columns(nodes, [1, 8, 9])?;
        let (mut ids, mut lats, mut lons) = (Sums::of(ids), Sums::of(lats), Sums::of(lons));
        loop {
            let next = [&mut ids, &mut lats, &mut lons].map(Sums::next);
            match next {
                [Ok(None), Ok(None), Ok(None)] => return Ok(()),
                [Ok(Some(id)), Ok(Some(lat)), Ok(Some(lon))] => self.place(id, lat, lon, data, budget)?,
                [Err(cause), ..] | [_, Err(cause), _] | [.., Err(cause)] => return Err(broken(cause)),
                _ => return Err(broken("nodes have not as many places as numbers")),
            }
        }
    }

    /// Adds a node at a place in the block's units.
    fn place(
        &self,
        id: i64,
        lat: i64,
        lon: i64,
        data: &mut OsmData,
        budget: &mut Budget,
    ) -> Result<(), OsmError> {
        let degrees = |at: i64, offset: i64| {
            let nano_degrees = at.checked_mul(self.granularity).and_then(|at| at.checked_add(offset));
            // The division rounds to the f64 that the decimal number in OSM XML reads as.
            nano_degrees.map(|nano_degrees| nano_degrees as f64 / 1e9)
        };
        let at = degrees(lat, self.lat_offset).zip(degrees(lon, self.lon_offset));
        let (lat_deg, lon_deg) = at.ok_or_else(|| broken(format!("node {id} has a place beyond 64 bits")))?;
        let at = LatLon::new(lat_deg, lon_deg).map_err(|error| broken(format!("node {id}: {error}")))?;
        budget.take_node()?;
        data.nodes.push(OsmNode { id, at });
        Ok(())
    }

    fn way(&self, way: &[u8], data: &mut OsmData, budget: &mut Budget) -> Result<(), OsmError> {
        let mut id = None;
        let mut fields = Fields::of(way);
        while let Some((number, value)) = fields.next().map_err(broken)? {
            if let (1, Value::Number(number)) = (number, value) {
                id = Some(number as i64);
            }
        }
        let id = id.ok_or_else(|| broken("a way without a number"))?;
        let [keys, values, references] = columns(way, [2, 3, 8])?;
        let mut is_highway = false;
        self.each_tag(keys, values, |key, _| {
            is_highway |= key == b"highway";
            Ok(())
        })?;
        if !is_highway {
            return Ok(());
        }
        budget.take_way()?;
        let mut tags = BTreeMap::new();
        self.each_tag(keys, values, |key, value| {
            let [key, value] = [key, value].map(str::from_utf8);
            let (Ok(key), Ok(value)) = (key, value) else {
                return Err(broken(format!("a tag of way {id} is not UTF-8 text")));
            };
            budget.take_tag(key, value)?;
            tags.insert(key.to_owned(), value.to_owned());
            Ok(())
        })?;
        let mut nodes = Vec::new();
        let mut references = Sums::of(references);
        while let Some(node) = references.next().map_err(broken)? {
            budget.take_reference()?;
            nodes.push(node);
        }
        data.ways.push(OsmWay { id, nodes, tags });
        Ok(())
    }

    fn each_tag(
        &self,
        keys: &[u8],
        values: &[u8],
        mut each: impl FnMut(&'a [u8], &'a [u8]) -> Result<(), OsmError>,
    ) -> Result<(), OsmError> {
        let (mut keys, mut values) = (Packed::of(keys), Packed::of(values));
        loop {
            let (key, value) = (keys.next().map_err(broken)?, values.next().map_err(broken)?);
            match (key, value) {
                (None, None) => return Ok(()),
                (Some(key), Some(value)) => each(self.text(key)?, self.text(value)?)?,
                _ => return Err(broken("a way has not as many values as keys")),
            }
        }
    }

    fn text(&self, number: u64) -> Result<&'a [u8], OsmError> {
        let text = usize::try_from(number).ok().and_then(|number| self.texts.get(number));
        text.copied().ok_or_else(|| broken(format!("a tag has text {number} of {}", self.texts.len())))
    }
}

/// The packed numbers of the fields of these numbers; none where a field is missing.
fn columns<const N: usize>(message: &[u8], wanted: [u32; N]) -> Result<[&[u8]; N], OsmError> {
    let mut found: [&[u8]; N] = [&[]; N];
    let mut fields = Fields::of(message);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        if let Some(place) = wanted.iter().position(|wanted| *wanted == number) {
            let bytes = value.bytes().map_err(broken)?;
            if !found[place].is_empty() {
                return Err(broken("numbers that belong together stand in two fields"));
            }
            found[place] = bytes;
        }
    }
    Ok(found)
}

fn each_text<'a>(table: &'a [u8], mut each: impl FnMut(&'a [u8])) -> Result<(), OsmError> {
    let mut fields = Fields::of(table);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        if number == 1 {
            each(value.bytes().map_err(broken)?);
        }
    }
    Ok(())
}
