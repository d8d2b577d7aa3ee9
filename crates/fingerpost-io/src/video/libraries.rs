//! Videos decoded in this process by FFmpeg's libraries, without pipes, their line protocol and the time that programs take
//! to start.
//!
//! What is read here: files whose pixels are of the commonest way (8 bits, 4:2:0), stand upright, whose number of frames
//! is stated, and whose frames have stamps that do not begin anew in the middle, as those of transport streams may. A thread decodes ahead, and turns the decoder's planes into red, green and blue where they lie. Sizes, rates
//! and colours are taken from the stream as ffprobe takes them, frames as ffmpeg gives them.
//!
//! At the first sign that something is wrong the work is given up, and the program ffmpeg goes on behind the last good
//! frame: what is damaged, cut or changes half-way is judged in one place alone, by all that ffmpeg says of it.

use std::{io::ErrorKind, num::NonZeroUsize};

use ffmpeg_the_third::{
    Error as AvError, Packet, Rational, Rescale,
    codec::{Context, decoder, packet::side_data},
    color::{Range, Space},
    dictionary::Dictionary,
    format::{self, Pixel, context::Input},
    frame, log, media,
};
use fingerpost_vision::{
    colour::{Yuv420, YuvCoding, rgb_from_yuv420},
    picture::{PlaneView, RgbImage},
};

use super::{
    Timing, VideoPicture, ffmpeg_argument,
    probe::{self, Expected, Rate},
};
use crate::{
    decoders::{Decode, Decoded, Decoders},
    picture_file::MAX_SIDE_PX,
};

/// What times are counted in.
const MICROSECOND: Rational = Rational(1, 1_000_000);

/// A video being decoded here.
#[derive(Debug)]
pub(crate) struct LibraryVideo {
    rate: Rate,
    timing: Timing,
    length: Option<u64>,
    expected: Expected,
    frames: u64,
    pictures: Decoders<Stream>,
}

/// What comes next.
pub(super) enum Next {
    /// A picture.
    Picture(Decoded<VideoPicture>),
    /// Nothing: all has been read.
    End,
    /// Nothing from here; ffmpeg is to go on behind so many frames.
    GivenUp { frames: u64 },
}

/// Why the libraries do not go on.
#[derive(Debug)]
pub(super) struct GivenUp;

impl From<AvError> for GivenUp {
    fn from(_: AvError) -> Self {
        Self
    }
}

impl LibraryVideo {
    /// Begins to read the file `input`; none where ffmpeg has to. Threads as of [`super::VideoReader::open`].
    pub(super) fn open(input: &str, threads: Option<NonZeroUsize>) -> Option<Self> {
        let (stream, stated) = Stream::open(&ffmpeg_argument(input), threads).ok()?;
        let (rate, length, expected) = (stated.rate(), stated.length(), stated.expected_length());
        // What has no stamps is asked more about than can be asked here.
        let timing = Some(stated.timing()).filter(|timing| matches!(timing, Timing::Stamps { .. }))?;
        if expected == Expected::Unknown {
            return None;
        }
        let one = threads == Some(NonZeroUsize::MIN);
        let pictures = if one { Decoders::on_demand(stream) } else { Decoders::ahead([stream]) };
        Some(Self { rate, timing, length, expected, frames: 0, pictures })
    }

    pub(super) fn length(&self) -> Option<u64> {
        self.length
    }

    pub(super) fn expected_length(&self) -> Option<u64> {
        self.expected.frames()
    }

    pub(super) fn fps(&self) -> f64 {
        self.rate.fps()
    }

    pub(super) fn next_picture(&mut self) -> Next {
        match self.pictures.next() {
            Some(Decoded { picture: Ok(picture), decoding }) => {
                self.frames = picture.index + 1;
                Next::Picture(Decoded { picture, decoding })
            }
            None if !self.expected.is_short(self.frames) => Next::End,
            None | Some(Decoded { picture: Err(GivenUp), .. }) => Next::GivenUp { frames: self.frames },
        }
    }

