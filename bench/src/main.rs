//! Fingerpost beside its peers: one command measures kernels, the whole loop, lanes, motion estimates and whole
//! runs, interleaved in one run on the same frames, after it has checked that the results agree.

mod footage;
mod growth;
mod kernels;
mod lanes;
mod machine;
mod measure;
mod motion;
mod network;
mod peer;
mod recording;
mod results;
mod trapezium;
mod whole_loop;
mod whole_method;

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Parser;
use fingerpost_vision::simd::{CodePath, InstructionSet};

use footage::Footage;
use kernels::Bench;
use machine::Machine;
use measure::Effort;
use peer::OpenCv;
use results::{Results, Section, set_name};

/// Measures Fingerpost beside OpenCV, Rust crates and ffmpeg: the command `bench/run` prepares what this needs.
#[derive(Debug, Parser)]
struct Arguments {
    /// Recording to measure on; without it a drive is simulated, 960 x 540.
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// Python with opencv-contrib-python and numpy.
    #[arg(long, value_name = "FILE", default_value = "python3")]
    python: PathBuf,
    /// The program `fingerpost`; without it whole runs are left out.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Times that every contestant has its turn.
    #[arg(long, value_name = "N", default_value_t = 15)]
    rounds: usize,
    /// Compare results only; nothing is timed.
    #[arg(long, conflicts_with = "rounds")]
    check: bool,
    /// Only sections whose title has this in it.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Instruction sets of Fingerpost's kernels, by commas: the kernels are measured with each, all else with the most
    /// demanding; without it all that this processor has.
    #[arg(long, value_name = "SETS", value_delimiter = ',', value_parser = instruction_set)]
    instruction_set: Vec<InstructionSet>,
    /// Print JSON on standard output; the table then goes to standard error.
    #[arg(long)]
    json: bool,
}

/// How long a contestant's turn lasts, milliseconds: long against a switch of tasks, short against a change of load.
const TURN_MS: f64 = 10.0;

/// An instruction set of this processor by its name.
fn instruction_set(name: &str) -> Result<InstructionSet, String> {
    let set = InstructionSet::ALL.into_iter().find(|&set| set_name(set) == name);
    let set = set.ok_or_else(|| {
        let names = InstructionSet::ALL.map(set_name).join(", ");
        format!("there is no such instruction set; there are {names}")
    })?;
    CodePath::with(set)
        .ok_or("this processor does not have it")
        .map(CodePath::instruction_set)
        .map_err(Into::into)
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut sets = arguments.instruction_set.clone();
    if sets.is_empty() {
        sets = CodePath::available().map(CodePath::instruction_set).collect();
    }
    // The most demanding first.
    sets.sort_unstable_by(|a, b| b.cmp(a));
    sets.dedup();
    let most = sets[0];
    CodePath::limit(most);
    let script = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("peer/opencv_peer.py");
    let mut opencv = OpenCv::start(&arguments.python, &script)?;
    let footage = Footage::open(arguments.recording.as_deref())?;
    let effort = Effort { rounds: if arguments.check { 0 } else { arguments.rounds }, turn_ms: TURN_MS };
    let mut sections: Vec<Section> = Vec::new();
    let wanted = |title: &str| title.contains(&arguments.only.to_lowercase());
    let timed = |title: &str| wanted(title) && !arguments.check;
    if wanted("kernels") {
        let mut bench = Bench { opencv: &mut opencv, effort, frames: &footage.frames, sets: &sets };
        sections.push(kernels::kernels(&mut bench)?);
        CodePath::limit(most);
    }
    if timed("whole loop") {
        sections.push(whole_loop::whole_loop(&mut opencv, effort, &footage)?);
    }
    if timed("whole method") {
        sections.push(whole_method::whole_method()?);
    }
    if wanted("lanes") {
        sections.push(lanes::lanes(&mut opencv, effort)?);
    }
    if timed("motion") {
        sections.push(motion::motion(&mut opencv, effort)?);
    }
    if wanted("network") {
        sections.push(network::network(effort, &footage, &sets)?);
        CodePath::limit(most);
    }
    if let Some(program) = arguments.program.as_deref().filter(|_| timed("recording")) {
        sections.push(recording::recording(effort, &footage, program, most)?);
    }
    if timed("growth") {
        sections.push(growth::growth(effort, &footage)?);
    }
    if sections.is_empty() {
        bail!("no section has \"{}\" in its title; bench/README.md lists them", arguments.only);
    }
    let machine = Machine::this(opencv.version.clone());
    let results = Results { machine, footage: footage.description.clone(), sections };
    if arguments.json {
        eprintln!("{}", results.table());
        println!("{}", serde_json::to_string_pretty(&results)?);
    } else {
        println!("{}", results.table());
    }
    if !results.sections.iter().all(Section::holds) {
        bail!("not everything that is promised holds; see above");
    }
    Ok(())
}
