//! The bank of known surfaces on a drive from asphalt over concrete to gravel.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost::ground_view::GroundPicture;
use fingerpost::road_surface::{
    Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput, RoadMethod, RoadSurface,
    RoadSurfaceConfig, SurfaceFile, SurfacesError,
};
use fingerpost_papers::road_detector;
use fingerpost_vision::colour::{BinDivision, HueSaturationBins, grey_and_bins};
use fingerpost_vision::picture::{Rect, RgbImage, ValidityMask};

const WIDTH: usize = 160;
const HEIGHT: usize = 120;
/// Columns of the road.
const ROAD: std::ops::Range<usize> = 40..120;
const SAMPLE: Rect = Rect { x: 60, y: 90, width: 40, height: 30 };
/// Rows that the vehicle drives in a frame: more than the sample's, so that it is on another surface from one to the next.
const ROWS_A_FRAME: usize = 33;
const FRAMES_A_SURFACE: usize = 30;

const ASPHALT: [u8; 3] = [96, 97, 100];
const CONCRETE: [u8; 3] = [196, 186, 160];
const GRAVEL: [u8; 3] = [150, 132, 114];
const GRASS: [u8; 3] = [70, 120, 45];

/// The surface so many rows ahead of the drive's start.
fn surface_at(row: usize) -> [u8; 3] {
    let length = ROWS_A_FRAME * FRAMES_A_SURFACE;
    match row {
        row if row < length => ASPHALT,
        row if row < 2 * length => CONCRETE,
        _ => GRAVEL,
    }
}

/// What is seen, from above, in a frame of the drive.
fn picture(frame: usize, surface_at: impl Fn(usize) -> [u8; 3]) -> GroundPicture {
    let bins = HueSaturationBins { hue: 32, saturation: 32 };
    let mut picture = GroundPicture::new(WIDTH, HEIGHT, bins);
    let mut colour = RgbImage::new(WIDTH, HEIGHT);
    for row in 0..HEIGHT {
        let ahead = frame * ROWS_A_FRAME + HEIGHT - 1 - row;
        let (pixels, _) = colour.row_mut(row).as_chunks_mut::<3>();
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let base = if ROAD.contains(&column) { surface_at(ahead) } else { GRASS };
            let grain = ((ahead * 31 + column * 17 + ahead * column) % 13) as u8;
            *pixel = base.map(|channel| channel - 6 + grain);
        }
    }
    let division = BinDivision::new(bins).unwrap();
    grey_and_bins(&colour, &division, &mut picture.grey, &mut picture.bin).unwrap();
    picture.colour = colour;
    picture
}

/// A detector on the drive.
struct Watcher {
    detector: Box<dyn RoadDetector>,
    surface: RoadSurface,
    validity: ValidityMask,
}

impl Watcher {
    fn new(detector: RoadMethod) -> Self {
        let config = RoadSurfaceConfig { detector, ..RoadSurfaceConfig::default() };
        let validity = ValidityMask::all_seen(WIDTH, HEIGHT);
        Self { detector: road_detector(&config).unwrap(), surface: RoadSurface::default(), validity }
    }

    fn look(&mut self, picture: &GroundPicture) -> RoadEvidence {
        let perspective = Perspective::Camera { horizon_row: -1.0 };
        let input =
            RoadInput { picture, validity: &self.validity, sample: SAMPLE, perspective, motion: None };
        self.detector.detect(input, &mut self.surface).unwrap()
    }

    /// Mean probability of these columns of the rows next to be driven over, 0 to 1.
    fn mean(&self, columns: std::ops::Range<usize>) -> f64 {
        let count = columns.len() * SAMPLE.height;
        let rows = (SAMPLE.y..SAMPLE.y + SAMPLE.height)
            .map(|row| &self.surface.probability.row(row)[columns.clone()]);
        rows.flatten().map(|&p| f64::from(p)).sum::<f64>() / (255.0 * count as f64)
    }
}

