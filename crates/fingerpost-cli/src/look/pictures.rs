//! The pictures of the drive that a run was made of.

use std::path::{Path, PathBuf};

use anyhow::Result;
use fingerpost_io::picture_paths;
use fingerpost_server::{Cause, Picture, Pictures};

use crate::picture_for_page;

/// Pictures of a folder; frames have their numbers in its order.
#[derive(Debug)]
pub(super) struct FolderPictures {
    paths: Vec<PathBuf>,
}

impl FolderPictures {
    /// Those of a folder of pictures or a drive folder.
    pub(super) fn open(folder: &Path) -> Result<Self> {
        Ok(Self { paths: picture_paths(folder)? })
    }
}

impl Pictures for FolderPictures {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        let path = usize::try_from(frame).ok().and_then(|index| self.paths.get(index));
        let pictures = self.paths.len();
        let no_such = || {
            format!("--input holds {pictures} pictures and none of frame {frame}; give the run's own input")
        };
        picture_for_page::of_file(path.ok_or_else(no_such)?)
    }
}
