//! Pictures of drives as they were drawn before: a seed is a drive that others have measured on, and stays the same to the byte.
//!
//! Pictures to learn from (`WorldRanges::Wide`) are not among them: what they are drawn from may grow. Where a picture has to change, the
//! digests here change in the same commit, and the changelog says that drives have other pictures.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use std::fmt::Write;

use fingerpost_geometry::Distortion;
use fingerpost_map::OsmData;
use fingerpost_sim::{Conditions, SimConfig, Simulator, TOWN_OSM, World, WorldOptions};

/// Pictures are so small that all of them take seconds.
const SIZE_PX: [usize; 2] = [96, 72];
/// A frame behind the middle of a drive: what happens on the way, such as a camera that is knocked, has happened.
const FRAME: usize = 240;

/// Digests of the named days.
const DAYS: [(&str, u64); 25] = [
    ("clear", 0xda01_4cb8_9a32_4464),
    ("unmarked", 0x0b86_2c02_1f69_2a49),
    ("shadows", 0x0837_f179_6b1c_9927),
    ("rough", 0x8101_9f18_a28a_8c1a),
    ("ideal", 0xa7c4_abd9_f995_0ac1),
    ("wet", 0x66cc_db73_8574_4c8e),
    ("mixed", 0x7acb_0d33_7f1f_df5c),
    ("dusk", 0xafa3_89df_efef_6a31),
    ("dust", 0xa248_25da_81cb_f384),
    ("street", 0x99da_c98a_b3b9_e274),
    ("street_shade", 0xbc5f_bc75_0945_b48d),
    ("hills", 0xb5a0_1e23_bdd5_4a66),
    ("knocked", 0xb7b9_e95c_981a_6b81),
    ("dirty_lens", 0x0126_1254_7a31_4a63),
    ("lane_continuous", 0x2208_a539_00b9_5c9a),
    ("lane_broken", 0x5ece_ef3b_ea6a_6743),
    ("lane_double", 0x36ce_f9ea_bfe9_ea67),
    ("lane_worn", 0x1302_8514_eb7f_3b7e),
    ("lane_yellow", 0xa155_fbab_75ef_5141),
    ("lane_none", 0xe7be_9d97_4014_1aeb),
    ("lane_traffic", 0x1cfe_03fd_0790_d1d9),
    ("lane_night", 0xea07_ab1a_1bae_0563),
    ("lane_rain", 0x40a4_81b1_e760_8189),
    ("lane_shadows", 0x5c3d_fe2b_6682_e95f),
    ("lane_patches", 0x87b0_053a_3137_4002),
];

/// Digests of drawn worlds.
const WORLDS: [(&str, u64); 4] = [
    ("seed 1", 0x4845_80d5_4ae7_105d),
    ("seed 2", 0xb5d0_6379_9724_18ea),
    ("seed 3", 0x2b35_de36_5e04_c5a0),
    ("seed 4", 0x5605_6d54_bd78_061f),
];

/// FNV-1a with 64 bits (G. Fowler, L. Noll, K.-P. Vo, D. Eastlake, "The FNV non-cryptographic hash algorithm").
fn digest(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// As the tables above have it.
fn grouped(digest: u64) -> String {
    let [a, b, c, d] = [48, 32, 16, 0].map(|shift| digest >> shift & 0xffff);
    format!("0x{a:04x}_{b:04x}_{c:04x}_{d:04x}")
}

/// Holds the digests of pictures against those that are known, and names all that differ.
fn assert_same(found: impl Iterator<Item = (String, u64)>, known: &[(&str, u64)]) {
    let found: Vec<_> = found.collect();
    let is_same = found.iter().map(|(name, digest)| (name.as_str(), *digest)).eq(known.iter().copied());
    let mut lines = String::new();
    for (name, digest) in &found {
        writeln!(lines, "    (\"{name}\", {}),", grouped(*digest)).unwrap();
    }
    assert!(is_same, "pictures changed; they are now\n{lines}");
}

#[test]
fn every_named_day_keeps_its_pictures_to_the_byte() {
    let graph = common::graph();
    let route = common::route(&graph);
    let camera = common::camera(SIZE_PX[0], SIZE_PX[1], Distortion::None);
    let found = Conditions::names().iter().map(|name| {
        let conditions = Conditions::named(name).unwrap();
        let config = SimConfig { conditions, ..SimConfig::default() };
        let frame = Simulator::new(&graph, &route, &camera, &config).unwrap().frame(FRAME);
        ((*name).to_owned(), digest(frame.picture.as_slice()))
    });
    assert_same(found, &DAYS);
}

#[test]
fn worlds_of_the_usual_ranges_keep_their_pictures_to_the_byte() {
    let town = OsmData::from_bytes(TOWN_OSM).unwrap();
    let options = WorldOptions { size_px: Some(SIZE_PX), ..WorldOptions::default() };
    let found = (1..=4).map(|seed| {
        let frame = World::draw(seed, &town, &options).unwrap().simulator().unwrap().frame(FRAME);
        (format!("seed {seed}"), digest(frame.picture.as_slice()))
    });
    assert_same(found, &WORLDS);
}
