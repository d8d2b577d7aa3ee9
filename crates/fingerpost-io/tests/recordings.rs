//! Whole recordings: written with the MCAP writer, read back, cut short and spoilt.

// Functions shared by tests fail their test by panicking.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::io::Cursor;

use fingerpost_io::bag::{
    Choice, Content, Frames, Inertial, Picture, Records, RecordsError, Role, Schema, Twist, Wanted, decode,
    survey,
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

/// A message of CDR: texts and numbers in their order, each at a multiple of its size.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    fn number<const N: usize>(mut self, bytes: [u8; N]) -> Self {
        self.0.resize(4 + (self.0.len() - 4).next_multiple_of(N), 0);
        self.0.extend(bytes);
        self
    }

    fn text(self, text: &str) -> Self {
        let mut with_length = self.number((text.len() as u32 + 1).to_le_bytes());
        with_length.0.extend(text.bytes().chain([0]));
        with_length
    }

    fn doubles(self, values: &[f64]) -> Self {
        values.iter().fold(self, |cdr, value| cdr.number(value.to_le_bytes()))
    }

    fn header(self, frame_id: &str) -> Self {
        self.number(5_i32.to_le_bytes()).number(0_u32.to_le_bytes()).text(frame_id)
    }
}

#[test]
fn messages_that_were_packed_one_by_one_are_unpacked() {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    let message = image(3);
    let packed = compress_to_vec(message.as_slice(), CompressionLevel::Fastest);
    assert_eq!(decode(Schema::RosImage, &packed), decode(Schema::RosImage, &message));
    for cut in 0..packed.len() {
        assert!(decode(Schema::RosImage, &packed[..cut]).is_err(), "{cut}");
    }
    // In several frames, with one between that is skipped, and one whose end is missing or is followed by what is no frame.
    let (first, second) = message.split_at(20);
    let [first, second] = [first, second].map(|part| compress_to_vec(part, CompressionLevel::Fastest));
    let skipped = [0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 9, 9, 9];
    for frames in [
        vec![&first[..], &second],
        vec![&first, &skipped, &second],
        vec![&skipped, &first, &second, &skipped],
    ] {
        assert_eq!(decode(Schema::RosImage, &frames.concat()), decode(Schema::RosImage, &message));
        let ends: Vec<usize> = (0..=frames.len()).map(|count| frames[..count].concat().len()).collect();
        for cut in (1..frames.concat().len()).filter(|cut| !ends.contains(cut)) {
            assert!(decode(Schema::RosImage, &frames.concat()[..cut]).is_err(), "{cut}");
        }
        let cause = decode(Schema::RosImage, &[frames.concat(), b"and what is no frame".to_vec()].concat());
        assert!(cause.unwrap_err().to_string().contains("ros2 bag convert"));
    }
    let cause = decode(Schema::RosImage, &packed[..8]).unwrap_err().to_string();
    assert!(cause.contains("Zstandard") && cause.contains("ros2 bag convert"), "{cause}");
    // A few thousand bytes that stand for more than any record has.
    let much = compress_to_vec(vec![0_u8; (128 << 20) + 1].as_slice(), CompressionLevel::Fastest);
    let cause = decode(Schema::RosImage, &much).unwrap_err().to_string();
    assert!(cause.contains("more than"), "{cause}");
}

#[test]
fn motion_is_read_with_its_frame() {
    let unit = |turn_known: f64, acceleration_known: f64| {
        let [turn, acceleration] = [turn_known, acceleration_known].map(|first| {
            let mut covariance = [0.0; 9];
            covariance[0] = first;
            covariance
        });
        let cdr =
            Cdr::new().header("imu_optical").doubles(&[0.0; 13]).doubles(&[0.1, -0.2, 0.3]).doubles(&turn);
        let cdr = cdr.doubles(&[1.0, -9.8, 2.0]).doubles(&acceleration);
        decode(Schema::RosImu, &cdr.0).unwrap().content
    };
    let measured = |acceleration_mps2| {
        let frame_id = "imu_optical".into();
        Content::Inertial(Some(Inertial { frame_id, angular_rps: [0.1, -0.2, 0.3], acceleration_mps2 }))
    };
    assert_eq!(unit(0.0, 0.01), measured(Some([1.0, -9.8, 2.0])));
    assert_eq!(unit(0.0, -1.0), measured(None));
    assert_eq!(unit(-1.0, 0.0), Content::Inertial(None));

    let moves = [8.0, 0.1, 0.2, 0.3, 0.4, 0.5];
    let twist = Cdr::new().header("base_link").doubles(&moves);
    let odometry = Cdr::new().header("odom").text("base_link").doubles(&[0.0; 43]).doubles(&moves);
    for (schema, cdr) in [(Schema::RosTwistStamped, twist), (Schema::RosOdometry, odometry)] {
        let (frame_id, linear_mps) = ("base_link".into(), [8.0, 0.1, 0.2]);
        let expected = Content::Twist(Twist { frame_id, linear_mps, angular_rps: [0.3, 0.4, 0.5] });
        assert_eq!(decode(schema, &cdr.0).unwrap().content, expected, "{schema:?}");
    }
}

#[test]
fn static_transforms_turn_what_a_sensor_measures() {
    // The unit stands on its left side: its z points to the vehicle's right, its y up.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let cdr = Cdr::new().number(1_u32.to_le_bytes()).header("base_link").text("imu");
    let cdr = cdr.doubles(&[1.0, 2.0, 3.0]).doubles(&[half, 0.0, 0.0, half]);
    let Content::Transforms(transforms) = decode(Schema::RosTransforms, &cdr.0).unwrap().content else {
        panic!("transforms were expected")
    };
    let mut frames = Frames::default();
    frames.add(transforms).unwrap();
    let [forward, left, up] = frames.axes("imu").in_vehicle([0.0, 0.3, 0.1]);
    assert!(forward.abs() < 1e-12 && (left + 0.1).abs() < 1e-12 && (up - 0.3).abs() < 1e-12);
    // A count beyond the message's end asks for no memory.
    assert!(decode(Schema::RosTransforms, &Cdr::new().number(u32::MAX.to_le_bytes()).0).is_err());
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
