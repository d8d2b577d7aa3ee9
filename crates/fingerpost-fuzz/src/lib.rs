//! What must hold of every parser, whatever bytes it is given.
//!
//! A [`Parser`] is a body that reads bytes and asserts what must hold: it does not panic, what it accepts is finite and within
//! its ranges, and what is written of it reads back. The bodies serve two callers: the bounded tests of this crate, which change
//! real files with a [`Mutator`] of a fixed seed, and the targets in `fuzz/`, which libFuzzer drives.
//!
//! Requests over HTTP are parsed by hyper and are no part of this; videos are read by ffmpeg.

mod config;
mod drives;
mod maps;
mod mutator;
mod pictures;
mod recordings;
mod vehicles;

pub use mutator::Mutator;

/// A parser under test.
#[derive(Debug, Clone, Copy)]
pub struct Parser {
    /// What it reads; the name of its target in `fuzz/fuzz_targets`.
    pub name: &'static str,
    /// Reads bytes, says whether they were accepted, and panics where something does not hold that must.
    pub body: fn(&[u8]) -> bool,
    /// Files that it reads, to be changed.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// Every parser of files that come from outside, and of results that are read again.
pub const PARSERS: &[Parser] = &[
    Parser { name: "picture", body: pictures::picture, seeds: pictures::seeds },
    Parser { name: "road_network", body: pictures::road_network, seeds: pictures::road_network_seeds },
    Parser { name: "camera_toml", body: drives::camera_toml, seeds: drives::camera_toml_seeds },
    Parser { name: "camera_yaml", body: drives::camera_yaml, seeds: drives::camera_yaml_seeds },
    Parser { name: "mount_toml", body: drives::mount_toml, seeds: drives::mount_toml_seeds },
    Parser { name: "times", body: drives::times, seeds: drives::times_seeds },
    Parser { name: "motion_log", body: drives::motion_log, seeds: drives::motion_log_seeds },
    Parser { name: "pose_log", body: drives::pose_log, seeds: drives::pose_log_seeds },
    Parser { name: "frames", body: drives::frames, seeds: drives::frames_seeds },
    Parser { name: "truth", body: drives::truth, seeds: drives::truth_seeds },
    Parser { name: "trials", body: drives::trials, seeds: drives::trials_seeds },
    Parser { name: "closed_loop", body: drives::closed_loop, seeds: drives::closed_loop_seeds },
    Parser { name: "summary", body: drives::summary, seeds: drives::summary_seeds },
    Parser { name: "tusimple", body: drives::tusimple, seeds: drives::tusimple_seeds },
    Parser { name: "marks", body: drives::marks, seeds: drives::marks_seeds },
    Parser { name: "osm_xml", body: maps::osm_xml, seeds: maps::osm_xml_seeds },
    Parser { name: "osm_pbf", body: maps::osm_pbf, seeds: maps::osm_pbf_seeds },
    Parser { name: "osm_pbf_block", body: maps::osm_pbf_block, seeds: maps::osm_pbf_block_seeds },
    Parser { name: "gpx", body: maps::gpx, seeds: maps::gpx_seeds },
    Parser { name: "gps_log", body: maps::gps_log, seeds: maps::gps_log_seeds },
    Parser { name: "route", body: maps::route, seeds: maps::route_seeds },
    Parser { name: "can_log", body: vehicles::can_log, seeds: vehicles::can_log_seeds },
    Parser { name: "can_log_gzip", body: vehicles::can_log_gzip, seeds: vehicles::can_log_seeds },
    Parser { name: "can_database", body: vehicles::can_database, seeds: vehicles::can_database_seeds },
    Parser { name: "bag", body: recordings::bag, seeds: recordings::bag_seeds },
    Parser { name: "bag_message", body: recordings::message, seeds: recordings::message_seeds },
    Parser { name: "kitti", body: drives::kitti, seeds: drives::kitti_seeds },
    Parser { name: "kitti_poses", body: drives::kitti_poses, seeds: drives::kitti_poses_seeds },
    Parser { name: "config", body: config::config, seeds: config::config_seeds },
    Parser { name: "fuzzy_rules", body: config::fuzzy_rules, seeds: config::fuzzy_rules_seeds },
    Parser { name: "fed_frames", body: vehicles::fed_frames, seeds: vehicles::fed_frames_seeds },
    Parser { name: "bank", body: config::bank, seeds: config::bank_seeds },
];

/// The body of the parser `name`, for the targets of libFuzzer.
///
/// # Panics
/// Where there is no parser of that name, or something does not hold.
pub fn run(name: &str, bytes: &[u8]) {
    let parser = PARSERS.iter().find(|parser| parser.name == name);
    assert!(parser.is_some(), "there is no parser {name}");
    if let Some(parser) = parser {
        (parser.body)(bytes);
    }
}

/// The value of a result that must be one.
#[track_caller]
fn must<T, E: std::fmt::Display>(result: Result<T, E>, what: &str) -> T {
    match result {
        Ok(value) => value,
        #[expect(clippy::panic, reason = "a finding is a panic, as libFuzzer wants it")]
        Err(error) => panic!("{what}: {error}"),
    }
}

/// A file that holds `bytes`, for readers that take a path; it goes when it is dropped.
fn file(bytes: &[u8], suffix: &str) -> tempfile::NamedTempFile {
    let mut builder = tempfile::Builder::new();
    // A folder in memory where there is one: the disk is no part of what is tested.
    let memory = std::path::Path::new("/dev/shm");
    let builder = builder.suffix(suffix);
    let made = if memory.is_dir() { builder.tempfile_in(memory) } else { builder.tempfile() };
    let mut file = must(made, "a temporary file");
    must(std::io::Write::write_all(&mut file, bytes), "a temporary file");
    file
}
