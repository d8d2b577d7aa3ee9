//! What the program writes into which kind of folder; nothing else in a folder is ever removed.

use std::{
    fmt, fs,
    path::{Component, Path},
};

use serde::{Deserialize, Serialize};

use crate::{
    file::{FileError, remove_if_there},
    output_folder::{OutputFolderError, marked_kind, remove_marker},
    picture_folder::{FRAMES_FOLDER, TIMES_FILE},
};

/// Name of the file of a drive's truth, and of truth made of marks.
pub(crate) const TRUTH_FILE: &str = "truth.jsonl";
/// Name of the file of the moments in which a wheel crosses a line.
pub const CROSSINGS_FILE: &str = "crossings.jsonl";
/// Names of the vehicle's bus as a drive holds it: the log, its database, and the settings that name its signals.
pub(crate) const BUS_FILES: [&str; 3] = ["can.log", "car.dbc", "can.toml"];
/// A drive's camera.
pub(crate) const CAMERA_FILE: &str = "camera.toml";
/// A drive's GPS positions.
pub(crate) const GPS_FILE: &str = "gps.gpx";
/// A drive's speed and yaw rate.
pub(crate) const MOTION_FILE: &str = "motion.csv";
/// A drive's true poses.
pub(crate) const POSES_FILE: &str = "poses.csv";
/// Folder of the heights of a drive's ground.
pub(crate) const HEIGHTS_FOLDER: &str = "heights";
/// Folder of what the pixels of a drive's frames show.
pub(crate) const CLASSES_FOLDER: &str = "classes";
/// Folder of the road-surface masks of a drive.
pub(crate) const MASKS_FOLDER: &str = "road_masks";
/// File of the fixes from a motion log.
pub const FIXES_FILE: &str = "fix.jsonl";
/// File of a run's frames.
pub(crate) const FRAMES_FILE: &str = "frames.jsonl";
/// A run for viewers.
pub(crate) const RECORDING_FILE: &str = "run.mcap";
/// Folder of a run's pictures.
pub(crate) const PICTURES_FOLDER: &str = "pictures";
/// Folder of a marked video's pictures.
pub const MARKED_FRAMES_FOLDER: &str = "marked_frames";

/// File of what a search of settings is about.
pub(crate) const SETUP_FILE: &str = "setup.json";
/// File of its trials.
pub(crate) const TRIALS_FILE: &str = "trials.jsonl";
/// File of its result.
pub(crate) const FRONT_FILE: &str = "front.json";
/// Folder of the drives that it simulated.
pub(crate) const DRIVES_FOLDER: &str = "drives";

/// File of closed-loop drives, one a line.
pub(crate) const CLOSED_LOOP_LINES_FILE: &str = "closed_loop.jsonl";
/// File of the table of closed-loop drives.
pub const CLOSED_LOOP_FILE: &str = "closed_loop.json";
/// File of a closed-loop drive's frames: what was advised, and where the vehicle was.
pub const LOOP_FRAMES_FILE: &str = "loop.jsonl";
/// Picture of a closed-loop drive from above.
pub const PLAN_FILE: &str = "plan.svg";

/// Folder of the plots of the papers' claims.
const PLOTS_FOLDER: &str = "papers";

/// Digits of a frame's number in a picture's name; longer numbers have more.
const FRAME_DIGITS: usize = 6;

/// Which results a folder holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FolderKind {
    /// A run of the method.
    Run,
    /// A run in a campaign, with its route and truth.
    CampaignRun,
    /// A simulated drive.
    Drive,
    /// A drive made of another's recording.
    ConvertedDrive,
    /// A campaign, with the folders of its runs.
    Campaign,
    /// Closed-loop drives, with the folders of their runs.
    ClosedLoop,
    /// A search of settings, with the drives that it simulated.
    Tuning,
    /// The papers' claims measured again.
    Papers,
    /// Marks of lane edges, and truth made of them.
    Marks,
    /// Fixes from a motion log.
    Location,
}

/// Whether a file of that name, without its ending, is one that the program writes into a folder of pictures.
type IsPicture = fn(&str) -> bool;

impl fmt::Display for FolderKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Run => "a run",
            Self::CampaignRun => "a run of a campaign",
            Self::Drive => "a simulated drive",
            Self::ConvertedDrive => "a converted drive",
            Self::Campaign => "a campaign",
            Self::ClosedLoop => "closed-loop drives",
            Self::Tuning => "a search of settings",
            Self::Papers => "measurements of the papers' claims",
            Self::Marks => "lane marks",
            Self::Location => "fixes from a motion log",
        })
    }
}

