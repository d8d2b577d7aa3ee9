//! Recordings that a small file makes large: names, numbers that change their meaning, and records beyond every size.

// Functions shared by tests fail their test by panicking.
#![allow(clippy::unwrap_used)]

use fingerpost_io::bag::{Content, Frames, Records, RecordsError, Schema, Survey, Twist, decode, survey};
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

#[test]
fn a_record_that_runs_past_its_chunk_or_the_file_is_refused_and_what_came_before_counts() {
    let begin = [channel(1, 0, "/a", "cdr"), message(1)].concat();
    // A message of 29 bytes behind its head, told of as longer.
    let told_of_as = |bytes: u64| {
        let mut message = message(1);
        message[1..9].copy_from_slice(&bytes.to_le_bytes());
        message
    };
    let behind = message(1);
    let past_chunk = [begin.clone(), told_of_as(30)].concat();
    let to_last_byte_of_file = [begin.clone(), told_of_as(29 + behind.len() as u64)].concat();
    let past_file = [begin.clone(), told_of_as(1_000_000)].concat();
    let part_of_a_head = [begin.clone(), vec![op::MESSAGE, 1, 0]].concat();
    for records in [past_chunk, to_last_byte_of_file, past_file, part_of_a_head] {
        let record_at = MAGIC.len() + 9 + 8 + 9 + 40 + begin.len();
        for (number, pack) in PACKINGS.into_iter().enumerate().skip(1) {
            let found = survey([&file(&[pack(&records), behind.clone()].concat())[..]]);
            let said = found.cut_short.as_ref().unwrap().to_string();
            assert!(matches!(found.cut_short, Some(RecordsError::Damaged { .. })), "{said}");
            assert!(said.contains("mcap recover"), "{said}");
            assert_eq!(
                said.contains(&format!("at byte {record_at} runs past")),
                number == 1,
                "{number}: {said}"
            );
            assert_eq!(messages(&found), 1, "{number}: {said}");
        }
    }
    // Bytes behind a chunk's records are passed over, and what follows the chunk is read.
    let mut padded = chunk(&begin, "", &begin);
    padded.extend([0xFF; 5]);
    let length = padded.len() as u64 - 9;
    padded[1..9].copy_from_slice(&length.to_le_bytes());
    assert_eq!(messages(&survey([&file(&[padded, behind].concat())[..]])), 2);
}

/// A message's header at a time of zero.
fn header(frame_id: &str) -> Vec<u8> {
    let mut cdr = [&[0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0][..], &text(frame_id)].concat();
    cdr.resize(4 + (cdr.len() - 4).next_multiple_of(8), 0);
    cdr
}

/// What is kept of a recording's motion: as `convert` keeps it.
fn kept_motion(bytes: &[u8]) -> (Frames, Vec<Twist>, u64) {
    let (mut frames, mut twists, mut refused) = (Frames::default(), Vec::new(), 0);
    for record in Records::new(bytes).map_while(Result::ok) {
        let schema = Schema::named(&record.schema).unwrap();
        let kept = match decode(schema, &record.data).map(|message| message.content) {
            Ok(Content::Twist(twist)) => frames.shared_name(&twist.frame_id).map(|frame_id| {
                twists.push(Twist { frame_id, ..twist });
            }),
            Ok(Content::Transforms(transforms)) => frames.add(transforms),
            Ok(_) => Ok(()),
            Err(_) => {
                refused += 1;
                continue;
            }
        };
        refused += u64::from(kept.is_err());
    }
    (frames, twists, refused)
}

#[test]
fn frames_are_named_in_bounded_memory_however_many_and_long_their_names_are() {
    let begin = [
        schema(1, Schema::RosTwistStamped.name()),
        schema(2, Schema::RosTransforms.name()),
        channel(1, 1, "/twist", "cdr"),
        channel(2, 2, "/tf_static", "cdr"),
    ]
    .concat();
    let of_channel = |channel: u16, data: &[u8]| {
        record(op::MESSAGE, &[&channel.to_le_bytes()[..], &[0; 20], data].concat())
    };
    let twist = |frame_id: &str| of_channel(1, &[header(frame_id), vec![0; 48]].concat());
    // One that turns nothing: a quaternion's last number is one.
    let transform = |parent: &str, child: &str| {
        let mut cdr = [&[0, 1, 0, 0, 1, 0, 0, 0][..], &header(parent)[4..]].concat();
        cdr.extend(text(child));
        cdr.resize(4 + (cdr.len() - 4).next_multiple_of(8), 0);
        cdr.extend([0; 48]);
        cdr.extend(1.0_f64.to_le_bytes());
        of_channel(2, &cdr)
    };
    let long = |i: u32| format!("{i:06}{}", "A".repeat(LONG_NAME_BYTES));
    let longest = |i: u32| format!("{i:06}{}", "A".repeat(249));
    let all: [(Vec<u8>, u64, usize); 4] = [
        ((0..40).flat_map(|i| twist(&long(i))).collect(), 40, 0),
        ((0..40).flat_map(|i| transform("base_link", &long(i))).collect(), 40, 0),
        ((0..70_000).flat_map(|i| twist(&longest(i))).collect(), 70_000 - 65_536, 65_536),
        ((0..70_000).flat_map(|_| twist(&longest(7))).collect(), 0, 70_000),
    ];
    for (messages, expected_refused, expected_twists) in all {
        let bytes = file(
            &[
                begin.clone(),
                chunk(&messages, "zstd", &compress_to_vec(&messages[..], CompressionLevel::Fastest)),
            ]
            .concat(),
        );
        let unpacked_bytes = messages.len() as u64;
        let mut found = None;
        let taken = allocation_counter::measure(|| found = Some(kept_motion(&bytes)));
        let (_frames, twists, refused) = found.unwrap();
        assert_eq!((refused, twists.len()), (expected_refused, expected_twists));
        // Beside the chunk, packed and unpacked, and the decoder's window: what is kept of messages and names.
        let kept_bytes = 3 * 80 * twists.len() as u64 + 65_536 * 400;
        let most_bytes = 4 * unpacked_bytes + kept_bytes;
        assert!(taken.bytes_max < most_bytes.min(MOST_BYTES), "{} bytes", taken.bytes_max);
        assert!((taken.bytes_current.unsigned_abs()) < kept_bytes, "{} bytes", taken.bytes_current);
    }
}

#[test]
fn a_message_of_more_transforms_than_frames_is_refused_before_any_is_read() {
    for count in [65_537_u32, 1 << 20, u32::MAX] {
        let mut cdr = [&[0, 1, 0, 0][..], &count.to_le_bytes()].concat();
        cdr.resize(100 << 20, 0);
        let taken = allocation_counter::measure(|| {
            let said = decode(Schema::RosTransforms, &cdr).unwrap_err().to_string();
            assert!(said.contains(&count.to_string()) && said.contains("65536"), "{said}");
        });
        assert!(taken.bytes_max < 1000, "{} bytes", taken.bytes_max);
    }
}
