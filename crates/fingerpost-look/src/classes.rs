//! What the road network sees in the pictures of a run.

use fingerpost_server::Pictures;
use serde::Serialize;

/// The network's classes over the camera's pictures.
pub struct NetworkClasses {
    /// What the colours say.
    pub legend: Vec<SeenClass>,
    /// The pictures, each made when it is asked for.
    pub pictures: Box<dyn Pictures>,
}

/// A class that the network tells from others.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SeenClass {
    /// Its name.
    name: &'static str,
    /// Its colour, as CSS has it.
    colour: String,
}

impl SeenClass {
    /// A class of that name, drawn in that colour: red, green, blue.
    pub fn new(name: &'static str, [red, green, blue]: [u8; 3]) -> Self {
        Self { name, colour: format!("#{red:02x}{green:02x}{blue:02x}") }
    }
}

/// What a page is told of them.
#[derive(Debug, Serialize)]
pub(crate) struct PageClasses {
    /// Of no class where they cannot be shown.
    pub(crate) legend: Vec<SeenClass>,
    /// Why they cannot be shown.
    pub(crate) lacking: Option<String>,
}
