//! PBF that was made to do harm: numbers that do not fit, and blocks that stand for more than they hold.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used)]

mod pbf_bytes;

use fingerpost_map::{OsmData, OsmError};
use pbf_bytes::{field, map_of, number_field, packed, varint};

/// Memory that the maps may take, bytes.
const LIMIT_BYTES: usize = 20_000_000;

/// The numbers of a block of nodes, in the order that the format has them.
#[derive(Clone)]
struct Nodes {
    ids: Vec<i64>,
    lats: Vec<i64>,
    lons: Vec<i64>,
    granularity: i64,
    offset: i64,
}

impl Nodes {
    fn few() -> Self {
        Self { ids: vec![1, 1, 1], lats: vec![5, 1, 1], lons: vec![7, 1, -2], granularity: 100, offset: 0 }
    }

    /// The map's bytes; numbers of nodes and places are written as they are, as differences.
    fn map(&self) -> Vec<u8> {
        let dense =
            [field(1, &packed(&self.ids)), field(8, &packed(&self.lats)), field(9, &packed(&self.lons))]
                .concat();
        let block = [
            field(1, &[]),
            field(2, &field(2, &dense)),
            number_field(17, self.granularity as u64),
            number_field(19, self.offset as u64),
            number_field(20, self.offset as u64),
        ];
        map_of(&block.concat())
    }

    /// The nodes by sums that cannot overflow; none where a number, a place or the map is none.
    fn expected(&self) -> Option<Vec<(i64, i128, i128)>> {
        let sums = |differences: &[i64]| {
            let mut sum = 0_i128;
            let sums = differences.iter().map(|difference| {
                sum += i128::from(*difference);
                i64::try_from(sum).ok()
            });
            sums.collect::<Option<Vec<i64>>>()
        };
        let nano = |at: i64| {
            let scaled = i128::from(at) * i128::from(self.granularity);
            let nano = scaled + i128::from(self.offset);
            (i64::try_from(scaled).is_ok() && i64::try_from(nano).is_ok()).then_some(nano)
        };
        let (ids, lats, lons) = (sums(&self.ids)?, sums(&self.lats)?, sums(&self.lons)?);
        let mut nodes = Vec::new();
        for ((id, lat), lon) in ids.into_iter().zip(lats).zip(lons) {
            let (lat, lon) = (nano(lat)?, nano(lon)?);
            if lat.abs() > 90_000_000_000 || lon.abs() > 180_000_000_000 {
                return None;
            }
            nodes.push((id, lat, lon));
        }
        nodes.sort_by_key(|node| node.0);
        nodes.dedup_by_key(|node| node.0);
        Some(nodes)
    }
}

#[test]
fn every_number_beyond_its_range_is_refused_and_none_wraps() {
    let odd =
        [0, 1, -1, 1 << 31, 1 << 40, 1 << 62, i64::MAX, i64::MIN, i64::MIN + 1, 1_800_000_000, -900_000_001];
    let mut changed = Vec::new();
    for value in odd {
        for other in odd {
            for index in 0..3 {
                let change = |change: &dyn Fn(&mut Nodes)| {
                    let mut nodes = Nodes::few();
                    change(&mut nodes);
                    nodes
                };
                changed
                    .push(change(&|nodes| (nodes.ids[index], nodes.ids[(index + 1) % 3]) = (value, other)));
                changed
                    .push(change(&|nodes| (nodes.lats[index], nodes.lats[(index + 1) % 3]) = (value, other)));
                changed.push(change(&|nodes| (nodes.lons[index], nodes.offset) = (value, other)));
                changed.push(change(&|nodes| {
                    (nodes.lats[index], nodes.granularity) = (value, i64::from(other as i32));
                }));
            }
        }
    }
    let mut read = 0;
    for nodes in changed {
        match (OsmData::from_bytes(&nodes.map()), nodes.expected()) {
            (Ok(data), Some(expected)) => {
                let seen: Vec<(i64, f64, f64)> =
                    data.nodes.iter().map(|node| (node.id, node.at.lat_deg, node.at.lon_deg)).collect();
                let expected: Vec<(i64, f64, f64)> = expected
                    .into_iter()
                    .map(|(id, lat, lon)| (id, lat as f64 / 1e9, lon as f64 / 1e9))
                    .collect();
                assert_eq!(seen, expected);
                read += 1;
            }
            (Err(OsmError::Pbf { .. }), None) => {}
            (seen, expected) => panic!("{seen:?} where {expected:?} was expected"),
        }
    }
    assert!(read > 20, "{read} maps were read");
}

