//! `fingerpost campaign --closed-loop`: drives in which the advice moves the vehicle, of every controller.
//!
//! A drive follows from its seed, its conditions and its controller, and from what `setup.json` says. Each is a line of
//! `closed_loop.jsonl` as soon as it is done, so that a campaign that was ended in the middle goes on where it was.

mod drive;
mod fault;

use std::sync::Mutex;

use anyhow::{Result, bail};
use fingerpost_control::ControllerName;
use fingerpost_eval::closed_loop_table;
use fingerpost_format::{ClosedLoop, ErrorQuantiles, LoopDrive, LoopEnd, LoopGroup};
use fingerpost_io::{ClosedLoopFolder, FolderKind, file_digest};
use fingerpost_report::{ClosedLoopInput, closed_loop_html};
use serde_json::{Value, json};

pub(crate) use self::fault::Fault;
use super::{CampaignArgs, Drawing, Plan};
use crate::interrupt::Interrupt;
use crate::version::{VERSION, WRITTEN_BY_PROGRAM};
use crate::{inputs, output, output_path, side_by_side};

/// Conditions of closed-loop drives where none are given: those of the one world, and worlds.
pub(crate) const CONDITIONS: [&str; 12] = [
    "clear",
    "unmarked",
    "shadows",
    "rough",
    "wet",
    "mixed",
    "dusk",
    "dust",
    "hills",
    "knocked",
    "dirty_lens",
    super::WORLD,
];
/// Features of a route where nothing else is said.
pub(crate) const FEATURES: usize = 5;

/// What all drives share.
struct LoopSetting<'a> {
    args: &'a CampaignArgs,
    drawing: Drawing,
    fault: Option<Fault>,
    interrupt: Interrupt,
}

impl LoopSetting<'_> {
    /// What is driven, and what the method knows of it.
    fn plan(&self, drive: &LoopDrive) -> Result<Plan> {
        let controller = ControllerName::ALL.into_iter().find(|name| name.name() == drive.controller);
        let map_fault = match self.fault {
            Some(Fault::Map(fault)) => Some(fault),
            _ => None,
        };
        let mut plan =
            Plan::steered(&self.drawing, drive.seed, &drive.conditions, self.args.features, map_fault)?;
        plan.config.advice.controller = controller.unwrap_or_default();
        Ok(plan)
    }
}

/// Drives, counts, and writes the table.
pub(super) fn closed_loop(args: &CampaignArgs) -> Result<()> {
    let config = inputs::config(args.config.as_deref())?;
    let setup = setup(args, &config)?;
    let setting = LoopSetting {
        args,
        drawing: Drawing::new(args.map.as_deref(), args.limit, args.size, args.fps, config)?,
        fault: args.fault,
        interrupt: Interrupt::listen()?,
    };
    let inputs = [&args.map, &args.config].into_iter().flatten().map(std::path::PathBuf::as_path);
    output_path::check_folder(&args.out, FolderKind::ClosedLoop, inputs)?;
    let (folder, done) = ClosedLoopFolder::go_on_with(&args.out, &setup)?;
    let wanted = wanted(args);
    let is_done = |drive: &LoopDrive| done.iter().any(|done| name_of(done) == name_of(drive));
    let left: Vec<&LoopDrive> = wanted.iter().filter(|drive| !is_done(drive)).collect();
    if left.len() < wanted.len() {
        output::message(&format!(
            "{} of {} drives are done already",
            wanted.len() - left.len(),
            wanted.len()
        ));
    }
    let bar = output::progress(Some(wanted.len() as u64), "drives");
    bar.set_position((wanted.len() - left.len()) as u64);
    // Drives of an earlier call that this one does not ask for stay in the file and out of the table.
    let kept = done.into_iter().filter(|drive| wanted.iter().any(|wanted| name_of(wanted) == name_of(drive)));
    let so_far = Mutex::new((folder, kept.collect::<Vec<_>>()));
    side_by_side::each(args.threads, left.len() as u64, &setting.interrupt, |number| {
        let Some(drive) = drive::drive(&setting, left[number as usize]) else { return Ok(()) };
        let mut so_far = so_far.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let (folder, drives) = &mut *so_far;
        folder.append(&drive)?;
        drives.push(drive);
        bar.inc(1);
        write_table(folder, &table(args, drives, wanted.len()))
    })?;
    bar.finish_and_clear();
    let (folder, drives) = so_far.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    let table = table(args, &drives, wanted.len());
    write_table(&folder, &table)?;
    folder.finish()?;
    if setting.interrupt.wanted() {
        bail!(
            "interrupted after {} of {} drives; the same call goes on with them",
            drives.len(),
            wanted.len()
        );
    }
    print_table(&table);
    output::message(&format!("results in {}", args.out.join("report.html").display()));
    if args.json {
        output::print_json(&table)?;
    }
    match drives.iter().find_map(|drive| Some((drive, drive.error.as_ref()?))) {
        Some((drive, error)) => bail!("the drive of seed {} failed: {error}", drive.seed),
        None => Ok(()),
    }
}

