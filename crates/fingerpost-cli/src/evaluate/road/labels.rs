//! Label pictures that belong to camera pictures.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use fingerpost_io::{picture_paths, read_picture};
use fingerpost_vision::picture::Plane;

/// The label files of `pictures`, in their order.
pub(super) fn labels_of(pictures: &[PathBuf], folder: &Path) -> Result<Vec<PathBuf>> {
    let stem = |path: &Path| path.file_stem().unwrap_or_default().to_owned();
    let mut labels: BTreeMap<_, _> =
        picture_paths(folder)?.into_iter().map(|path| (stem(&path), path)).collect();
    let of_picture = |path: &PathBuf| {
        labels.remove(&stem(path)).with_context(|| {
            let (picture, folder) = (path.display(), folder.display());
            format!("{picture} has no labels of its name in {folder}; give labels for every picture")
        })
    };
    let found = pictures.iter().map(of_picture).collect::<Result<Vec<_>>>()?;
    match labels.values().next() {
        Some(left_over) => {
            bail!("{} belongs to no picture; give the labels of these pictures", left_over.display())
        }
        None => Ok(found),
    }
}

pub(super) fn read_labels(path: &Path) -> Result<Plane<u8>> {
    let picture = read_picture(path)?;
    let (pixels, _) = picture.as_slice().as_chunks::<3>();
    if pixels.iter().any(|[red, green, blue]| red != green || red != blue) {
        bail!(
            "{} is a coloured picture; give labels as grey pictures, a pixel's value its label",
            path.display()
        );
    }
    let labels = pixels.iter().map(|[label, ..]| *label).collect();
    Ok(Plane::from_vec(picture.width(), picture.height(), labels)?)
}
