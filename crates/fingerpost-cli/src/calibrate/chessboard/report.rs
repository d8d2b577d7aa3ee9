//! What is said of a calibration.

use fingerpost_calibration::{BoardOutcome, LensCalibration};
use serde::Serialize;

use super::pictures::Looked;
use crate::output;

/// A value with its standard deviation.
#[derive(Debug, Clone, Copy, Serialize)]
struct Printed {
    value: f64,
    sigma: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    width: usize,
    height: usize,
    /// Pixels.
    fx: Printed,
    fy: Printed,
    cx: Printed,
    cy: Printed,
    distortion: Coefficients,
    /// Root mean square distance of all corners used, pixels.
    rms_px: f64,
    pictures_used: usize,
    pictures: Vec<Picture>,
}

/// Brown-Conrady coefficients.
#[derive(Debug, Clone, Copy, Serialize)]
struct Coefficients {
    k1: Printed,
    k2: Printed,
    p1: Printed,
    p2: Printed,
    k3: Printed,
}

/// What became of a picture.
#[derive(Debug, Serialize)]
struct Picture {
    name: String,
    used: bool,
    /// Root mean square distance of its corners, pixels; none where no whole board was found.
    rms_px: Option<f64>,
    /// Angle between the board and a plane that faces the camera squarely, degrees.
    tilt_deg: Option<f64>,
    /// Distance of the board's first corner; none where the squares' side is not known.
    distance_m: Option<f64>,
    /// Why it was left out.
    reason: Option<String>,
}

/// Names the pictures without a whole board.
pub(super) fn say_dropped(looked: &[Looked]) {
    for Looked { name, corners, .. } in looked {
        if let Err(reason) = corners {
            output::message(&format!("left out: {name}: {reason}"));
        }
    }
}

/// Names the pictures with a row or column more or less than most.
pub(super) fn say_other_sizes(looked: &[Looked], (width, height): (usize, usize)) {
    for Looked { name, size, .. } in looked.iter().filter(|looked| looked.corners.is_ok()) {
        if let Some((w, h)) = size.filter(|&size| size != (width, height)) {
            output::message(&format!("{name} has {w} x {h} pixels and is used as one of {width} x {height}"));
        }
    }
}

impl Report {
    pub(super) fn new(
        lens: &LensCalibration,
        looked: &[Looked],
        (width, height): (usize, usize),
        square_m: Option<f64>,
    ) -> Self {
        let mut outcomes = lens.boards.iter();
        let pictures: Vec<_> = looked
            .iter()
            .map(|looked| match &looked.corners {
                Ok(_) => picture(&looked.name, outcomes.next(), square_m),
                Err(reason) => left_out(&looked.name, None, reason.clone()),
            })
            .collect();
        let (k, sigma) = (lens.intrinsics, lens.intrinsics_sigma);
        let printed = |value, sigma| Printed { value, sigma };
        let coefficient = |i: usize| printed(lens.coefficients[i], lens.coefficients_sigma[i]);
        Self {
            width,
            height,
            fx: printed(k.fx, sigma.fx),
            fy: printed(k.fy, sigma.fy),
            cx: printed(k.cx, sigma.cx),
            cy: printed(k.cy, sigma.cy),
            distortion: Coefficients {
                k1: coefficient(0),
                k2: coefficient(1),
                p1: coefficient(2),
                p2: coefficient(3),
                k3: coefficient(4),
            },
            rms_px: lens.rms_px,
            pictures_used: pictures.iter().filter(|picture| picture.used).count(),
            pictures,
        }
    }

    /// Says all that was not said before.
    pub(super) fn say(&self) {
        for picture in &self.pictures {
            self.say_picture(picture);
        }
        let Coefficients { k1, k2, p1, p2, k3 } = self.distortion;
        for (name, Printed { value, sigma }) in
            [("fx", self.fx), ("fy", self.fy), ("cx", self.cx), ("cy", self.cy)]
        {
            output::message(&format!("{name}: {value:.1} ± {sigma:.1} pixels"));
        }
        for (name, Printed { value, sigma }) in [("k1", k1), ("k2", k2), ("p1", p1), ("p2", p2), ("k3", k3)] {
            output::message(&format!("{name}: {value:.5} ± {sigma:.5}"));
        }
        let (used, all) = (self.pictures_used, self.pictures.len());
        output::message(&format!("{used} of {all} pictures, corners {:.2} pixels off (rms)", self.rms_px));
    }

    fn say_picture(&self, picture: &Picture) {
        let Picture { name, rms_px, tilt_deg, distance_m, reason, .. } = picture;
        match (rms_px, tilt_deg, reason) {
            (Some(rms_px), Some(tilt_deg), _) => {
                let away = distance_m.map_or(String::new(), |distance_m| format!(", {distance_m:.2} m away"));
                output::message(&format!("{name}: {rms_px:.2} pixels off, tilted by {tilt_deg:.0}°{away}"));
            }
            (Some(_), None, Some(reason)) => output::message(&format!("left out: {name}: {reason}")),
            _ => {}
        }
    }
}

fn picture(name: &str, outcome: Option<&BoardOutcome>, square_m: Option<f64>) -> Picture {
    match outcome {
        Some(used @ BoardOutcome::Used { camera_from_board, rms_px }) => Picture {
            name: name.to_owned(),
            used: true,
            rms_px: Some(*rms_px),
            tilt_deg: used.tilt_rad().map(f64::to_degrees),
            distance_m: square_m.map(|_| camera_from_board.translation.vector.norm()),
            reason: None,
        },
        Some(BoardOutcome::LeftOut { rms_px, median_px }) => {
            let reason = format!(
                "its corners are {rms_px:.2} pixels off, those of the others {median_px:.2} (median); is the board flat, and \
                 the picture sharp?"
            );
            left_out(name, Some(*rms_px), reason)
        }
        None => left_out(name, None, "it was not looked at".to_owned()),
    }
}

fn left_out(name: &str, rms_px: Option<f64>, reason: String) -> Picture {
    Picture {
        name: name.to_owned(),
        used: false,
        rms_px,
        tilt_deg: None,
        distance_m: None,
        reason: Some(reason),
    }
}
