//! The file that changed settings are saved in.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::Result;
use fingerpost::Config;
use fingerpost_io::write_file;
use fingerpost_look::SavedSettings;

use crate::changed_settings::differences_to_toml;
use crate::made_from;
use crate::output_path::{self, FileKind};
use crate::version::WRITTEN_BY;

/// Where settings are saved, and what a drive is run from with them.
#[derive(Debug)]
pub(in crate::look) struct SettingsFile {
    path: PathBuf,
    /// What a drive is run from beside them, and what the page is made from.
    inputs: Vec<PathBuf>,
    /// The arguments of `run` before them.
    arguments: Vec<OsString>,
}

impl SettingsFile {
    /// A file of that path, which is none of `kept`; of what a drive is run from, what is known.
    pub(in crate::look) fn at(
        path: &Path,
        kept: Vec<PathBuf>,
        [input, camera, route]: [Option<&Path>; 3],
    ) -> Self {
        let mut arguments = vec![input.unwrap_or(Path::new("DRIVE")).as_os_str().to_owned()];
        for (option, value) in [("--camera", camera), ("--route", route)] {
            arguments
                .extend(value.into_iter().flat_map(|value| [option.into(), value.as_os_str().to_owned()]));
        }
        let mut inputs = kept;
        inputs.extend([input, camera, route].into_iter().flatten().map(Path::to_owned));
        Self { path: path.to_owned(), inputs, arguments }
    }

    /// Refuses one that may be the user's.
    pub(super) fn check(&self) -> Result<()> {
        output_path::check_file(&self.path, FileKind::Settings, self.inputs.iter().map(PathBuf::as_path))
    }

    /// Saves what differs from the default settings.
    pub(super) fn save(&self, config: &Config) -> Result<SavedSettings> {
        self.check()?;
        let text = differences_to_toml(config, &Config::default());
        write_file(&self.path, format!("{WRITTEN_BY}{text}"))?;
        let words =
            ["fingerpost", "run"].map(OsString::from).into_iter().chain(self.arguments.iter().cloned());
        let words = words.chain(["--config".into(), self.path.clone().into()]);
        let command = format!("{} --out run", made_from::command_line(words));
        Ok(SavedSettings { file: self.path.display().to_string(), command })
    }
}
