//! Recordings that a small file makes large: names, numbers that change their meaning, and records beyond every size.

// Functions shared by tests fail their test by panicking.
#![allow(clippy::unwrap_used)]

use fingerpost_io::bag::{RecordsError, Survey, survey};
use mcap::MAGIC;
use mcap::records::op;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

/// Bytes of a name that no recorder writes; of every kind of record there are forty.
const LONG_NAME_BYTES: usize = 1 << 20;
const LONG_NAMES: u16 = 40;
/// Memory that names may take: 16 MB of a recording's, once with its channels and twice with its topics, and a chunk of 40 MB, packed,
/// unpacked and in the decoder's window, which grows by doubling.
const MOST_BYTES: u64 = 300_000_000;

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn schema(id: u16, name: &str) -> Vec<u8> {
    record(op::SCHEMA, &[&id.to_le_bytes()[..], &text(name), &text("ros2msg"), &text("")].concat())
}

fn channel(id: u16, schema: u16, topic: &str, encoding: &str) -> Vec<u8> {
    let numbers = [id.to_le_bytes(), schema.to_le_bytes()].concat();
    record(op::CHANNEL, &[&numbers[..], &text(topic), &text(encoding), &text("")].concat())
}

fn message(channel: u16) -> Vec<u8> {
    record(op::MESSAGE, &[&channel.to_le_bytes()[..], &[0; 20], b"payload"].concat())
}

fn chunk(records: &[u8], compression: &str, packed: &[u8]) -> Vec<u8> {
    let (unpacked, packed_bytes) = (records.len() as u64, packed.len() as u64);
    let head = [&[0; 16][..], &unpacked.to_le_bytes(), &[0; 4], &text(compression)].concat();
    record(op::CHUNK, &[&head[..], &packed_bytes.to_le_bytes(), packed].concat())
}

/// An LZ4 frame of blocks that are stored as they are.
fn stored_lz4(bytes: &[u8]) -> Vec<u8> {
    // Version 1, blocks of up to 4 MB that do not depend on each other, and the checksum of these two bytes.
    let mut frame = vec![0x04, 0x22, 0x4d, 0x18, 0x60, 0x70, 0x73];
    for block in bytes.chunks(4 << 20) {
        frame.extend((block.len() as u32 | 1 << 31).to_le_bytes());
        frame.extend(block);
    }
    frame.extend([0; 4]);
    frame
}

/// Puts records into a file in one way.
type Pack = fn(&[u8]) -> Vec<u8>;

/// How records may stand in a file.
const PACKINGS: [Pack; 4] = [
    |records| records.to_vec(),
    |records| chunk(records, "", records),
    |records| chunk(records, "lz4", &stored_lz4(records)),
    |records| chunk(records, "zstd", &compress_to_vec(records, CompressionLevel::Fastest)),
];

fn file(records: &[u8]) -> Vec<u8> {
    [MAGIC, &record(op::HEADER, &[text(""), text("")].concat()), records].concat()
}

fn messages(survey: &Survey) -> u64 {
    survey.topics.iter().map(|topic| topic.messages).sum()
}

#[test]
fn names_are_counted_whatever_record_they_come_in_and_however_it_is_packed() {
    let long = |id: u16| format!("{id:03}{}", "A".repeat(LONG_NAME_BYTES));
    let before = [schema(1, "a/msg/B"), channel(1, 1, "/a", "cdr"), message(1)].concat();
    let schemas: Vec<u8> = (2..2 + LONG_NAMES).flat_map(|id| schema(id, &long(id))).collect();
    let topics: Vec<u8> =
        (2..2 + LONG_NAMES).flat_map(|id| [channel(id, 1, &long(id), "cdr"), message(id)].concat()).collect();
    let encodings: Vec<u8> = (2..2 + LONG_NAMES).flat_map(|id| channel(id, 1, "/b", &long(id))).collect();
    for names in [schemas, topics, encodings] {
        for pack in PACKINGS {
            let bytes = file(&[before.clone(), pack(&names)].concat());
            let mut found = None;
            let taken = allocation_counter::measure(|| found = Some(survey([&bytes[..]])));
            let found = found.unwrap();
            assert!(matches!(found.cut_short, Some(RecordsError::Names { .. })), "{:?}", found.cut_short);
            let said = found.cut_short.as_ref().unwrap().to_string();
            assert!(said.contains("16 MB") && said.len() < 500, "{said}");
            assert!(found.topics.iter().any(|topic| topic.name == "/a" && topic.messages == 1));
            assert!(taken.bytes_max < MOST_BYTES, "{} bytes", taken.bytes_max);
        }
    }
}

