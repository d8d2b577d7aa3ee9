//! Logs and databases of the vehicle's bus.

use std::io::Write;

use fingerpost_io::{CanDatabase, CanFrame, CanId, FedFrame, FrameFeed, SignalLog, read_can_log};

use crate::{file, must};

const CAR: &[u8] = include_bytes!("../../fingerpost-sim/src/bus/car.dbc");
const SIGNALS: &[u8] = include_bytes!("../../fingerpost-io/tests/can/signals.dbc");
/// Signals of the two databases above: plain, multiplexed, backwards and wide; and one of neither.
const NAMES: [&str; 6] =
    ["MOTION.SPEED", "LEVERS.TURN_SIGNAL", "BODY.DOOR", "WIDE_BACKWARDS.ALL", "WHEELS.FRONT_LEFT", "NO.SUCH"];

/// A log's times are finite, and its signals are read in the order of time.
pub(crate) fn can_log(bytes: &[u8]) -> bool {
    let log = file(bytes, ".log");
    if let Ok(mut frames) = read_can_log(log.path()) {
        while let Ok(Some(frame)) = frames.next_frame() {
            assert!(frame.t_s.is_finite());
        }
    }
    let database = must(CanDatabase::read(file(CAR, ".dbc").path()), "a seed");
    let speed = must(database.signal("MOTION.SPEED"), "a seed");
    let Ok(log) = SignalLog::read(log.path(), None, &[speed]) else { return false };
    assert!(log.samples[0].is_sorted_by(|a, b| a.t_s <= b.t_s));
    assert!(log.samples[0].iter().all(|sample| sample.value.is_finite()));
    true
}

/// [`can_log`] on the packed bytes, and on them packed and cut short.
pub(crate) fn can_log_gzip(bytes: &[u8]) -> bool {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    must(packer.write_all(bytes), "packing");
    let mut packed = must(packer.finish(), "packing");
    let accepted = can_log(&packed);
    packed.truncate(packed.len() / 2);
    can_log(&packed);
    accepted
}

pub(crate) fn can_log_seeds() -> Vec<Vec<u8>> {
    let log = "(1700000000.000000) can0 1A1#E8030A00 R\n(1700000000.020000) can0 1A1#D0070000\n\
               (1700000000.030000) vcan1 316#01\n(1700000000.040000) can0 18FEF100##1112233445566778899AABBCC T\n\
               (1700000000.050000) can0 123#R8\n";
    vec![log.as_bytes().to_vec()]
}

/// A signal of any database decodes frames of any length.
pub(crate) fn can_database(bytes: &[u8]) -> bool {
    let Ok(database) = CanDatabase::read(file(bytes, ".dbc").path()) else { return false };
    for signal in NAMES.iter().filter_map(|name| database.signal(name).ok()) {
        for data in [&[][..], &[0xff; 1], &[0xa5; 8], &[0xff; 64]] {
            for id in [signal.message, CanId::Standard(0)] {
                if let Some(frame) = CanFrame::new(id, data) {
                    signal.decode(&frame);
                }
            }
        }
        signal.value_named("left");
    }
    true
}

pub(crate) fn can_database_seeds() -> Vec<Vec<u8>> {
    vec![CAR.to_vec(), SIGNALS.to_vec()]
}

/// Of frames in lockstep, whatever comes: an answer to each, each good one of finite numbers, and an end.
pub(crate) fn fed_frames(bytes: &[u8]) -> bool {
    let mut feed = FrameFeed::new(bytes, [8, 4]);
    let (mut good, mut answers) = (0, 0);
    loop {
        match must(feed.next_frame(), "bytes in memory") {
            FedFrame::Good(header, picture) => {
                assert!(header.t_s.is_finite() && header.size_px == [8, 4] && picture.size() == (8, 4));
                good += 1;
            }
            FedFrame::Bad(_) => {}
            FedFrame::End => return good > 0,
        }
        answers += 1;
        assert!(answers <= bytes.len(), "more answers than bytes");
    }
}

pub(crate) fn fed_frames_seeds() -> Vec<Vec<u8>> {
    let header = br#"{"t_s": 0.5, "width": 8, "height": 4, "speed_mps": 6.5, "yaw_rate_rps": -0.1, "lat": 47.2, "lon": 9.5}"#;
    let frame = [&header[..], b"\n", &[120; 96]].concat();
    vec![[frame.clone(), frame.clone(), frame].concat()]
}