    pub(super) fn timing(&self) -> Timing {
        self.timing
    }

    pub(super) fn recycle(&mut self, buffer: Vec<u8>) {
        self.pictures.recycle(buffer);
    }
}

/// The stream of moving pictures in a file, and its decoder.
struct Stream {
    input: Input,
    /// Its index in the file.
    index: usize,
    decoder: decoder::Video,
    packet: Packet,
    frame: frame::Video,
    coding: YuvCoding,
    /// What the stamps of frames count, seconds.
    tick: Rational,
    first_stamp: Option<i64>,
    /// Pixels and size of the first frame, which all are to have.
    form: Option<(Pixel, u32, u32)>,
    frames: u64,
}

impl std::fmt::Debug for Stream {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Stream")
            .field("index", &self.index)
            .field("frames", &self.frames)
            .finish_non_exhaustive()
    }
}

impl Stream {
    /// Opens the first stream of moving pictures, with what is stated of it.
    fn open(argument: &str, threads: Option<NonZeroUsize>) -> Result<(Self, probe::Stream), GivenUp> {
        // A library prints nothing; what is wrong with a video ffmpeg is asked.
        log::set_level(log::Level::Quiet);
        let input = format::input(argument)?;
        // Their stamps begin anew in the middle; ffmpeg knows where they go on.
        if input.format().flags().contains(format::format::Flags::TS_DISCONT) {
            return Err(GivenUp);
        }
        let stream = input.streams().find(|stream| stream.parameters().medium() == media::Type::Video);
        let stream = stream.ok_or(GivenUp)?;
        let stands_upright = stream.side_data().all(|data| data.kind() != side_data::Type::DisplayMatrix);
        let mut context = Context::from_parameters(stream.parameters())?.decoder();
        // What is wrong with a frame is an error, and not only a mark that ffmpeg would look at.
        context.check(decoder::Check::EXPLODE);
        let codec = decoder::find(context.id()).ok_or(GivenUp)?;
        let mut options = Dictionary::new();
        options.set("threads", threads.map_or_else(|| "auto".to_owned(), |threads| threads.to_string()));
        let decoder = context.open_as_with(codec, options)?.video()?;
        let stated = stated(&input, &stream, &decoder);
        let (_, coding) = stated.yuv420_coding().filter(|_| stands_upright).ok_or(GivenUp)?;
        let (index, tick) = (stream.index(), stream.time_base());
        let (packet, frame) = (Packet::empty(), frame::Video::empty());
        let first_stamp = None;
        let stream =
            Self { input, index, decoder, packet, frame, coding, tick, first_stamp, form: None, frames: 0 };
        Ok((stream, stated))
    }

    /// Hands the decoder what comes next of the stream, or tells it that nothing does.
    fn feed(&mut self) -> Result<(), GivenUp> {
        loop {
            match self.packet.read(&mut self.input) {
                Ok(()) if self.packet.is_corrupt() => return Err(GivenUp),
                Ok(()) if self.packet.stream() == self.index => {
                    return Ok(self.decoder.send_packet(&self.packet)?);
                }
                Ok(()) => {}
                Err(AvError::Eof) => return Ok(self.decoder.send_eof()?),
                Err(_) => return Err(GivenUp),
            }
        }
    }

