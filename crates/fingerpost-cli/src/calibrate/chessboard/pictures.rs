//! The pictures of a board: which there are, their size, and the corners in each.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use fingerpost_io::{picture_paths, read_picture};
use fingerpost_vision::chessboard::{BoardSize, ChessboardError, find_chessboard};
use fingerpost_vision::colour;
use fingerpost_vision::picture::Plane;
use rayon::prelude::*;

use crate::output;

/// A picture that was looked at.
#[derive(Debug)]
pub(super) struct Looked {
    pub(super) name: String,
    /// Width and height, pixels; none where it cannot be read.
    pub(super) size: Option<(usize, usize)>,
    /// The board's corners, or why there are none.
    pub(super) corners: Result<Vec<[f64; 2]>, String>,
    /// Inner corners along and across another board that is seen in the place of the one that is looked for.
    pub(super) other_board: Option<(usize, usize)>,
}

/// Refuses pictures more of which show another board than the one that is looked for: the few that show that one have a part of the other
/// in view, and fix no lens.
pub(super) fn check_board(looked: &[Looked], board: BoardSize) -> Result<()> {
    let asked = looked.iter().filter(|looked| looked.corners.is_ok()).count();
    let mut counts: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for other in looked.iter().filter_map(|looked| looked.other_board) {
        *counts.entry(other).or_default() += 1;
    }
    let most = counts.into_iter().max_by_key(|(_, count)| *count).filter(|(_, count)| *count > asked);
    let Some(((columns, rows), count)) = most else {
        return Ok(());
    };
    bail!(
        "{} a board of {}x{} inner corners; one of {columns}x{rows} is seen in {count} of {}; give --corners {columns}x{rows} if that is \
         the board",
        match asked {
            0 => "no picture shows".to_owned(),
            1 => "1 picture shows".to_owned(),
            _ => format!("{asked} pictures show"),
        },
        board.columns(),
        board.rows(),
        looked.len()
    )
}

/// The pictures that are meant, folders replaced by what they hold, each file once: twice it would count as two views.
pub(super) fn paths_of(given: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut paths = Vec::new();
    for path in given {
        if path.is_dir() {
            paths.extend(picture_paths(path)?);
        } else if path.exists() {
            paths.push(path.clone());
        } else {
            bail!("{} does not exist; check the path", path.display());
        }
    }
    let mut known = BTreeSet::new();
    let mut once = Vec::new();
    for path in paths {
        let file = path.canonicalize().with_context(|| path.display().to_string())?;
        if known.insert(file) {
            once.push(path);
        }
    }
    Ok(once)
}

/// Looks for the board in every picture, in their order.
pub(super) fn look_at_all(paths: &[PathBuf], board: BoardSize) -> Vec<Looked> {
    let bar = output::progress(Some(paths.len() as u64), "pictures");
    let look = |path: &PathBuf| {
        let looked = look_at(path, board);
        bar.inc(1);
        looked
    };
    let looked = paths.par_iter().map(look).collect();
    bar.finish_and_clear();
    looked
}

fn look_at(path: &Path, board: BoardSize) -> Looked {
    let name = path.display().to_string();
    let picture = match read_picture(path) {
        Ok(picture) => picture,
        Err(cause) => return Looked { name, size: None, corners: Err(cause.to_string()), other_board: None },
    };
    let (width, height) = picture.size();
    let mut grey = Plane::new(width, height, 0);
    let grey = colour::grey(&picture, &mut grey).map_err(ChessboardError::from).map(|()| grey);
    let corners = grey.and_then(|grey| find_chessboard(grey.view(), board));
    let other_board = corners.as_ref().err().and_then(ChessboardError::other_board);
    Looked {
        name,
        size: Some((width, height)),
        corners: corners.map_err(|cause| cause.to_string()),
        other_board,
    }
}
