//! From the configured signals of a bus to the values that the method takes.

use std::path::Path;

use anyhow::{Context, Result, bail};
use fingerpost::vehicle_signals::{CanConfig, Sample, SignalValue, TurnSignal, VehicleSamples};
use fingerpost_io::{CanDatabase, SignalLayout, SignalLog, SignalSample};

use crate::output;

/// What stands before the name of an interface in place of a log.
const BUS: &str = "socketcan:";

/// How far a value may be from the one that a turn signal is configured to have: values are whole numbers times a factor.
const SAME_VALUE: f64 = 1e-6;

/// Identifiers that a message lists.
const MOST_NAMED: usize = 12;

/// What a signal says of the vehicle.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Meaning {
    /// Yaw rate, with what makes it radians a second to the left.
    YawRate { rps: f64 },
    /// Speed, with what makes it metres a second.
    Speed { mps: f64 },
    /// Turn signal, with its values.
    TurnSignal { left: f64, right: f64, off: f64 },
}

impl Meaning {
    /// The value in the method's units and signs, or 0 for off, 1 for left, -1 for right and nothing for no turn signal.
    pub(crate) fn number(&self, value: f64) -> Option<f64> {
        match *self {
            Self::YawRate { rps } => Some(value * rps),
            Self::Speed { mps } => Some(value * mps),
            Self::TurnSignal { .. } => match self.turn(value) {
                TurnSignal::Unknown => None,
                TurnSignal::Off => Some(0.0),
                TurnSignal::Left => Some(1.0),
                TurnSignal::Right => Some(-1.0),
            },
        }
    }

    /// What the value of a turn signal means.
    fn turn(&self, value: f64) -> TurnSignal {
        let Self::TurnSignal { left, right, off } = self else { return TurnSignal::Unknown };
        let meanings = [(off, TurnSignal::Off), (left, TurnSignal::Left), (right, TurnSignal::Right)];
        let meaning = meanings.into_iter().find(|(known, _)| (value - **known).abs() < SAME_VALUE);
        meaning.map_or(TurnSignal::Unknown, |(_, turn)| turn)
    }
}

/// The configured signals in their DBC file.
#[derive(Debug)]
pub(crate) struct CanSignals {
    pub(crate) layouts: Vec<SignalLayout>,
    pub(crate) meanings: Vec<Meaning>,
}

impl CanSignals {
    /// Finds the signals that the configuration names.
    pub(crate) fn find(config: &CanConfig, dbc: &Path) -> Result<Self> {
        let database = CanDatabase::read(dbc)?;
        let layout = |key: &str, name: &Option<String>| -> Result<Option<SignalLayout>> {
            let Some(name) = name else { return Ok(None) };
            let found = database.signal(name);
            found.map(Some).with_context(|| format!("can.{key} of the configuration with {}", dbc.display()))
        };
        let mut signals = Self { layouts: Vec::new(), meanings: Vec::new() };
        if let Some(layout) = layout("yaw_rate", &config.yaw_rate)? {
            let rps = config.yaw_rate_unit.rps() * config.yaw_rate_positive.sign();
            signals.add(layout, Meaning::YawRate { rps });
        }
        if let Some(layout) = layout("speed", &config.speed)? {
            signals.add(layout, Meaning::Speed { mps: config.speed_unit.mps() });
        }
        if let Some(layout) = layout("turn_signal", &config.turn_signal)? {
            let value = |key, value| turn_value(&layout, key, value);
            let meaning = Meaning::TurnSignal {
                left: value("left", &config.turn_signal_left)?,
                right: value("right", &config.turn_signal_right)?,
                off: value("off", &config.turn_signal_off)?,
            };
            signals.add(layout, meaning);
        }
        if signals.layouts.is_empty() {
            bail!(
                "the configuration names no signal of the bus; set can.yaw_rate, can.speed or can.turn_signal to \
                 MESSAGE.SIGNAL of the DBC file in the file of --config"
            );
        }
        Ok(signals)
    }

    fn add(&mut self, layout: SignalLayout, meaning: Meaning) {
        self.layouts.push(layout);
        self.meanings.push(meaning);
    }