/// All drives that are asked for: of every controller the same.
fn wanted(args: &CampaignArgs) -> Vec<LoopDrive> {
    let conditions = args.conditions();
    let drives = (0..args.drives).flat_map(|number| {
        args.controllers.iter().map(move |controller| (number, controller.name().to_owned()))
    });
    drives
        .map(|(number, controller)| LoopDrive {
            seed: args.seed + number,
            conditions: conditions[(number % conditions.len() as u64) as usize].clone(),
            controller,
            ..LoopDrive::default()
        })
        .collect()
}

fn name_of(drive: &LoopDrive) -> (u64, &str, &str) {
    (drive.seed, &drive.conditions, &drive.controller)
}

/// All that a drive of a seed, conditions and a controller depends on.
fn setup(args: &CampaignArgs, config: &fingerpost::Config) -> Result<Value> {
    Ok(json!({
        "program": VERSION,
        "settings": config.to_json(),
        "map_digest": args.map.as_deref().map(file_digest).transpose()?,
        "size": args.size.map(|size| [size.width, size.height]),
        "fps": args.fps,
        "features": args.features,
        "fault": args.fault,
    }))
}

fn table(args: &CampaignArgs, drives: &[LoopDrive], wanted: usize) -> ClosedLoop {
    let controllers: Vec<String> = args.controllers.iter().map(|name| name.name().to_owned()).collect();
    closed_loop_table(drives, &controllers, &args.conditions(), wanted as u64)
}

fn write_table(folder: &ClosedLoopFolder, table: &ClosedLoop) -> Result<()> {
    let input = ClosedLoopInput {
        table,
        again: "fingerpost campaign --closed-loop --drives 1 --reports --out DIR",
        written_by: WRITTEN_BY_PROGRAM,
    };
    Ok(folder.write_table(table, &closed_loop_html(&input))?)
}

/// Columns of the table. Errors are distances from the middle of the lane, median and 95th percentile, metres.
const TABLE_HEAD: &str = "\
controller    conditions    drives  arrived  straight, m    junctions, m   wheel  off the road
                                              p50    p95      p50    p95     off  unsaid        not arrived";

fn print_table(table: &ClosedLoop) {
    TABLE_HEAD.lines().for_each(output::message);
    table.groups.iter().for_each(|group| output::message(&line(group)));
    for drive in &table.not_arrived {
        output::message(&format!(
            "{} at {:.0} of {:.0} m ({}): --drives 1 --seed {} --conditions {} --controllers {} --reports shows it",
            drive.end.words(),
            drive.end_m,
            drive.route_m,
            drive.error.as_deref().unwrap_or(&drive.because),
            drive.seed,
            drive.conditions,
            drive.controller
        ));
    }
}

fn line(group: &LoopGroup) -> String {
    let LoopGroup { controller, drives, wheel_off_drives, claimed_off_drives, .. } = group;
    let name = group.conditions.as_deref().unwrap_or("all");
    let errors = |errors: Option<ErrorQuantiles>| {
        errors.map_or(["-".to_owned(), "-".to_owned()], |m| [m.p50, m.p95].map(|m| format!("{m:.2}")))
    };
    let ([s50, s95], [j50, j95]) = (errors(group.straight_m), errors(group.junction_m));
    let arrived = 100.0 * group.arrived as f64 / (*drives).max(1) as f64;
    let ends = group.ends.iter().filter(|(end, _)| *end != LoopEnd::Arrived);
    let ends: Vec<String> = ends.map(|(end, count)| format!("{count} {}", end.words())).collect();
    format!(
        "{controller:<13} {name:<13} {drives:>6}  {arrived:>5.1} %  {s50:>5}  {s95:>5}    {j50:>5}  {j95:>5}  {wheel_off_drives:>6}  \
         {claimed_off_drives:>6}  {}",
        ends.join(", ")
    )
}
