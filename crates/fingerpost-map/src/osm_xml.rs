//! OSM XML.

use std::collections::BTreeMap;

use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

use crate::LatLon;
use crate::osm::{OsmData, OsmError, OsmNode, OsmWay};
use crate::osm_budget::Budget;

/// Reads nodes and highways in the document's order.
pub(crate) fn read(bytes: &[u8], memory_bytes: usize) -> Result<OsmData, OsmError> {
    let text = std::str::from_utf8(bytes).map_err(|error| OsmError::Xml {
        at_byte: error.valid_up_to() as u64,
        cause: "not UTF-8 text".to_owned(),
    })?;
    let mut reader = Reader::from_str(text);
    let mut document = Document::within(memory_bytes);
    loop {
        let at_byte = reader.buffer_position();
        let step = match reader.read_event() {
            Ok(Event::Start(element)) => document.open(&element),
            Ok(Event::Empty(element)) => document.open(&element).and_then(|()| document.close()),
            Ok(Event::End(_)) => document.close(),
            Ok(Event::Eof) => break,
            Ok(_) => Ok(()),
            Err(error) => Err(error.to_string().into()),
        };
        step.map_err(|fault| fault.at(at_byte))?;
    }
    document.finish().map_err(|fault| fault.at(bytes.len() as u64))
}

/// Why reading ends.
enum Fault {
    /// What is wrong with the document.
    Broken(String),
    /// It is too large.
    TooLarge(OsmError),
}

impl Fault {
    fn at(self, at_byte: u64) -> OsmError {
        match self {
            Self::Broken(cause) => OsmError::Xml { at_byte, cause },
            Self::TooLarge(error) => error,
        }
    }
}

impl From<String> for Fault {
    fn from(cause: String) -> Self {
        Self::Broken(cause)
    }
}

impl From<OsmError> for Fault {
    fn from(error: OsmError) -> Self {
        Self::TooLarge(error)
    }
}

/// What has been read so far.
struct Document {
    data: OsmData,
    budget: Budget,
    depth: usize,
    is_osm: bool,
    /// The way whose element is open; deleted ways too, so that their tags go nowhere else.
    way: Option<OsmWay>,
    way_is_deleted: bool,
}

impl Document {
    fn within(memory_bytes: usize) -> Self {
        Self {
            data: OsmData::default(),
            budget: Budget::new(memory_bytes),
            depth: 0,
            is_osm: false,
            way: None,
            way_is_deleted: false,
        }
    }

    fn open(&mut self, element: &BytesStart<'_>) -> Result<(), Fault> {
        self.depth += 1;
        match (self.depth, element.name().as_ref()) {
            (1, "osm") => self.is_osm = true,
            (1, other) => return Err(format!("the document is <{other}>, not <osm>").into()),
            (2, "node") => {
                let attributes = Attributes::of(element)?;
                if !attributes.deleted() {
                    let at = LatLon::new(attributes.number("lat")?, attributes.number("lon")?)
                        .map_err(|error| error.to_string())?;
                    self.budget.take_node()?;
                    self.data.nodes.push(OsmNode { id: attributes.number("id")?, at });
                }
            }
            (2, "way") => {
                let attributes = Attributes::of(element)?;
                self.way_is_deleted = attributes.deleted();
                let id = attributes.number("id")?;
                self.way = Some(OsmWay { id, nodes: Vec::new(), tags: BTreeMap::new() });
            }
            (3, "nd") => {
                if let Some(way) = &mut self.way {
                    way.nodes.push(Attributes::of(element)?.number("ref")?);
                }
            }
            (3, "tag") => {
                if let Some(way) = &mut self.way {
                    let attributes = Attributes::of(element)?;
                    way.tags.insert(attributes.text("k")?.to_owned(), attributes.text("v")?.to_owned());
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn close(&mut self) -> Result<(), Fault> {
        self.depth = self.depth.saturating_sub(1);
        if self.depth == 1
            && let Some(way) = self.way.take()
            && !self.way_is_deleted
            && way.tags.contains_key("highway")
        {
            // XML holds every text as often as it is used: what a way takes is no more than its part of the file.
            self.budget.take_way()?;
            way.tags.iter().try_for_each(|(key, value)| self.budget.take_tag(key, value))?;
            way.nodes.iter().try_for_each(|_| self.budget.take_reference())?;
            self.data.ways.push(way);
        }
        Ok(())
    }

    fn finish(self) -> Result<OsmData, Fault> {
        if !self.is_osm {
            Err("there is no <osm> element".to_owned().into())
        } else if self.depth > 0 {
            Err("the document ends in the middle; it is cut short".to_owned().into())
        } else {
            Ok(self.data)
        }
    }
}

/// The attributes of one element.
struct Attributes {
    element: String,
    values: BTreeMap<String, String>,
}

impl Attributes {
    fn of(element: &BytesStart<'_>) -> Result<Self, String> {
        let mut values = BTreeMap::new();
        for attribute in element.attributes() {
            let attribute = attribute.map_err(|error| error.to_string())?;
            let value =
                attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|error| error.to_string())?;
            values.insert(attribute.key.as_ref().to_owned(), value.into_owned());
        }
        Ok(Self { element: element.name().as_ref().to_owned(), values })
    }

    fn text(&self, key: &str) -> Result<&str, String> {
        self.values
            .get(key)
            .map(String::as_str)
            .ok_or_else(|| format!("<{}> lacks the attribute {key}", self.element))
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, String> {
        let text = self.text(key)?;
        text.trim().parse().map_err(|_| format!("{key}=\"{text}\" of <{}> is no number", self.element))
    }

    /// Whether an editor marks the element as deleted; its place may be missing then.
    fn deleted(&self) -> bool {
        let is = |key: &str, value: &str| self.values.get(key).is_some_and(|v| v == value);
        is("visible", "false") || is("action", "delete")
    }
}
