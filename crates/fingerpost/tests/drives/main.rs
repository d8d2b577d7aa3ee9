//! The method on painted, drawn and simulated drives, stage by stage and as a whole.

#[path = "../covered/mod.rs"]
mod covered;
#[path = "../painted/mod.rs"]
mod painted;
#[path = "../simulated/mod.rs"]
mod simulated;

mod advice;
mod belief;
mod bends;
mod camera_faults;
mod centreline;
mod confirmed_by_nothing;
mod decisions;
mod directions;
mod drive;
mod driving_line;
mod mask_curve;
mod matching;
mod memory;
mod motion_accuracy;
mod motion_doubt;
mod own_stages;
mod reach;
mod scenarios;
mod steering;
mod turned_camera;
mod turning_circles;
