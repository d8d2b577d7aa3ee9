//! Small maps that stand for much: what is taken for them is counted before it is taken.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used)]

mod pbf_bytes;

use fingerpost_map::{OsmData, OsmError};
use pbf_bytes::{field, map_of, varint};

/// Memory that the maps may take, bytes.
const LIMIT_BYTES: usize = 20_000_000;

/// A map of one way that has `tags` tags, each of a key of its own and all of one value of `value_bytes` bytes.
fn map(tags: u32, value_bytes: usize) -> Vec<u8> {
    let mut strings: Vec<Vec<u8>> = vec![Vec::new(), b"highway".to_vec(), vec![b'v'; value_bytes]];
    strings.extend((0..tags).map(|number| format!("{number}").into_bytes()));
    let table: Vec<u8> = strings.iter().flat_map(|text| field(1, text)).collect();
    let keys: Vec<u8> =
        varint(1).into_iter().chain((0..tags).flat_map(|i| varint(u64::from(i) + 3))).collect();
    let values: Vec<u8> = (0..=tags).flat_map(|_| varint(2)).collect();
    let way = [vec![1 << 3, 1], field(2, &keys), field(3, &values)].concat();
    let block = [field(1, &table), field(2, &field(3, &way))].concat();
    map_of(&block)
}

/// Reads a map, and says how much memory that took at once, bytes.
fn measured(bytes: &[u8]) -> (u64, Result<usize, OsmError>) {
    let mut read = None;
    let taken = allocation_counter::measure(|| {
        read = Some(OsmData::from_bytes_within(bytes, LIMIT_BYTES).map(|data| data.ways.len()));
    });
    (taken.bytes_max, read.unwrap())
}

#[test]
fn tags_that_share_a_text_are_counted_one_by_one() {
    for (tags, value_bytes) in [(1, 10), (1000, 100), (2000, 1000), (2000, 50_000), (9000, 400_000)] {
        let bytes = map(tags, value_bytes);
        let (taken, read) = measured(&bytes);
        let stands_for = tags as usize * value_bytes;
        if stands_for < LIMIT_BYTES / 2 {
            assert_eq!(read, Ok(1), "{tags} tags of {value_bytes} bytes");
        } else {
            assert!(
                matches!(read, Err(OsmError::TooLarge { .. })),
                "{tags} tags of {value_bytes} bytes: {read:?}"
            );
        }
        let most = LIMIT_BYTES as u64 + 10 * bytes.len() as u64;
        assert!(taken < most, "{taken} bytes for a file of {}", bytes.len());
    }
}