#[test]
fn numbers_of_a_ways_nodes_do_not_wrap() {
    for (references, is_read) in [
        (vec![1, 1, -2], true),
        (vec![i64::MAX, i64::MIN, 1], true),
        (vec![i64::MAX, 1], false),
        (vec![i64::MIN, -1], false),
    ] {
        let way = [vec![1 << 3, 1], field(2, &[1]), field(3, &[1]), field(8, &packed(&references))].concat();
        let table = [field(1, &[]), field(1, b"highway")].concat();
        let block = [field(1, &table), field(2, &field(3, &way))].concat();
        let read = OsmData::from_bytes(&map_of(&block));
        assert_eq!(read.is_ok(), is_read, "{references:?}: {read:?}");
    }
}

/// What is taken at once to read a map, bytes, and whether it was read.
fn measured(bytes: &[u8]) -> (u64, Result<usize, OsmError>) {
    let mut read = None;
    let taken = allocation_counter::measure(|| {
        read = Some(OsmData::from_bytes_within(bytes, LIMIT_BYTES).map(|data| data.nodes.len()));
    });
    (taken.bytes_max, read.unwrap())
}

#[test]
fn nothing_that_a_block_repeats_takes_memory_beyond_the_limit() {
    let nodes = |count: usize| {
        let ones = packed(&vec![1; count]);
        let zeros = packed(&vec![0; count]);
        field(2, &field(2, &[field(1, &ones), field(8, &zeros), field(9, &zeros)].concat()))
    };
    let pieces: [(&str, Vec<u8>); 8] = [
        ("empty groups", field(2, &[])),
        ("empty ways", field(2, &field(3, &[1 << 3, 1]))),
        ("empty relations", field(2, &field(4, &[]))),
        ("unknown messages", field(9, &[])),
        ("unknown numbers", [vec![10 << 3], varint(u64::MAX)].concat()),
        ("granularities", number_field(17, 100)),
        ("small tables", field(1, &field(1, &[]))),
        ("nodes", nodes(1000)),
    ];
    for (name, piece) in pieces {
        let block = piece.repeat(15_000_000 / piece.len());
        for block in [block.clone(), field(1, &field(1, &[]).repeat(7_000_000))] {
            let bytes = map_of(&block);
            let (taken, _) = measured(&bytes);
            assert!(
                taken < LIMIT_BYTES as u64 + 1_000_000,
                "{name}: {taken} bytes for a file of {}",
                bytes.len()
            );
        }
    }
    let (_, read) = measured(&map_of(&nodes(1000)));
    assert_eq!(read, Ok(1000));
}

#[test]
fn a_block_that_unpacks_to_more_than_the_limit_is_refused_before_it_is_there() {
    for (megabytes, is_read) in [(1, true), (10, true), (31, false), (400, false)] {
        // Fields that nobody knows, which packing makes a thousandth of.
        let block = field(15, &vec![0; 1_000_000]).repeat(megabytes);
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        std::io::Write::write_all(&mut packer, &block).unwrap();
        let contents = field(3, &packer.finish().unwrap());
        let stated = |size: u64| [number_field(2, size), contents.clone()].concat();
        let size = block.len() as u64;
        for (blob, is_read) in [
            (contents.clone(), is_read),
            (stated(size), is_read),
            (stated(size + 1), false),
            (stated(u64::MAX), false),
        ] {
            let bytes = [pbf_bytes::blob("OSMHeader", &field(1, &[])), pbf_bytes::blob("OSMData", &blob)];
            let (taken, read) = measured(&bytes.concat());
            assert_eq!(read.is_ok(), is_read, "{megabytes} MB: {read:?}");
            assert!(taken < LIMIT_BYTES as u64 + 1_000_000, "{megabytes} MB: {taken} bytes");
        }
    }
}

#[test]
fn groups_within_groups_are_refused() {
    for depth in [1, 1000, 1_000_000] {
        let block = [vec![5 << 3 | 3; depth], vec![5 << 3 | 4; depth]].concat();
        let read = OsmData::from_bytes(&map_of(&block));
        assert!(matches!(read, Err(OsmError::Pbf { .. })), "{depth} deep: {read:?}");
    }
}

#[test]
fn numbers_without_an_end_or_of_too_many_bits_are_refused() {
    for (number, is_read) in [
        (varint(0x7f), true),
        (varint(u64::MAX), true),
        ([vec![0xff; 9], vec![0x02]].concat(), false),
        ([vec![0xff; 10], vec![0x01]].concat(), false),
        (vec![0x80; 3], false),
    ] {
        let read = OsmData::from_bytes(&map_of(&[vec![10 << 3], number.clone()].concat()));
        assert_eq!(read.is_ok(), is_read, "{number:x?}: {read:?}");
    }
}