/// Frames of the drive in which less than half of the probability of the road next to be driven over is left, and the names of its surfaces.
fn drive(watcher: &mut Watcher) -> (usize, Vec<String>) {
    let mut names: Vec<String> = Vec::new();
    let mut lost = 0;
    for frame in 0..3 * FRAMES_A_SURFACE {
        let evidence = watcher.look(&picture(frame, surface_at));
        lost += usize::from(watcher.mean(ROAD) < 0.5);
        assert!(watcher.mean(0..30) < 0.1, "frame {frame}: the grass is no road");
        let name = evidence.bank.and_then(|bank| bank.surface).map(|name| name.to_string());
        if let Some(name) = name.filter(|name| names.last() != Some(name)) {
            names.push(name);
        }
    }
    (lost, names)
}

#[test]
fn a_change_of_surface_loses_the_rolling_mean_and_not_the_bank() {
    let (lost, names) = drive(&mut Watcher::new(RoadMethod::Backprojection));
    assert!(lost >= 15 && names.is_empty(), "the rolling mean loses the road for {lost} frames");
    let mut bank = Watcher::new(RoadMethod::Bank);
    let (lost, names) = drive(&mut bank);
    assert!(lost <= 10, "lost for {lost} frames");
    assert_eq!(names, ["asphalt", "concrete", "gravel"]);
    // The second time they are all known.
    let (lost, again) = drive(&mut bank);
    assert_eq!((lost, again), (0, names));
}

#[test]
fn surfaces_survive_a_file_and_are_known_at_once() {
    let mut first = Watcher::new(RoadMethod::Bank);
    drive(&mut first);
    let mut file = first.detector.known_surfaces().unwrap();
    assert_eq!(file.surfaces.len(), 3);
    file.surfaces[1].name = "the bridge".to_owned();
    for detector in [RoadMethod::Bank, RoadMethod::Combined] {
        let mut second = Watcher::new(detector);
        second.detector.know(&file).unwrap();
        let bank = second.look(&picture(0, |_| CONCRETE)).bank.unwrap();
        assert_eq!((bank.surface.as_deref(), bank.founded, bank.surfaces), (Some("the bridge"), false, 3));
        assert!(bank.likeness > 0.9, "{bank:?}");
        assert!(detector != RoadMethod::Bank || second.mean(ROAD) > 0.9);
        let kept = second.detector.known_surfaces().unwrap();
        assert_eq!(kept.surfaces.iter().map(|surface| surface.frames).sum::<u64>(), {
            1 + file.surfaces.iter().map(|surface| surface.frames).sum::<u64>()
        });
        second.detector.reset();
        assert!(second.look(&picture(0, |_| CONCRETE)).bank.unwrap().founded);
    }
    assert!(Watcher::new(RoadMethod::Backprojection).detector.known_surfaces().is_none());
}

#[test]
fn a_file_that_cannot_be_used_is_refused_with_the_reason() {
    let mut watcher = Watcher::new(RoadMethod::Bank);
    drive(&mut watcher);
    let good = watcher.detector.known_surfaces().unwrap();
    let mut refused = |change: fn(&mut SurfaceFile)| {
        let mut file = good.clone();
        change(&mut file);
        match watcher.detector.know(&file) {
            Err(RoadError::Surfaces(cause)) => Some(cause),
            _ => None,
        }
    };
    let other = refused(|file| file.version = 9);
    assert_eq!(other, Some(SurfacesError::Version { found: 9, expected: 1 }));
    assert!(refused(|file| file.surfaces[0].histogram[0].1 = -1.0).is_some());
    assert!(refused(|file| file.surfaces[0].histogram[0].1 = f64::NAN).is_some());
    assert!(refused(|file| file.surfaces[0].histogram[0].0 = 1024).is_some());
    assert_eq!(refused(|_| ()), None);
}

#[test]
fn the_bank_is_bounded_and_the_surface_longest_unmet_gives_way() {
    let mut config = RoadSurfaceConfig { detector: RoadMethod::Bank, ..RoadSurfaceConfig::default() };
    config.bank.surfaces = 2;
    let mut watcher = Watcher { detector: road_detector(&config).unwrap(), ..Watcher::new(RoadMethod::Bank) };
    drive(&mut watcher);
    let names: Vec<String> =
        watcher.detector.known_surfaces().unwrap().surfaces.into_iter().map(|surface| surface.name).collect();
    assert_eq!(names, ["concrete", "gravel"]);
}