    /// Takes in the newest value of each signal, with its age.
    fn samples(&self, newest: impl Fn(usize) -> Option<(f64, f64)>) -> VehicleSamples {
        let mut samples = VehicleSamples::default();
        for (index, meaning) in self.meanings.iter().enumerate() {
            let Some((value, age_s)) = newest(index) else { continue };
            match *meaning {
                Meaning::YawRate { rps } => {
                    samples.yaw_rate_rps = Some(Sample { value: value * rps, age_s });
                }
                Meaning::Speed { mps } => samples.speed_mps = Some(Sample { value: value * mps, age_s }),
                Meaning::TurnSignal { .. } => {
                    samples.turn_signal = Some(Sample { value: meaning.turn(value), age_s });
                }
            }
        }
        samples
    }
}

/// A configured value of the turn signal as a number.
fn turn_value(layout: &SignalLayout, key: &str, value: &SignalValue) -> Result<f64> {
    let name = match value {
        SignalValue::Number(number) => return Ok(*number),
        SignalValue::Name(name) => name,
    };
    let Some(number) = layout.value_named(name) else {
        let known: Vec<&str> = layout.value_names.iter().map(|(_, known)| known.as_str()).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        bail!(
            "can.turn_signal_{key} of the configuration is {name:?}, and the DBC file names these values of {}: {known}; \
             give one of them, or the number",
            layout.name
        );
    };
    Ok(number)
}

/// The signals of a drive, by its time.
#[derive(Debug)]
pub(crate) enum CanFeed {
    /// From a log.
    Log(LogFeed),
    /// From a bus.
    #[cfg(all(feature = "socketcan", target_os = "linux"))]
    Bus {
        signals: CanSignals,
        listener: fingerpost_io::CanListener,
        /// Signals of which it is not said yet that their sender gives no value.
        unsaid: Vec<usize>,
    },
}

impl CanFeed {
    /// Opens a log, or an interface named `socketcan:INTERFACE`.
    pub(crate) fn open(can: &str, dbc: &Path, config: &CanConfig) -> Result<Self> {
        let signals = CanSignals::find(config, dbc)?;
        match can.strip_prefix(BUS) {
            Some(interface) => Self::open_bus(interface, signals),
            None => Ok(Self::Log(LogFeed::read(Path::new(can), signals, config)?)),
        }
    }

    #[cfg(all(feature = "socketcan", target_os = "linux"))]
    fn open_bus(interface: &str, signals: CanSignals) -> Result<Self> {
        let listener = fingerpost_io::CanListener::open(interface, signals.layouts.clone())?;
        let unsaid = (0..signals.layouts.len()).collect();
        Ok(Self::Bus { signals, listener, unsaid })
    }

    #[cfg(not(all(feature = "socketcan", target_os = "linux")))]
    fn open_bus(_: &str, _: CanSignals) -> Result<Self> {
        bail!(
            "this program was built without SocketCAN; build it on Linux with --features socketcan, or give a log of candump -L"
        )
    }

    /// The newest values at a time since the first frame. Frames are asked for in their order.
    pub(crate) fn at(&mut self, t_s: f64) -> VehicleSamples {
        match self {
            Self::Log(log) => log.at(t_s),
            #[cfg(all(feature = "socketcan", target_os = "linux"))]
            Self::Bus { signals, listener, unsaid } => {
                for signal in unsaid.extract_if(.., |signal| listener.no_values(*signal) > 0) {
                    let name = &signals.layouts[signal].name;
                    output::message(&format!("{name}: its sender says that it has no value (SAE J1939-71)"));
                }
                signals.samples(|signal| listener.newest(signal))
            }
        }
    }
}

/// The identifiers and interfaces of a log, for who looks for others.
fn what_came(log: &SignalLog, layouts: &[SignalLayout]) -> String {
    let mut wanted: Vec<String> = layouts.iter().map(|layout| layout.message.to_string()).collect();
    wanted.dedup();
    let ids: Vec<String> = log.came.iter().take(MOST_NAMED).map(ToString::to_string).collect();
    let more = log.came.len().saturating_sub(MOST_NAMED);
    let more = if more > 0 { format!(" and {more} others") } else { String::new() };
    let interfaces = log.interfaces.iter().cloned().collect::<Vec<_>>().join(", ");
    let came = if ids.is_empty() { "none".to_owned() } else { ids.join(", ") };
    format!(
        "identifiers {} never came with it; these did: {came}{more}, of the interfaces {interfaces}",
        wanted.join(", ")
    )
}

