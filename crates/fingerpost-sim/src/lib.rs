//! A vehicle on a real map's roads, seen by its camera; truth beside every frame.
//!
//! Roads come from a [`fingerpost_map::RoadGraph`], the way from a [`fingerpost_map::Route`], the lens from a
//! [`fingerpost_geometry::Camera`]; [`Conditions`] say what the day is like. [`Simulator::frame`] renders a picture
//! with an own ray caster, the mask of the road in it, and the [`fingerpost_format::TruthRecord`]. It knows nothing of
//! the method that is tried on its pictures. No file, clock or global state: the same input and seed give the same
//! bytes, frame by frame, on any number of threads and in any order.
//!
//! [`World`] draws all of these, and what is known of them, from a seed. [`RoadCourse`] makes up roads where no map is
//! wanted, [`DrivingPlan`] says how the vehicle is driven on them; or a [`SteeredDrive`] goes where it is steered.
//!
//! Limits: other vehicles keep their speed and give way to nothing; bridges are level crossings; lenses as sharp in the corners as in the
//! middle, motion blur that of driving straight on, no rolling shutter; roads within 80 m of the route.

mod bicycle;
mod bonnet;
mod bus;
mod camera_channel;
mod camera_knock;
mod conditions;
mod config;
mod corners;
mod course;
mod crossing;
mod dirt;
mod drive;
mod driving;
mod error;
mod frontage;
mod ground;
mod junctions;
mod kerb_lines;
mod lane_middle;
mod lens;
mod light;
mod markings;
mod mouth_lines;
mod noise;
mod object;
mod path;
mod rain;
mod random_drive;
mod relief;
mod render;
mod roads;
mod roadside;
mod scenery;
mod shown;
mod simulator;
mod sky;
mod softening;
mod steered;
mod street;
mod street_paint;
mod surface;
mod texture;
mod tone;
mod town;
mod traffic;
mod truth;
mod turns;
mod vehicle;
mod wet;
mod windscreen;
mod world;

pub use bicycle::{Actuation, Bicycle, DriveCommand};
pub use bus::{BUS_DATABASE, BUS_SETTINGS};
pub use camera_channel::{Arrival, CameraChannel, CameraFault};
pub use conditions::{
    CameraLook, Conditions, LaneMarkings, LineColour, LinePattern, LineStyle, Markings, Streetscape,
};
pub use config::{DrivingHabits, SimConfig, SimVehicle, TrafficSide};
pub use corners::CornerStyle;
pub use course::{CoursePiece, RoadCourse};
pub use crossing::Crossing;
pub use driving::{DrivingManner, DrivingPlan, Manoeuvre};
pub use error::SimError;
pub use random_drive::{RandomRouteOptions, random_drive, random_route};
pub use shown::PixelClass;
pub use simulator::{SimFrame, Simulator};
pub use steered::{RoadStrip, SteeredDrive, SteeredPlace};
pub use town::{TOWN_OSM, TOWN_ROUTE};
pub use truth::RoadPlace;
pub use windscreen::windscreen_camera;
pub use world::{MapFault, World, WorldOptions, WorldRanges, misled_route};