#[test]
fn names_of_several_files_are_counted_together() {
    let one = |number: u16| {
        let topic = format!("/{number}{}", "A".repeat(LONG_NAME_BYTES));
        file(&[channel(1, 0, &topic, "cdr"), message(1)].concat())
    };
    let files: Vec<Vec<u8>> = (0..LONG_NAMES).map(one).collect();
    let found = survey(files.iter().map(Vec::as_slice));
    assert!(matches!(found.cut_short, Some(RecordsError::Names { .. })), "{:?}", found.cut_short);
    assert_eq!(
        found.topics.len(),
        15,
        "16 MB hold fifteen such names with what else is known of their topics"
    );
}

#[test]
fn a_number_may_be_introduced_again_and_may_not_change_its_meaning() {
    let begin =
        || [schema(1, "a/msg/B"), schema(2, "a/msg/C"), channel(3, 1, "/a", "cdr"), message(3)].concat();
    let again = [begin(), begin()].concat();
    let found = survey([&file(&again)[..]]);
    assert_eq!((messages(&found), found.topics.len()), (2, 1));
    assert!(matches!(found.cut_short, Some(RecordsError::BreaksOff)), "{:?}", found.cut_short);
    for (changed, first, second) in [
        (channel(3, 1, "/b", "cdr"), "\"/a\"", "\"/b\""),
        (channel(3, 2, "/a", "cdr"), "schema 1", "schema 2"),
        (channel(3, 1, "/a", "json"), "\"cdr\"", "\"json\""),
        (schema(1, "a/msg/D"), "a/msg/B", "a/msg/D"),
    ] {
        for pack in PACKINGS {
            let found =
                survey([&file(&[begin(), pack(&[changed.clone(), message(3)].concat())].concat())[..]]);
            assert!(
                matches!(found.cut_short, Some(RecordsError::TwoMeanings { .. })),
                "{:?}",
                found.cut_short
            );
            let said = found.cut_short.as_ref().unwrap().to_string();
            assert!(said.contains(first) && said.contains(second) && said.contains("mcap merge"), "{said}");
            // What came before it counts, and nothing behind it is taken for what it was or is.
            assert_eq!(messages(&found), 1, "{said}");
        }
    }
}

#[test]
fn messages_of_no_channel_are_counted() {
    let records = [message(9), channel(1, 0, "/a", "cdr"), message(1), message(9), message(1)].concat();
    for pack in PACKINGS {
        let found = survey([&file(&pack(&records))[..]]);
        assert_eq!((messages(&found), found.without_channel), (2, 2));
    }
}

#[test]
fn what_is_larger_than_any_record_is_named_and_asks_for_no_memory() {
    const HUGE: u64 = 1 << 40;
    let begun = |opcode: u8| [&[opcode][..], &HUGE.to_le_bytes(), &[0; 100]].concat();
    let kinds = [
        (op::SCHEMA, "schema"),
        (op::CHANNEL, "channel"),
        (op::MESSAGE, "message"),
        (op::ATTACHMENT, "attachment"),
        (op::METADATA, "metadata"),
        (op::MESSAGE_INDEX, "index"),
        (op::CHUNK_INDEX, "index"),
        (0x90, "record"),
    ];
    for (opcode, name) in kinds {
        for pack in PACKINGS {
            let bytes = file(&pack(&begun(opcode)));
            let taken = allocation_counter::measure(|| {
                let said = survey([&bytes[..]]).cut_short.unwrap();
                assert!(matches!(said, RecordsError::TooLarge { .. }), "{said:?}");
                assert!(said.to_string().contains(name) && said.to_string().contains("128 MB"), "{said}");
            });
            assert!(taken.bytes_max < 20_000_000, "{} bytes", taken.bytes_max);
        }
    }
    // A chunk with a checksum is unpacked before anything of it is believed, so the whole of it counts.
    for compression in ["lz4", "zstd"] {
        let sizes =
            [&[0; 16][..], &HUGE.to_le_bytes(), &[1; 4], &text(compression), &8_u64.to_le_bytes()].concat();
        let bytes = file(&record(op::CHUNK, &[&sizes[..], &[0; 8]].concat()));
        let said = survey([&bytes[..]]).cut_short.unwrap();
        assert!(matches!(said, RecordsError::TooLarge { what: "chunk", .. }), "{said:?}");
    }
}
