//! Whole recordings: written with the MCAP writer, read back, cut short and spoilt.

// Functions shared by tests fail their test by panicking.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::io::Cursor;

use fingerpost_io::bag::{
    Choice, Content, Picture, Records, RecordsError, Role, Schema, Wanted, decode, survey,
};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};

const FRAMES: u64 = 12;

/// A `sensor_msgs/msg/Image` of 2 x 1 pixels in CDR, stamped at `seconds`.
fn image(seconds: i32) -> Vec<u8> {
    let mut cdr = vec![0, 1, 0, 0];
    cdr.extend(seconds.to_le_bytes());
    cdr.extend(500_u32.to_le_bytes());
    cdr.extend([4, 0, 0, 0]);
    cdr.extend(b"cam\0");
    cdr.extend(1_u32.to_le_bytes());
    cdr.extend(2_u32.to_le_bytes());
    cdr.extend([5, 0, 0, 0]);
    cdr.extend(b"rgb8\0");
    // The order of bytes, then padding to a multiple of four.
    cdr.extend([0, 0, 0]);
    cdr.extend(6_u32.to_le_bytes());
    cdr.extend(6_u32.to_le_bytes());
    cdr.extend([1, 2, 3, 4, 5, seconds as u8]);
    cdr
}

fn bag(compression: Option<Compression>) -> Vec<u8> {
    let options = WriteOptions::new().compression(compression).chunk_size(Some(300));
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema(Schema::RosImage.name(), "ros2msg", b"").unwrap();
    let channel = writer.add_channel(schema, "/camera", "cdr", &BTreeMap::new()).unwrap();
    for i in 0..FRAMES {
        let time = i * 1_000_000_000 + 7;
        let header =
            MessageHeader { channel_id: channel, sequence: i as u32, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, &image(i as i32 + 1)).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// Pixels and stamps of all pictures that can be read.
fn pictures(bytes: &[u8]) -> Vec<(u64, Vec<u8>)> {
    let records = Records::new(bytes).map_while(Result::ok);
    let messages = records.filter_map(|record| decode(Schema::named(&record.schema)?, &record.data).ok());
    messages
        .filter_map(|message| match message.content {
            Content::Picture(Picture::Raw(picture)) => {
                Some((message.stamp_ns.unwrap_or_default(), picture.as_slice().to_vec()))
            }
            _ => None,
        })
        .collect()
}

#[test]
fn every_compression_gives_the_same_pictures() {
    let expected: Vec<_> = (1..=FRAMES)
        .map(|second| (second * 1_000_000_000 + 500, vec![1, 2, 3, 4, 5, second as u8]))
        .collect();
    for compression in [None, Some(Compression::Lz4), Some(Compression::Zstd)] {
        assert_eq!(pictures(&bag(compression)), expected, "{compression:?}");
    }
}

#[test]
fn a_recording_without_its_end_reads_as_far_as_it_goes() {
    let whole = bag(Some(Compression::Lz4));
    let all = pictures(&whole);
    let mut counts = Vec::new();
    for length in 0..whole.len() {
        let cut = &whole[..length];
        let survey = survey([cut]);
        let read = pictures(cut);
        assert_eq!(read, all[..read.len()], "cut at {length}");
        assert_eq!(survey.topics.iter().map(|topic| topic.messages).sum::<u64>(), read.len() as u64);
        if read.len() < all.len() {
            assert!(matches!(survey.cut_short, Some(RecordsError::BreaksOff)), "{length}: {survey:?}");
        }
        counts.push(read.len());
    }
    assert!(counts.is_sorted() && counts.last() == Some(&all.len()), "{counts:?}");
    counts.dedup();
    assert!(counts.len() > 3, "{counts:?}");
}

#[test]
fn several_files_are_one_recording() {
    let survey = survey([&bag(None)[..], &bag(Some(Compression::Zstd))[..]]);
    assert!(survey.cut_short.is_none());
    let choice = Choice::of(&survey.topics, &Wanted::default()).unwrap();
    assert_eq!((survey.topics[0].messages, choice.topic(Role::Pictures)), (2 * FRAMES, Some("/camera")));
}

#[test]
fn what_is_no_recording_is_said() {
    let survey = survey([&b"OggS and so on, long enough to be more than a beginning"[..]]);
    assert!(survey.topics.is_empty());
    assert!(matches!(survey.cut_short, Some(RecordsError::Damaged { .. })), "{survey:?}");
}

#[test]
fn no_changed_bit_gives_a_wrong_picture_in_a_checked_chunk() {
    let whole = bag(Some(Compression::Zstd));
    let all = pictures(&whole);
    for bit in 0..8 * whole.len() {
        let mut changed = whole.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        for picture in pictures(&changed) {
            // The chunk's checksum covers pictures; lengths and names outside it may hide some of them.
            assert!(all.contains(&picture), "bit {bit}: {picture:?}");
        }
    }
}
