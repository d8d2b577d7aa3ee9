//! Others' recordings.

use std::collections::BTreeMap;
use std::io::Cursor;

use fingerpost_io::bag::{Choice, Content, Picture, Records, Schema, Wanted, decode, survey};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

use crate::must;

/// A recording's messages are read or refused; sizes of pictures are those of their pixels.
pub(crate) fn bag(bytes: &[u8]) -> bool {
    let found = survey([bytes]);
    let chosen = Choice::of(&found.topics, &Wanted::default());
    for record in Records::new(bytes).map_while(Result::ok) {
        let Some(schema) = Schema::named(&record.schema) else { continue };
        message_of(schema, &record.data);
    }
    chosen.is_ok() && found.cut_short.is_none()
}

/// The first byte says which message the others are taken for.
pub(crate) fn message(bytes: &[u8]) -> bool {
    let Some((first, data)) = bytes.split_first() else { return false };
    Schema::ALL.get(usize::from(*first)).is_some_and(|schema| message_of(*schema, data))
}

fn message_of(schema: Schema, data: &[u8]) -> bool {
    let Ok(message) = decode(schema, data) else { return false };
    if let Content::Picture(Picture::Raw(picture)) = &message.content {
        let (width, height) = picture.size();
        assert_eq!(3 * width * height, picture.as_slice().len());
    }
    true
}

/// A message of every ROS schema: zeros, which are empty texts and sequences, but for a picture's size.
fn plain(schema: Schema) -> Vec<u8> {
    let mut cdr = vec![0, 1, 0, 0];
    match schema {
        Schema::RosImage => {
            cdr.extend([1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
            // One row of two pixels.
            cdr.extend([1, 0, 0, 0, 2, 0, 0, 0, 5, 0, 0, 0]);
            cdr.extend(b"rgb8\0");
            cdr.extend([0, 0, 0, 6, 0, 0, 0, 6, 0, 0, 0, 1, 2, 3, 4, 5, 6]);
        }
        Schema::RosCompressedImage => {
            cdr.extend([1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]);
            cdr.extend([4, 0, 0, 0]);
            cdr.extend(b"png\0");
            cdr.extend([4, 0, 0, 0, 0x89]);
            cdr.extend(b"PNG");
        }
        _ => cdr.extend([0; 800]),
    }
    cdr
}

fn ros() -> impl Iterator<Item = (usize, Schema)> {
    Schema::ALL.into_iter().enumerate().filter(|(_, schema)| schema.encoding() == "cdr")
}

pub(crate) fn message_seeds() -> Vec<Vec<u8>> {
    let mut seeds: Vec<Vec<u8>> =
        ros().map(|(index, schema)| [&[index as u8][..], &plain(schema)].concat()).collect();
    // foxglove.LocationFix without a field is one at zero degrees; a CompressedImage has its data in field 2.
    seeds.extend(
        Schema::ALL.iter().position(|schema| *schema == Schema::FoxgloveLocationFix).map(|i| vec![i as u8]),
    );
    let packed = Schema::ALL.iter().position(|schema| *schema == Schema::FoxgloveCompressedImage);
    seeds.extend(
        packed.map(|i| vec![i as u8, 0x12, 4, 0xFF, 0xD8, 0xFF, 0xD9, 0x1A, 4, b'j', b'p', b'e', b'g']),
    );
    seeds.extend(
        ros().filter_map(|(index, schema)| Some([vec![index as u8], in_zstd(&plain(schema))?].concat())),
    );
    seeds
}

/// A message as rosbag2 packs one by itself: a frame of Zstandard with one stored block. None of those that are too long for it.
fn in_zstd(message: &[u8]) -> Option<Vec<u8>> {
    let length = u8::try_from(message.len()).ok()?;
    // One segment, whose length takes a byte; the last block, stored, with its length.
    let [low, middle, high, _] = (u32::from(length) << 3 | 1).to_le_bytes();
    Some([&[0x28, 0xB5, 0x2F, 0xFD, 0x20, length, low, middle, high], message].concat())
}

pub(crate) fn bag_seeds() -> Vec<Vec<u8>> {
    let options = || WriteOptions::new().chunk_size(Some(400));
    let compressions = [None, Some(Compression::Lz4), Some(Compression::Zstd)];
    let mut seeds: Vec<_> =
        compressions.into_iter().map(|compression| written(options().compression(compression))).collect();
    // Where no checksum is told, changes within a chunk come as far as the reader of its records.
    seeds.push(written(options().compression(None).calculate_chunk_crcs(false)));
    seeds
}

fn written(options: WriteOptions) -> Vec<u8> {
    let mut writer = must(options.create(Cursor::new(Vec::new())), "a seed");
    for (index, schema) in ros().filter(|(_, schema)| *schema != Schema::RosCompressedImage) {
        let schema_id = must(writer.add_schema(schema.name(), "ros2msg", b""), "a seed");
        let topic = format!("/topic_{index}");
        let channel_id = must(writer.add_channel(schema_id, &topic, "cdr", &BTreeMap::new()), "a seed");
        // Of topics that could stand for each other one alone has messages.
        let is_sole = !matches!(
            schema,
            Schema::RosTwist | Schema::RosTwistStamped | Schema::RosTwistWithCovarianceStamped
        );
        for time in (0..3).filter(|_| is_sole) {
            let header = MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
            must(writer.write_to_known_channel(&header, &plain(schema)), "a seed");
        }
    }
    must(writer.finish(), "a seed");
    writer.into_inner().into_inner()
}
