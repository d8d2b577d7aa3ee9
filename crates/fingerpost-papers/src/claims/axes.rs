//! What is varied: one setting at a time, all others as in `papers.toml`.

use fingerpost::Config;
use fingerpost::motion::MotionMethod;
use fingerpost::road_surface::RoadPicture;

use super::drives::{RENDERED_FPS, SIZE_PX};

/// A setting with its values.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    /// Name in the file of measurements.
    pub(super) name: &'static str,
    /// What it is called on the page.
    pub(super) label: &'static str,
    /// Values that are tried.
    pub(super) values: &'static [f64],
    /// What the values are called where they are no numbers.
    pub(super) names: &'static [&'static str],
    /// The value of `papers.toml`.
    pub(super) base: f64,
    change: Change,
}

/// How a value takes effect.
#[derive(Debug, Clone, Copy)]
enum Change {
    /// As a setting.
    Setting(fn(&mut Config, f64)),
    /// As the width of the pictures, pixels.
    Width,
    /// As frames a second.
    Rate,
    /// As the motion estimator.
    Estimator,
    /// Both are measured on the same run.
    Reading,
}

/// A way to run the method on a drive.
#[derive(Debug, Clone)]
pub struct Variant {
    /// Name in the file of measurements.
    pub name: String,
    /// The settings.
    pub config: Config,
    /// Width of the pictures, pixels.
    pub width: usize,
    /// Every so many rendered frames one is used.
    pub every: usize,
    /// Whether the motion is that of [`super::SparseFlow`], not the settings'.
    pub sparse_flow: bool,
    /// Whether the masks are compared on it.
    pub reads_masks: bool,
}

pub(super) const ORDER: Axis = Axis {
    name: "order",
    label: "order of the stages",
    values: &[0.0, 1.0],
    names: &["ground view first", "detector first"],
    base: 0.0,
    change: Change::Setting(|config, value| {
        config.road_surface.picture = if value > 0.5 { RoadPicture::Camera } else { RoadPicture::GroundView };
    }),
};

pub(super) const MASKS: Axis = Axis {
    name: "masks",
    label: "mask",
    values: &[0.0, 1.0],
    names: &["sub-masks", "one whole mask"],
    base: 0.0,
    change: Change::Reading,
};

pub(super) const FLOW: Axis = Axis {
    name: "flow",
    label: "motion by",
    values: &[0.0, 1.0, 2.0],
    names: &["Farneback, mean", "Lucas-Kanade, mean", "direct alignment"],
    base: 0.0,
    change: Change::Estimator,
};

/// Paper 2, 2, 1.2: "from 512px to 150px widths".
pub(super) const WIDTH: Axis = Axis {
    name: "width",
    label: "picture width, pixels",
    values: &[150.0, 256.0, 384.0, 512.0],
    names: &[],
    base: SIZE_PX[0] as f64,
    change: Change::Width,
};

/// Paper 2, 2, 1.3: "as low as 10Hz"; 5 to 30 as cameras have them.
pub(super) const RATE: Axis = Axis {
    name: "rate",
    label: "frames a second",
    values: &[5.0, 10.0, 15.0, 30.0],
    names: &[],
    base: 10.0,
    change: Change::Rate,
};

/// Longest region of the flow that the configuration allows, metres.
const LONGEST_FLOW_M: f64 = 20.0;

/// Paper 2, 6: "in the order of 15-20 m", against "approximately 100m".
pub(super) const REACH: Axis = Axis {
    name: "reach",
    label: "ground view's far limit, metres",
    values: &[10.0, 15.0, 20.0, 40.0, 100.0],
    names: &[],
    base: 20.0,
    change: Change::Setting(|config, far_m| {
        let view = &mut config.ground_view;
        // The papers' picture keeps its size, so that a longer road is shown smaller; finer than by default the camera
        // shows nothing more.
        let grown = ((far_m - view.near_m) / (view.far_m - view.near_m)).max(1.0);
        view.metres_per_pixel *= grown;
        view.far_m = far_m;
        // So does the region of the flow, which is measured in pixels; its length has a limit.
        let flow = &mut config.motion.farneback;
        flow.region_width_m *= grown;
        flow.region_length_m = (flow.region_length_m * grown).min(LONGEST_FLOW_M);
    }),
};

/// Paper 2, 2, 3.2: "25% of the vehicle width".
pub(super) const MASK_WIDTH: Axis = Axis {
    name: "mask_width",
    label: "mask width, % of the vehicle's",
    values: &[10.0, 25.0, 50.0, 100.0],
    names: &[],
    base: 25.0,
    change: Change::Setting(|config, percent| config.feature_mask.arm_width_share = percent / 100.0),
};

/// Paper 1, IV-B: "considers the previous five frames".
pub(super) const HISTOGRAMS: Axis = Axis {
    name: "histograms",
    label: "histograms in the rolling mean",
    values: &[1.0, 3.0, 5.0, 10.0],
    names: &[],
    base: 5.0,
    change: Change::Setting(|config, frames| config.road_surface.backprojection.frames = frames as usize),
};

/// All of them.
pub(super) const AXES: [Axis; 8] = [ORDER, MASKS, FLOW, WIDTH, RATE, REACH, MASK_WIDTH, HISTOGRAMS];

/// Name of the run with the settings as they are.
const BASE: &str = "base";

impl Axis {
    /// Name of the run that a value is measured on.
    fn run(&self, value: f64) -> String {
        if self.is_base(value) { BASE.to_owned() } else { format!("{}_{value}", self.name) }
    }

    /// Name under which a metric of a value is measured.
    pub(super) fn key(&self, value: f64, metric: &str) -> String {
        match self.change {
            Change::Reading => format!("{BASE}.{metric}_{value}"),
            _ => format!("{}.{metric}", self.run(value)),
        }
    }

    fn is_base(&self, value: f64) -> bool {
        (value - self.base).abs() < f64::EPSILON || matches!(self.change, Change::Reading)
    }

    /// What a value is called.
    pub(super) fn value_name(&self, value: f64) -> String {
        self.names.get(value as usize).map_or_else(|| value.to_string(), |&name| name.to_owned())
    }

    /// The run with a value in place of that of `papers.toml`.
    fn variant(&self, base: &Variant, value: f64) -> Variant {
        let mut variant = Variant { name: self.run(value), reads_masks: false, ..base.clone() };
        match self.change {
            Change::Setting(change) => change(&mut variant.config, value),
            Change::Width => variant.width = value as usize,
            Change::Rate => variant.every = (RENDERED_FPS / value).round() as usize,
            Change::Estimator if value > 1.5 => variant.config.motion.estimator = MotionMethod::Direct,
            Change::Estimator => variant.sparse_flow = true,
            Change::Reading => {}
        }
        variant
    }
}

/// Every run on a drive: the settings as they are, and each value of each axis beside them.
pub fn variants(config: &Config) -> Vec<Variant> {
    let base = Variant {
        name: BASE.to_owned(),
        config: config.clone(),
        width: SIZE_PX[0],
        every: (RENDERED_FPS / RATE.base).round() as usize,
        sparse_flow: false,
        reads_masks: true,
    };
    let others = AXES.iter().flat_map(|axis| {
        let values = axis.values.iter().filter(|value| !axis.is_base(**value));
        values.map(|value| axis.variant(&base, *value)).collect::<Vec<_>>()
    });
    let others: Vec<Variant> = others.collect();
    [base].into_iter().chain(others).collect()
}
