//! The drives that settings are tried on: folders as they are, or simulated once into the search's own.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use fingerpost::vehicle::VehicleConfig;
use fingerpost_format::{CampaignDrive, TruthRecord, camera_to_toml};
use fingerpost_geometry::Camera;
use fingerpost_io::{DriveFolder, FrameFormat, TuningFolder};
use fingerpost_map::{Route, write_route};
use indicatif::ProgressBar;
use rayon::prelude::*;

use crate::campaign::{Drawing, Plan};
use crate::inputs;
use crate::interrupt::Interrupt;

/// Names in a drive folder.
const TRUTH: &str = "truth.jsonl";
const TIMES: &str = "times.txt";

/// A drive with its truth, ready to be run on.
pub(super) struct TuneDrive {
    /// Where its pictures are.
    pub(super) folder: PathBuf,
    /// What it is called in tallies: its number in the order given stands for a seed where it has none.
    pub(super) named: CampaignDrive,
    pub(super) camera: Camera,
    pub(super) route: Route,
    pub(super) start_m: Option<f64>,
    pub(super) vehicle: VehicleConfig,
    pub(super) truth: Vec<TruthRecord>,
}

/// The vehicle that a file of settings describes; none where it says nothing of it.
fn vehicle_of(settings: &Path) -> Result<Option<VehicleConfig>> {
    let config = inputs::config(Some(settings))?;
    let named: toml::Table = fingerpost_io::read_text(settings)?.parse()?;
    Ok(named.contains_key("vehicle").then_some(config.vehicle))
}

impl TuneDrive {
    /// A drive folder, such as `simulate` writes; the vehicle is that of its `can.toml` where that names one, else `vehicle`.
    pub(super) fn open(
        folder: &Path,
        number: u64,
        start_m: Option<f64>,
        vehicle: &VehicleConfig,
    ) -> Result<Self> {
        if !folder.join(TRUTH).is_file() {
            bail!(
                "{} holds no {TRUTH}, without which nothing can be measured; give drive folders of `fingerpost simulate`, or ones \
                 with a truth of their own",
                folder.display()
            );
        }
        let settings = folder.join("can.toml");
        let own_vehicle = if settings.is_file() { vehicle_of(&settings)? } else { None };
        let vehicle = own_vehicle.unwrap_or_else(|| vehicle.clone());
        let conditions = folder.display().to_string();
        Ok(Self {
            folder: folder.to_owned(),
            named: CampaignDrive { seed: number, conditions, ..CampaignDrive::default() },
            camera: inputs::camera(&folder.join("camera.toml"))?,
            route: inputs::route(&folder.join("route.geojson"))?,
            start_m,
            vehicle,
            truth: inputs::truth(&folder.join(TRUTH))?,
        })
    }

    /// The drive of a seed: simulated, unless that was done before.
    pub(super) fn simulate(
        drawing: &Drawing,
        (seed, conditions): (u64, &str),
        out: &TuningFolder,
        interrupt: &Interrupt,
    ) -> Result<Self> {
        let plan = Plan::new(drawing, seed, conditions)?;
        let folder = out.drive(&format!("{conditions}_{seed}"))?;
        // Written last, so that what has it is whole.
        if !folder.join(TIMES).is_file() {
            render(&plan, &folder, interrupt)
                .with_context(|| format!("the drive of seed {seed} ({conditions})"))?;
        }
        Ok(Self {
            truth: inputs::truth(&folder.join(TRUTH))?,
            folder,
            named: CampaignDrive { seed, conditions: conditions.to_owned(), ..CampaignDrive::default() },
            camera: plan.camera,
            route: plan.route,
            start_m: Some(plan.start_m),
            vehicle: plan.config.vehicle,
        })
    }
}

/// Writes a drive as a folder.
fn render(plan: &Plan, path: &Path, interrupt: &Interrupt) -> Result<()> {
    let mut folder = DriveFolder::create(path, FrameFormat::Jpeg)?;
    folder.write_camera(&camera_to_toml(&plan.camera)?)?;
    folder.write_route(&write_route(&plan.route)?)?;
    let frames = plan.simulator.frames();
    // Enough frames in hand to keep every core busy, few enough to fit into any memory.
    let at_once = 2 * rayon::current_num_threads();
    for first in (0..frames).step_by(at_once) {
        if interrupt.wanted() {
            bail!("interrupted");
        }
        let batch = (first..frames.min(first + at_once)).into_par_iter();
        let truths = batch.map(|index| {
            let frame = plan.simulator.frame(index);
            folder.write_frame(index as u64, &frame.picture)?;
            Ok(frame.truth)
        });
        truths.collect::<Result<Vec<_>>>()?.iter().try_for_each(|truth| folder.append(truth))?;
    }
    Ok(folder.finish()?)
}

/// All drives of a campaign, one after the other: each is rendered by all cores.
pub(super) fn simulate_all(
    drawing: &Drawing,
    drives: &[(u64, String)],
    out: &TuningFolder,
    interrupt: &Interrupt,
    bar: &ProgressBar,
) -> Result<Vec<TuneDrive>> {
    let simulated = drives.iter().map(|(seed, conditions)| {
        if interrupt.wanted() {
            bail!("interrupted");
        }
        let drive = TuneDrive::simulate(drawing, (*seed, conditions.as_str()), out, interrupt);
        bar.inc(1);
        drive
    });
    simulated.collect()
}