    /// The frame that the decoder has given, in colours.
    fn picture(&mut self, mut rgb: Vec<u8>) -> Result<VideoPicture, GivenUp> {
        let frame = &self.frame;
        let form = (frame.format(), frame.width(), frame.height());
        let (_, width, height) = form;
        let (width, height) = (width as usize, height as usize);
        let sides = 1..=MAX_SIDE_PX;
        let is_known = matches!(form.0, Pixel::YUV420P | Pixel::YUVJ420P) && frame.planes() >= 3;
        let is_same = *self.form.get_or_insert(form) == form;
        if frame.is_corrupt() || !is_known || !is_same || !sides.contains(&width) || !sides.contains(&height)
        {
            return Err(GivenUp);
        }
        let plane = |plane: usize| {
            let (width, height) =
                if plane == 0 { (width, height) } else { (width.div_ceil(2), height.div_ceil(2)) };
            let stride = frame.stride(plane);
            // Rows that follow each other upwards have a negative one.
            if i32::try_from(stride).is_err() {
                return Err(GivenUp);
            }
            PlaneView::new(frame.data(plane), width, height, stride).map_err(|_| GivenUp)
        };
        let planes = Yuv420 { y: plane(0)?, u: plane(1)?, v: plane(2)? };
        rgb.resize(width * height * RgbImage::CHANNELS, 0);
        let mut picture = RgbImage::from_vec(width, height, rgb).map_err(|_| GivenUp)?;
        rgb_from_yuv420(planes, self.coding, &mut picture).map_err(|_| GivenUp)?;
        let stamp_us = self.frame.timestamp().map(|stamp| {
            let first = *self.first_stamp.get_or_insert(stamp);
            stamp.saturating_sub(first).rescale(self.tick, MICROSECOND)
        });
        let index = self.frames;
        self.frames += 1;
        Ok(VideoPicture { picture, index, damaged: false, taken_s: None, stamp_us })
    }
}

impl Decode for Stream {
    type Picture = Result<VideoPicture, GivenUp>;

    fn decode(&mut self, buffer: Vec<u8>) -> Option<Self::Picture> {
        loop {
            match self.decoder.receive_frame(&mut self.frame) {
                Ok(()) => return Some(self.picture(buffer)),
                Err(AvError::Eof) => return None,
                Err(AvError::Other { errno }) if wants_more(errno) => {
                    if let Err(given_up) = self.feed() {
                        return Some(Err(given_up));
                    }
                }
                Err(_) => return Some(Err(GivenUp)),
            }
        }
    }
}

/// Whether the decoder gives no frame because it needs more to make one of.
fn wants_more(errno: i32) -> bool {
    std::io::Error::from_raw_os_error(errno).kind() == ErrorKind::WouldBlock
}

/// What ffprobe would say of the stream.
fn stated(input: &Input, stream: &ffmpeg_the_third::Stream<'_>, decoder: &decoder::Video) -> probe::Stream {
    let rate = |rate: Rational| Some(format!("{}/{}", rate.0, rate.1));
    let seconds = |ticks: i64| ticks as f64 * f64::from(stream.time_base());
    let pixels = match decoder.format() {
        Pixel::YUV420P => Some("yuv420p"),
        Pixel::YUVJ420P => Some("yuvj420p"),
        _ => None,
    };
    let space = match decoder.color_space() {
        Space::Unspecified => "unknown",
        Space::SMPTE170M => "smpte170m",
        Space::BT470BG => "bt470bg",
        Space::BT709 => "bt709",
        _ => "another",
    };
    let metadata = stream.metadata();
    // Nothing promises that a tag is UTF-8, whatever its type says.
    let length = metadata.get("DURATION").map(|text| String::from_utf8_lossy(text.as_bytes()).into_owned());
    probe::Stream {
        avg_frame_rate: rate(stream.avg_frame_rate()),
        r_frame_rate: rate(stream.rate()),
        nb_frames: (stream.frames() > 0).then(|| stream.frames().to_string()),
        time_base: Some(format!("{}/{}", stream.time_base().0, stream.time_base().1)),
        // Unknown is the least number that there is.
        start_time: (stream.start_time() > i64::MIN).then(|| seconds(stream.start_time()).to_string()),
        states_rate: false,
        duration: (stream.duration() > i64::MIN).then(|| seconds(stream.duration()).to_string()),
        tags: probe::Tags { duration: length },
        hides_frames: input.format().name().split(',').any(|name| name == probe::HIDING_CONTAINER),
        pix_fmt: pixels.map(str::to_owned),
        color_space: Some(space.to_owned()),
        color_range: (decoder.color_range() == Range::JPEG).then(|| "pc".to_owned()),
    }
}
