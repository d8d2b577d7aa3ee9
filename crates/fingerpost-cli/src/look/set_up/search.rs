//! The search for the mount in the whole drive, in a thread of its own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use anyhow::Result;
use fingerpost_calibration::KnownScale;
use fingerpost_geometry::Camera;
use fingerpost_io::{FfmpegPrograms, SourceOptions};
use fingerpost_look::SearchState;
use fingerpost_server::Cause;
use indicatif::{ProgressBar, ProgressDrawTarget};

use crate::inputs;
use crate::mount_search::{FoundMount, MountSearch};

/// What `calibrate mount` does, while the page is used.
pub(super) struct SearchInDrive {
    drive: String,
    /// What the calibration of the camera is from.
    camera_source: String,
    /// The search that was begun last; none where it was stopped.
    last: Mutex<Option<Search>>,
}

/// A search in its thread.
#[derive(Clone)]
struct Search {
    stop: Arc<AtomicBool>,
    /// Shown by nobody here; it counts the frames.
    bar: ProgressBar,
    /// What came of it, once it has ended.
    end: Arc<Mutex<Option<SearchState>>>,
}

impl SearchInDrive {
    /// One that has not begun.
    pub(super) fn new(drive: String, camera_source: String) -> Self {
        Self { drive, camera_source, last: Mutex::new(None) }
    }
}

impl Search {
    fn begin(drive: String, camera: Camera, camera_source: String) -> Result<Self, Cause> {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let search = Self { stop: Arc::default(), bar, end: Arc::default() };
        let inner = search.clone();
        let work = move || {
            let found = inner.find(&drive, camera, &camera_source);
            *inner.end.lock().unwrap_or_else(PoisonError::into_inner) = Some(end(found));
        };
        thread::Builder::new().name("mount search".to_owned()).spawn(work)?;
        Ok(search)
    }

    fn find(&self, drive: &str, camera: Camera, camera_source: &str) -> Result<FoundMount> {
        let programs = FfmpegPrograms { stop: Some(Arc::clone(&self.stop)), ..inputs::ffmpeg() };
        let pass = |frames: Option<u64>| {
            self.bar.set_position(0);
            frames.map_or_else(|| self.bar.unset_length(), |frames| self.bar.set_length(frames));
            self.bar.clone()
        };
        let search = MountSearch {
            input: drive,
            options: SourceOptions { programs, ..SourceOptions::default() },
            frames: None,
            known: KnownScale::Nothing,
            lane_width_m: None,
            stop: &self.stop,
            bar: &pass,
        };
        search.find(camera, camera_source)
    }

    fn state(&self) -> SearchState {
        let end = self.end.lock().unwrap_or_else(PoisonError::into_inner).clone();
        end.unwrap_or_else(|| SearchState::Running { frames: self.bar.position(), of: self.bar.length() })
    }
}

/// What the page is told of the end.
fn end(found: Result<FoundMount>) -> SearchState {
    match found {
        Ok(found) => {
            let said = found.lines().into_iter().chain([found.frames_line()]).collect();
            SearchState::Found { mount: found.calibration.mount, said }
        }
        Err(cause) => SearchState::Failed { cause: format!("{cause:#}") },
    }
}

impl fingerpost_look::MountSearch for SearchInDrive {
    fn begin(&self, camera: &Camera) -> Result<(), Cause> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.as_ref().is_some_and(|search| matches!(search.state(), SearchState::Running { .. })) {
            return Err("a calibration goes on already; stop it, or wait for its end".into());
        }
        *last = Some(Search::begin(self.drive.clone(), camera.clone(), self.camera_source.clone())?);
        Ok(())
    }

    fn stop(&self) {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(search) = last {
            search.stop.store(true, Ordering::SeqCst);
        }
    }

    fn state(&self) -> SearchState {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.as_ref().map_or(SearchState::Idle, Search::state)
    }
}