/// What is to be said of each signal in order whose messages say that it has no value.
fn without_values(layouts: &[SignalLayout], log: &SignalLog) -> impl Iterator<Item = Option<String>> {
    layouts.iter().zip(&log.samples).zip(&log.no_values).map(|((layout, samples), no_values)| {
        let first_s = no_values.first_s? - log.first_s;
        Some(format!(
            "{} has no value in {} of {} messages: {} say that it is not available and {} that it is in error (SAE J1939-71), the first \
             {first_s:.1} s after the log's first frame",
            layout.name,
            no_values.count(),
            no_values.count() + samples.len() as u64,
            no_values.not_available,
            no_values.errors
        ))
    })
}

/// Says which signals of a log never came or have no value, and which several senders say.
pub(crate) fn say_what_is_missing(path: &Path, layouts: &[SignalLayout], log: &SignalLog) {
    let signals = layouts.iter().zip(&log.samples).zip(&log.senders).zip(without_values(layouts, log));
    for (((layout, samples), senders), without_value) in signals {
        if let Some(said) = without_value {
            output::message(&format!("{}: {said}", path.display()));
        } else if samples.is_empty() {
            let what = what_came(log, std::slice::from_ref(layout));
            output::message(&format!("{}: no frame has {}; {what}", path.display(), layout.name));
        }
        if senders.len() > 1 {
            let senders: Vec<String> = senders.iter().take(MOST_NAMED).map(ToString::to_string).collect();
            output::message(&format!(
                "{}: {} comes from several senders, {}, and is taken from all of them",
                path.display(),
                layout.name,
                senders.join(", ")
            ));
        }
    }
}

/// The signals of a log.
#[derive(Debug)]
pub(crate) struct LogFeed {
    signals: CanSignals,
    log: SignalLog,
    /// How many samples of each signal have come.
    come: Vec<usize>,
    /// Time on the log's clock at the drive's first frame.
    start_s: f64,
}

impl LogFeed {
    fn read(path: &Path, signals: CanSignals, config: &CanConfig) -> Result<Self> {
        let log = SignalLog::read(path, config.interface.as_deref(), &signals.layouts)?;
        if log.samples.iter().all(Vec::is_empty) {
            let without: Vec<String> = without_values(&signals.layouts, &log).flatten().collect();
            if !without.is_empty() {
                bail!("{} says no value of any signal: {}", path.display(), without.join("; "));
            }
            let names: Vec<&str> = signals.layouts.iter().map(|layout| layout.name.as_str()).collect();
            bail!(
                "{} has no frame with {}; {}; see can.interface of the configuration and whether the DBC file is this vehicle's",
                path.display(),
                names.join(", "),
                what_came(&log, &signals.layouts)
            );
        }
        say_what_is_missing(path, &signals.layouts, &log);
        for (layout, samples) in signals.layouts.iter().zip(&log.samples) {
            log::info!("{}: {} samples of {}", path.display(), samples.len(), layout.name);
        }
        let start_s = log.first_s - config.time_offset_s;
        Ok(Self { come: vec![0; signals.layouts.len()], signals, log, start_s })
    }

    fn at(&mut self, t_s: f64) -> VehicleSamples {
        let now_s = self.start_s + t_s;
        let Self { signals, log, come, .. } = self;
        for (samples, come) in log.samples.iter().zip(come.iter_mut()) {
            *come += samples[*come..].iter().take_while(|sample| sample.t_s <= now_s).count();
        }
        let newest = |signal: usize| -> Option<&SignalSample> {
            log.samples.get(signal)?.get(come.get(signal)?.checked_sub(1)?)
        };
        signals.samples(|signal| newest(signal).map(|sample| (sample.value, now_s - sample.t_s)))
    }
}
