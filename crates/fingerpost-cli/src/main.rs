//! The program `fingerpost`: arguments in, calls to the libraries, files out.
//!
//! One file a subcommand. Standard output carries data only where it is asked for (`--json`, `schema`); progress and
//! messages go to standard error. Exit codes: 0 done, 1 the input or the run failed, 2 wrong arguments.

#[cfg(unix)]
mod advise;
mod arguments;
mod calibrate;
mod camera_size;
mod campaign;
mod can;
mod can_signals;
mod changed_settings;
#[cfg(feature = "completions")]
mod completions;
mod convert;
mod demo;
mod driver;
mod evaluate;
mod examples;
mod facts;
mod frame_choice;
mod gps;
mod gps_track;
mod inputs;
mod interrupt;
mod licences;
mod live_gps;
mod locate;
mod look;
mod made_from;
#[cfg(feature = "completions")]
mod man;
mod mark;
mod mount_args;
mod mount_search;
#[cfg(feature = "onnx")]
mod onnx;
mod output;
mod output_path;
mod overlap;
mod papers;
mod parts;
mod picture_for_page;
mod picture_order;
mod picture_scaling;
mod recorder;
#[cfg(feature = "ros2")]
mod ros2;
mod route;
mod run;
mod schema;
mod side_by_side;
mod simulate;
mod stage_clock;
mod start_check;
mod surface_place;
#[cfg(unix)]
mod tether;
mod tune;
mod usage_hints;
mod verbosity;
mod version;
mod watchdog;

use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, Subcommand};
use fingerpost_io::{DEFAULT_LONGEST_WAIT, TETHER_ARGUMENT};

use crate::arguments::WaitingTime;
use crate::examples::examples;
use crate::verbosity::Verbosity;

/// Finds the junctions of a route in a camera's picture, follows them and gives a driving line through each.
#[derive(Debug, Parser)]
#[command(name = "fingerpost", version = version::VERSION, about, arg_required_else_help = true)]
#[command(before_long_help = examples!(
    "demo",
    "run drive.mp4 --camera camera.toml --route route.geojson --out run"
))]
struct Cli {
    /// Longest time to wait for an input that gives nothing, seconds, 0.1 to 86400: a camera, a network stream, ffmpeg; a file
    /// that comes through a pipe, in all.
    #[arg(long, value_name = "S", global = true, default_value_t = WaitingTime(DEFAULT_LONGEST_WAIT))]
    timeout_s: WaitingTime,
    #[command(flatten)]
    verbosity: Verbosity,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::DemoArgs),
    Route(route::RouteArgs),
    Run(run::RunArgs),
    #[cfg(unix)]
    Advise(advise::AdviseArgs),
    #[cfg(feature = "ros2")]
    Ros2(ros2::Ros2Args),
    Simulate(simulate::SimulateArgs),
    Campaign(campaign::CampaignArgs),
    Tune(tune::TuneArgs),
    Papers(papers::PapersArgs),
    #[command(subcommand)]
    Calibrate(calibrate::CalibrateCommand),
    #[command(subcommand)]
    Evaluate(evaluate::EvaluateCommand),
    Mark(mark::MarkArgs),
    Locate(locate::LocateArgs),
    Look(look::LookArgs),
    #[command(subcommand)]
    Convert(convert::ConvertCommand),
    Can(can::CanArgs),
    Schema(schema::SchemaArgs),
    Licences(licences::LicencesArgs),
    #[cfg(feature = "completions")]
    Completions(completions::CompletionsArgs),
    #[cfg(feature = "completions")]
    Man(man::ManArgs),
    #[cfg(unix)]
    #[command(name = TETHER_ARGUMENT, hide = true)]
    Tether(tether::TetherArgs),
}

impl Command {
    /// Whether this process is about to become a program that another one of this program has started and whose messages it reads.
    fn is_tether(&self) -> bool {
        #[cfg(unix)]
        return matches!(self, Self::Tether(_));
        #[cfg(not(unix))]
        return false;
    }
}

/// Says why arguments are refused, or what was asked for: help and version are errors of the parser too.
fn refuse(refused: &clap::Error) -> ExitCode {
    let text = refused.render().to_string();
    // The parser repeats the arguments that it refuses.
    let shown = made_from::without_credentials_of(std::env::args_os(), &text);
    if shown == text {
        // Nobody may be left who reads it.
        let _ = refused.print();
    } else {
        output::line(shown.trim_end());
    }
    if let Some(hint) = usage_hints::hint(refused, std::env::args().skip(1)) {
        output::line(hint);
    }
    ExitCode::from(u8::try_from(refused.exit_code()).unwrap_or(u8::MAX))
}

fn main() -> ExitCode {
    let started = Instant::now();
    let Cli { timeout_s: WaitingTime(longest_wait), verbosity, command } = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(refused) => return refuse(&refused),
    };
    // A filter that cannot be used would be taken for a complaint of that program.
    let filter = if command.is_tether() { None } else { verbosity::of_environment() };
    verbosity.begin(filter.as_deref());
    fingerpost_io::set_longest_wait(longest_wait);
    let done = interrupt::survive_file_size_limit().and_then(|()| match command {
        Command::Demo(args) => demo::demo(&args),
        Command::Route(args) => route::route(&args),
        Command::Run(args) => run::run(&args),
        #[cfg(unix)]
        Command::Advise(args) => advise::advise(&args),
        #[cfg(feature = "ros2")]
        Command::Ros2(args) => ros2::ros2(&args),
        Command::Simulate(args) => simulate::simulate(&args),
        Command::Campaign(args) => campaign::campaign(&args),
        Command::Tune(args) => tune::tune(&args),
        Command::Papers(args) => papers::papers(&args),
        Command::Calibrate(command) => calibrate::calibrate(&command),
        Command::Evaluate(command) => evaluate::evaluate(&command),
        Command::Mark(args) => mark::mark(&args),
        Command::Locate(args) => locate::locate(&args),
        Command::Look(args) => look::look(&args),
        Command::Convert(command) => convert::convert(&command),
        Command::Can(args) => can::can(&args),
        Command::Schema(args) => schema::schema(&args),
        Command::Licences(args) => licences::licences(&args),
        #[cfg(feature = "completions")]
        Command::Completions(args) => completions::completions(&args),
        #[cfg(feature = "completions")]
        Command::Man(args) => man::man(&args),
        #[cfg(unix)]
        Command::Tether(args) => tether::tether(&args),
    });
    match done {
        Ok(()) => {
            log::info!("done after {:.1} s", started.elapsed().as_secs_f64());
            ExitCode::SUCCESS
        }
        Err(error) => {
            output::error(&format!("fingerpost: {}", output::cause_chain(&error)));
            ExitCode::FAILURE
        }
    }
}