impl FolderKind {
    /// Names of the files.
    fn files(self) -> &'static [&'static str] {
        match self {
            Self::Run => {
                &["config.toml", FRAMES_FILE, "summary.json", "report.html", "annotated.mp4", RECORDING_FILE]
            }
            Self::CampaignRun => &[
                "config.toml",
                FRAMES_FILE,
                "summary.json",
                "report.html",
                "route.geojson",
                TRUTH_FILE,
                LOOP_FRAMES_FILE,
                PLAN_FILE,
                "annotated.mp4",
            ],
            Self::Drive => &[
                TIMES_FILE,
                TRUTH_FILE,
                CROSSINGS_FILE,
                "camera.toml",
                "route.geojson",
                "can.log",
                "car.dbc",
                "can.toml",
            ],
            Self::ConvertedDrive => &[TIMES_FILE, CAMERA_FILE, GPS_FILE, MOTION_FILE, POSES_FILE],
            Self::Campaign => &["campaign.json"],
            Self::ClosedLoop => &[SETUP_FILE, CLOSED_LOOP_LINES_FILE, CLOSED_LOOP_FILE, "report.html"],
            Self::Tuning => &[SETUP_FILE, TRIALS_FILE, FRONT_FILE, "report.html"],
            Self::Papers => &["papers.md", "measured.jsonl"],
            Self::Marks => &["marks.json", TRUTH_FILE, "tusimple.json"],
            Self::Location => &[
                FIXES_FILE,
                "summary.json",
                "report.html",
                "track.geojson",
                "track.gpx",
                "poses_tum.txt",
                "poses_kitti.txt",
            ],
        }
    }

    /// Names of the folders of pictures, and which pictures are the program's.
    pub(crate) fn picture_folders(self) -> &'static [(&'static str, IsPicture)] {
        match self {
            Self::Run | Self::CampaignRun => &[(PICTURES_FOLDER, is_named_frame)],
            Self::Drive => &[
                (FRAMES_FOLDER, is_number),
                (MASKS_FOLDER, is_number),
                (HEIGHTS_FOLDER, is_number),
                (CLASSES_FOLDER, is_number),
            ],
            Self::ConvertedDrive => &[(FRAMES_FOLDER, is_number)],
            Self::Campaign | Self::ClosedLoop | Self::Tuning | Self::Location => &[],
            Self::Papers => &[(PLOTS_FOLDER, is_plot)],
            Self::Marks => &[(MARKED_FRAMES_FOLDER, is_number)],
        }
    }

    /// Whether a path in such a folder is where the program writes.
    pub(crate) fn writes(self, inside: &Path) -> bool {
        let Some(Component::Normal(first)) = inside.components().next() else { return false };
        let is = |name: &str| first == name;
        if self == Self::Tuning && (is(DRIVES_FOLDER) || first.to_str().is_some_and(is_numbered_config)) {
            return true;
        }
        self.files().iter().any(|name| is(name)) || self.picture_folders().iter().any(|(name, _)| is(name))
    }

    /// Removes the results in such a folder.
    pub(crate) fn remove_results(self, path: &Path) -> Result<(), OutputFolderError> {
        for name in self.files() {
            remove_if_there(&path.join(name))?;
        }
        for (name, is_ours) in self.picture_folders() {
            remove_pictures(&path.join(name), *is_ours)?;
        }
        match self {
            Self::Campaign | Self::ClosedLoop => remove_campaign_runs(path)?,
            Self::Tuning => remove_numbered_configs(path)?,
            Self::Run
            | Self::CampaignRun
            | Self::Drive
            | Self::ConvertedDrive
            | Self::Papers
            | Self::Marks
            | Self::Location => {}
        }
        Ok(())
    }
}

/// A plot of a claim, as in `order_road`.
fn is_plot(stem: &str) -> bool {
    !stem.is_empty() && stem.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'_')
}

/// A picture of a run, as in `frame_000150`.
fn is_named_frame(stem: &str) -> bool {
    stem.strip_prefix("frame_").is_some_and(is_number)
}

/// A picture of a drive, as in `000150`.
fn is_number(stem: &str) -> bool {
    stem.len() >= FRAME_DIGITS && stem.bytes().all(|byte| byte.is_ascii_digit())
}

/// A configuration of a search's front, as in `07.toml`.
fn is_numbered_config(name: &str) -> bool {
    let number = name.strip_suffix(".toml").unwrap_or_default();
    number.len() >= 2 && number.bytes().all(|byte| byte.is_ascii_digit())
}

/// Removes the configurations of an earlier front.
pub(crate) fn remove_numbered_configs(path: &Path) -> Result<(), FileError> {
    for entry in fs::read_dir(path).map_err(FileError::reading(path))? {
        let entry = entry.map_err(FileError::reading(path))?;
        if entry.file_name().to_str().is_some_and(is_numbered_config) {
            remove_if_there(&entry.path())?;
        }
    }
    Ok(())
}

/// Removes the pictures that an earlier command wrote, and the folder where nothing else is in it.
fn remove_pictures(folder: &Path, is_ours: IsPicture) -> Result<(), FileError> {
    if !folder.is_dir() {
        return Ok(());
    }
    let mut others = false;
    for entry in fs::read_dir(folder).map_err(FileError::reading(folder))? {
        let path = entry.map_err(FileError::reading(folder))?.path();
        let is_picture = path
            .extension()
            .is_some_and(|ending| ["png", "jpg", "jpeg", "ppm", "svg"].iter().any(|known| ending == *known));
        if is_picture && path.file_stem().and_then(|stem| stem.to_str()).is_some_and(is_ours) {
            remove_if_there(&path)?;
        } else {
            others = true;
        }
    }
    if others { Ok(()) } else { fs::remove_dir(folder).map_err(FileError::writing(folder)) }
}

/// Removes the runs of an earlier campaign, and their folders where nothing else is in them.
fn remove_campaign_runs(path: &Path) -> Result<(), OutputFolderError> {
    for entry in fs::read_dir(path).map_err(FileError::reading(path))? {
        let entry = entry.map_err(FileError::reading(path))?;
        let folder = entry.path();
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if is_folder && marked_kind(&folder)? == Some(FolderKind::CampaignRun) {
            FolderKind::CampaignRun.remove_results(&folder)?;
            remove_marker(&folder)?;
            // A folder in which something of the user's stays is left.
            let _ = fs::remove_dir(&folder);
        }
    }
    Ok(())
}
