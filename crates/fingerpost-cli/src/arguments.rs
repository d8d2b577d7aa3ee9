//! Arguments that have a form of their own.

use std::fmt::{self, Display, Formatter};
use std::num::NonZeroUsize;
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::time::Duration;

use clap::ValueEnum;
use fingerpost::road_surface::RoadMethod;
use fingerpost_map::{LatLon, OsmData};
use fingerpost_vision::simd::InstructionSet;

/// A place given as `LAT,LON`, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place(pub(crate) LatLon);

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || format!("{text:?} is no place; give LAT,LON in degrees, as in 48.9833,8.3909");
        let (lat, lon) = text.split_once(',').ok_or_else(form)?;
        let lat_deg = lat.trim().parse().map_err(|_| form())?;
        let lon_deg = lon.trim().parse().map_err(|_| form())?;
        LatLon::new(lat_deg, lon_deg).map(Self).map_err(|cause| cause.to_string())
    }
}

/// A picture's size given as `WIDTHxHEIGHT`, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PictureSize {
    pub(crate) width: usize,
    pub(crate) height: usize,
}

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Below this nothing of a road can be told; above, no camera's picture is.
        let sides = 64..=8192;
        let side = |side: &str| side.parse().ok().filter(|side| sides.contains(side));
        text.split_once('x')
            .and_then(|(width, height)| Some(Self { width: side(width)?, height: side(height)? }))
            .filter(|size| size.width * size.height <= MOST_RENDERED_PIXELS)
            .ok_or_else(|| {
                format!(
                    "{text:?} is no size; give WIDTHxHEIGHT, each 64 to 8192 pixels and {} million together, as in 640x480",
                    MOST_RENDERED_PIXELS / 1_000_000
                )
            })
    }
}

/// Pixels of a rendered picture: those of the largest cameras of vehicles; several are in hand at once, each with its rays.
const MOST_RENDERED_PIXELS: usize = 20_000_000;

/// Threads that may work at once: each holds pictures of its own, and no processor has more cores.
const MOST_THREADS: usize = 512;

/// A number of threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Threads(pub(crate) NonZeroUsize);

impl FromStr for Threads {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = text.parse().ok().filter(|count: &NonZeroUsize| count.get() <= MOST_THREADS);
        count.map(Self).ok_or_else(|| format!("{text:?} is no number of threads; give 1 to {MOST_THREADS}"))
    }
}

/// Longest made-up road, metres: the simulator holds all of its surroundings.
const LONGEST_COURSE_M: f64 = 19_000.0;

/// Shortest drive on a made-up road, metres: the simulator drives one at the least, and the route's chords are a little shorter than the
/// road that it is cut from.
const SHORTEST_COURSE_M: f64 = 2.0;

/// Length of the drive on a made-up road, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CourseLength(pub(crate) f64);

impl FromStr for CourseLength {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let length_m =
            text.parse().ok().filter(|length_m| (SHORTEST_COURSE_M..=LONGEST_COURSE_M).contains(length_m));
        length_m.map(Self).ok_or_else(|| {
            format!("{text:?} is no length of a drive; give {SHORTEST_COURSE_M} to {LONGEST_COURSE_M} metres")
        })
    }
}

impl Display for CourseLength {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Longest time that somebody is waited for, seconds: a day.
const LONGEST_WAIT_S: f64 = 86_400.0;

/// How long an input may give nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct WaitingTime(pub(crate) Duration);

impl FromStr for WaitingTime {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let time_s = text.parse().ok().filter(|time_s| (0.1..=LONGEST_WAIT_S).contains(time_s));
        time_s
            .map(|time_s| Self(Duration::from_secs_f64(time_s)))
            .ok_or_else(|| format!("{text:?} is no time to wait; give 0.1 to {LONGEST_WAIT_S} seconds"))
    }
}

impl Display for WaitingTime {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.as_secs_f64().fmt(f)
    }
}

/// How much memory an input may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::Args)]
pub(crate) struct InputLimit {
    /// Memory that a map, a GPS track or a recording's measurements may take, MiB, 1 to 65536: so much of a file is read, and so much is
    /// made of it.
    #[arg(long, value_name = "MIB", default_value_t = (OsmData::MEMORY_BYTES >> 20) as u32,
          value_parser = clap::value_parser!(u32).range(1..=65_536))]
    max_input_mib: u32,
}

impl InputLimit {
    /// The limit in bytes.
    pub(crate) const fn bytes(self) -> usize {
        (self.max_input_mib as usize).saturating_mul(1 << 20)
    }
}

