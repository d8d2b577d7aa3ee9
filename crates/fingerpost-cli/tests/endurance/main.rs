//! Real runs that are killed, ended and starved of disk space at random moments: what is there afterwards is whole, and
//! the next run goes on in the same folder.
//!
//! `FINGERPOST_ENDURANCE_ROUNDS` is the number of rounds, 1 without it; a round is five kills, two terminations and one
//! full disk. The moments follow from a fixed seed; which frame they meet does not.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

mod faults;
mod folder;
mod soak;

use std::io::{self, Write};

use crate::faults::{Fault, Subject};
use crate::folder::{check, names};

/// Faults of a round.
const ROUND: [Fault; 8] = [
    Fault::Kill,
    Fault::Kill,
    Fault::Kill,
    Fault::Kill,
    Fault::Kill,
    Fault::Terminate,
    Fault::Terminate,
    Fault::FullDisk,
];
/// Seed of the moments.
const SEED: u64 = 19;

#[test]
fn what_is_there_after_a_fault_is_whole() {
    let rounds = std::env::var("FINGERPOST_ENDURANCE_ROUNDS").map_or(1, |text| text.parse().unwrap());
    let subject = Subject::new();
    let mut random = Random(SEED);
    let (mut seen_frames, mut found_frames) = (0, 0);
    for fault in (0..rounds).flat_map(|_| ROUND) {
        let seen = subject.meet(fault, &mut random);
        let found = check(&subject, fault, &seen);
        // A line that was seen is in the file; only a machine that ends loses what the disk does not have yet.
        assert!(found >= seen.frames, "{fault:?}: {found} of {} frames are left", seen.frames);
        seen_frames += seen.frames;
        found_frames += found;
    }
    // The last fault left its traces; a run that is left alone removes them.
    subject.run_to_its_end();
    let folders = [subject.folder().to_owned(), subject.out(), subject.out().join("pictures")];
    let stray: Vec<String> =
        folders.iter().flat_map(|folder| names(folder)).filter(|name| name.ends_with("-tmp")).collect();
    assert!(stray.is_empty(), "{stray:?} are left");
    let faults = rounds * ROUND.len();
    writeln!(
        io::stderr(),
        "{faults} faults; frames seen before them {seen_frames}, found after {found_frames}"
    )
    .unwrap();
}

/// Numbers that follow from a seed (splitmix64).
#[derive(Debug)]
struct Random(u64);

impl Random {
    /// A number in 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
