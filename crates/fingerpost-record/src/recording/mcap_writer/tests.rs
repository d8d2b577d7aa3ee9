use std::io::{self, SeekFrom};
use std::sync::{Arc, Mutex};

use fingerpost_format::{FrameRecord, from_json_lines};
use mcap::MessageStream;
use mcap::read::Options;

use super::*;
use crate::recording::MessageEncoder;

/// Bytes as a disk has them when the program is killed.
#[derive(Debug, Clone, Default)]
struct Disk(Arc<Mutex<Vec<u8>>>);

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Disk {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let length = self.0.lock().unwrap().len() as u64;
        match to {
            SeekFrom::Current(0) | SeekFrom::End(0) => Ok(length),
            _ => Err(io::Error::other("a recording is written from its beginning to its end")),
        }
    }
}

fn record(frame: u64, t_s: f64) -> FrameRecord {
    let line = format!(
        r#"{{"frame":{frame},"t_s":{t_s},"state":"searching","driving_line_m":[],"stage_ms":{{}},"why":"nothing is in reach"}}"#
    );
    from_json_lines(&line).unwrap().remove(0)
}

/// Time of the last record that a reader finds in bytes that may break off anywhere, seconds.
fn last_record_s(bytes: &[u8]) -> Option<f64> {
    let stream = MessageStream::new_with_options(bytes, Options::IgnoreEndMagic.into()).unwrap();
    let whole = stream.map_while(Result::ok).filter(|message| message.channel.topic == "/record");
    whole.last().map(|message| message.log_time as f64 / 1e9)
}

#[test]
fn a_recording_that_breaks_off_reads_back_to_within_a_second() {
    let disk = Disk::default();
    let mut recording = Recording::create(disk.clone(), "test", None).unwrap();
    let mut encoder = MessageEncoder::default();
    for frame in 0..200 {
        let t_s = frame as f64 / 10.0;
        recording.write(&encoder.record(&record(frame, t_s)).unwrap()).unwrap();
        let bytes = disk.0.lock().unwrap().clone();
        let kept_s = last_record_s(&bytes).unwrap_or(-0.1);
        assert!(t_s - kept_s <= 0.6, "at {t_s} s only {kept_s} s are kept");
        // The disk may hold any part of what was written last.
        if frame == 100 {
            for cut in 1..400 {
                assert!(last_record_s(&bytes[..bytes.len() - cut]).unwrap() >= t_s - 1.3);
            }
        }
    }
    recording.finish().unwrap();
    let bytes = disk.0.lock().unwrap().clone();
    assert_eq!(last_record_s(&bytes), Some(19.9));
    let summary = mcap::Summary::read(&bytes).unwrap().expect("a finished recording has a summary");
    let statistics = summary.stats.unwrap();
    // A record a frame, and the state once.
    assert_eq!((statistics.message_count, statistics.channel_count), (201, Channel::ALL.len() as u32));
}

#[test]
fn the_same_frames_give_the_same_bytes() {
    let made = || {
        let mut recording = Recording::create(Disk::default(), "test", None).unwrap();
        let mut encoder = MessageEncoder::default();
        for frame in 0..30 {
            recording.write(&encoder.record(&record(frame, frame as f64 / 7.0)).unwrap()).unwrap();
        }
        let disk = recording.finish().unwrap();
        disk.0.lock().unwrap().clone()
    };
    assert_eq!(made(), made());
}

#[test]
fn times_that_step_back_or_are_none_are_recorded() {
    let mut recording = Recording::create(Disk::default(), "test", None).unwrap();
    let mut encoder = MessageEncoder::default();
    for (frame, t_s) in [(0, 5.0), (1, 0.0), (2, -3.0), (3, 1e12), (4, 0.1)] {
        recording.write(&encoder.record(&record(frame, t_s)).unwrap()).unwrap();
    }
    let disk = recording.finish().unwrap();
    let bytes = disk.0.lock().unwrap().clone();
    let read = MessageStream::new(&bytes).unwrap().map(|message| message.unwrap().sequence);
    assert_eq!(read.filter(|sequence| *sequence == 4).count(), 1);
}

#[test]
fn a_full_disk_is_an_error_and_no_panic() {
    #[derive(Debug)]
    struct Full(u64);
    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 += bytes.len() as u64;
            if self.0 > 40_000 { Err(io::Error::other("no space left")) } else { Ok(bytes.len()) }
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    impl Seek for Full {
        fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
            Ok(self.0)
        }
    }
    let mut recording = Recording::create(Full(0), "test", None).unwrap();
    let mut encoder = MessageEncoder::default();
    let failure = (0..100_000)
        .find_map(|frame| recording.write(&encoder.record(&record(frame, frame as f64)).unwrap()).err());
    let message = failure.unwrap().to_string();
    assert!(message.contains("no space left"), "{message}");
}