/// Reads a number from `least` to `most`; `what` is what it says, `unit` what it counts.
pub(crate) fn number(
    least: f64,
    most: f64,
    what: &'static str,
    unit: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| format!("{text:?} is no {what}; give {least} to {most} {unit}"))
    }
}

/// Reads the frame rate of an input, frames a second.
pub(crate) fn frame_rate(text: &str) -> Result<f64, String> {
    number(0.01, 1000.0, "frame rate", "frames a second")(text)
}

/// Reads the frame rate of a simulation, frames a second.
pub(crate) fn simulated_rate(text: &str) -> Result<f64, String> {
    number(0.1, 1000.0, "frame rate", "frames a second")(text)
}

/// Frames given as `FROM-TO`, both included, or as one number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FrameRange(pub(crate) RangeInclusive<u64>);

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (from, to) = text.split_once('-').unwrap_or((text, text));
        match (from.parse(), to.parse()) {
            (Ok(from), Ok(to)) if from <= to => Ok(Self(from..=to)),
            _ => Err(format!("{text:?} are no frames; give FROM-TO, as in 85-105, or one frame's number")),
        }
    }
}

/// A road detector by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DetectorName(pub(crate) RoadMethod);

impl FromStr for DetectorName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        RoadMethod::ALL.into_iter().find(|method| method.name() == text).map(Self).ok_or_else(|| {
            let names = RoadMethod::ALL.map(RoadMethod::name).join(", ");
            format!("{text:?} is no detector; there are {names}")
        })
    }
}

/// An instruction set by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum InstructionSetName {
    /// What every machine of this kind has.
    Portable,
    /// x86-64 with AVX2.
    Avx2,
    /// x86-64 with AVX-512.
    Avx512,
}

impl From<InstructionSetName> for InstructionSet {
    fn from(name: InstructionSetName) -> Self {
        match name {
            InstructionSetName::Portable => Self::Portable,
            InstructionSetName::Avx2 => Self::Avx2,
            InstructionSetName::Avx512 => Self::Avx512,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_sizes() {
        let place: Place = "-33.5, 151.25".parse().unwrap();
        assert!((place.0.lat_deg + 33.5).abs() < 1e-12 && (place.0.lon_deg - 151.25).abs() < 1e-12);
        assert!("48.9".parse::<Place>().is_err() && "91,0".parse::<Place>().is_err());
        assert_eq!("640x480".parse(), Ok(PictureSize { width: 640, height: 480 }));
        assert!("640".parse::<PictureSize>().is_err() && "0x480".parse::<PictureSize>().is_err());
        assert!("8192x2400".parse::<PictureSize>().is_ok() && "8192x8192".parse::<PictureSize>().is_err());
    }

    #[test]
    fn numbers_of_no_machine_and_no_road_are_refused() {
        let absurd = ["0", "-1", "1000000", "18446744073709551616", "1e8", "-1e300", "inf", "NaN", "", "ten"];
        for text in absurd {
            assert!(text.parse::<Threads>().is_err_and(|error| error.contains("1 to 512")), "{text}");
            assert!(text.parse::<CourseLength>().is_err_and(|error| error.contains("2 to 19000")), "{text}");
            assert!(format!("{text}x480").parse::<PictureSize>().is_err(), "{text}");
        }
        for text in absurd.into_iter().chain(["86401", "0.09"]) {
            assert!(text.parse::<WaitingTime>().is_err_and(|error| error.contains("0.1 to 86400")), "{text}");
        }
        assert!("512".parse::<Threads>().is_ok() && "19000".parse::<CourseLength>().is_ok());
    }

    #[test]
    fn numbers_out_of_range_are_named_in_a_short_message() {
        for text in
            ["0", "-1", "1e-300", "1e300", "-1e300", "NaN", "inf", "9223372036854775808", "1001", "", "ten"]
        {
            for read in [frame_rate, simulated_rate] {
                let error = read(text).unwrap_err();
                assert!(error.contains("to 1000 frames a second") && error.len() < 100, "{error}");
            }
        }
        assert!(frame_rate("0.01").is_ok() && simulated_rate("1000").is_ok());
    }

    #[test]
    fn ranges_of_frames() {
        assert_eq!("85-105".parse(), Ok(FrameRange(85..=105)));
        assert_eq!("7".parse(), Ok(FrameRange(7..=7)));
        assert!("9-8".parse::<FrameRange>().is_err() && "-".parse::<FrameRange>().is_err());
    }
}
