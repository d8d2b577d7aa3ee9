//! `fingerpost can`: what a CAN log says of the vehicle.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use fingerpost_io::{SignalLog, SignalSample, write_file};
use serde::Serialize;

use crate::can_signals::{CanSignals, Meaning, say_what_is_missing};
use crate::examples::examples;
use crate::output_path::FileKind;
use crate::{inputs, output, output_path};

/// Decode the configured signals of a CAN log, say how often each came and between what values, and write them as CSV: to
/// check names, units and signs before a run.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "can candump.log --dbc car.dbc --config fingerpost.toml",
    "can candump.log.gz --dbc car.dbc --config fingerpost.toml --out signals.csv"
))]
pub(crate) struct CanArgs {
    /// Log of `candump -L`, plain or .gz.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Database of the vehicle's bus, .dbc.
    #[arg(long, value_name = "FILE")]
    dbc: PathBuf,
    /// Configuration whose table "can" names the signals; `fingerpost schema` describes its keys.
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Samples to write, CSV: time on the log's clock and on the drive's, then a column a signal in SI units; a turn signal
    /// is 1 to the left, -1 to the right, 0 off.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print the numbers as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// How a table of samples begins: its first columns.
pub(crate) const CSV_HEAD: &str = "log_s,t_s,";

/// What a log says of a signal.
#[derive(Debug, Serialize)]
struct SignalFacts {
    signal: String,
    quantity: &'static str,
    samples: usize,
    /// Messages that say that it has no value.
    without_value: u64,
    samples_per_s: f64,
    min: Option<f64>,
    max: Option<f64>,
}

/// Decodes.
pub(crate) fn can(args: &CanArgs) -> Result<()> {
    if let Some(out) = &args.out {
        output_path::check_file(
            out,
            FileKind::Signals,
            [&args.log, &args.dbc, &args.config].map(PathBuf::as_path),
        )?;
    }
    let config = inputs::config(Some(&args.config))?.can;
    let signals = CanSignals::find(&config, &args.dbc)?;
    let log = SignalLog::read(&args.log, config.interface.as_deref(), &signals.layouts)?;
    let facts = facts(&signals, &log);
    output::message(&format!(
        "{} frames in {:.1} s, {} lines that are none of a log's",
        log.frames,
        log.last_s - log.first_s,
        log.unreadable_lines
    ));
    for SignalFacts { signal, quantity, samples, samples_per_s, min, max, .. } in &facts {
        let range =
            min.zip(*max).map_or("no value came".to_owned(), |(min, max)| format!("{min:.4} to {max:.4}"));
        output::message(&format!(
            "{quantity} ({signal}): {samples} samples, {samples_per_s:.1} a second, {range}"
        ));
    }
    say_what_is_missing(&args.log, &signals.layouts, &log);
    if let Some(out) = &args.out {
        write_csv(out, &signals, &log, config.time_offset_s)?;
    }
    if args.json { output::print_json(&facts) } else { Ok(()) }
}

const fn quantity(meaning: Meaning) -> &'static str {
    match meaning {
        Meaning::YawRate { .. } => "yaw_rate_rps",
        Meaning::Speed { .. } => "speed_mps",
        Meaning::TurnSignal { .. } => "turn_signal",
    }
}

fn facts(signals: &CanSignals, log: &SignalLog) -> Vec<SignalFacts> {
    let facts = signals.layouts.iter().zip(&signals.meanings).zip(&log.samples).zip(&log.no_values);
    let facts = facts.map(|(((layout, meaning), samples), no_values)| {
        let values: Vec<f64> = samples.iter().filter_map(|sample| meaning.number(sample.value)).collect();
        let length_s = (log.last_s - log.first_s).max(f64::MIN_POSITIVE);
        SignalFacts {
            signal: layout.name.clone(),
            quantity: quantity(*meaning),
            samples: samples.len(),
            without_value: no_values.count(),
            samples_per_s: if log.frames > 1 { samples.len() as f64 / length_s } else { 0.0 },
            min: values.iter().copied().min_by(f64::total_cmp),
            max: values.iter().copied().max_by(f64::total_cmp),
        }
    });
    facts.collect()
}

fn write_csv(path: &Path, signals: &CanSignals, log: &SignalLog, offset_s: f64) -> Result<()> {
    let columns: Vec<&str> = signals.meanings.iter().map(|meaning| quantity(*meaning)).collect();
    let mut text = format!("{CSV_HEAD}{}\n", columns.join(","));
    let mut rows: Vec<(usize, SignalSample)> = log
        .samples
        .iter()
        .enumerate()
        .flat_map(|(signal, samples)| samples.iter().map(move |sample| (signal, *sample)))
        .collect();
    rows.sort_by(|(_, a), (_, b)| a.t_s.total_cmp(&b.t_s));
    for (signal, SignalSample { t_s, value }) in rows {
        let number =
            signals.meanings[signal].number(value).map_or(String::new(), |number| format!("{number:.6}"));
        let (before, behind) = (",".repeat(signal), ",".repeat(columns.len() - 1 - signal));
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{t_s:.6},{:.6},{before}{number}{behind}", t_s - log.first_s + offset_s);
    }
    Ok(write_file(path, text)?)
}
