//! The lane path, frame by frame without decoding: Fingerpost's lane finder against an OpenCV program with the steps of
//! paper 3: mean of the last frames, edges, their orientation, dilation, areas, thinning, Hough lines in sections, their
//! selection, and the spline. Fingerpost's also reads paint from the picture and follows the lane on the road.

use anyhow::{Context, Result};
use fingerpost::lanes::{Lane, LaneFinder, LaneInput, LaneRegion, LanesConfig, Side};
use fingerpost::vehicle_signals::VehicleState;
use fingerpost_geometry::{Camera, Pixel};
use fingerpost_sim::{Conditions, RoadCourse, SimConfig, Simulator, windscreen_camera};
use fingerpost_vision::picture::RgbImage;
use nalgebra::Point2;
use serde_json::json;

use crate::measure::{Contestant, Effort, median, side_by_side};
use crate::peer::{Array, OpenCv};
use crate::results::{Agreement, Row, Section};

/// Size of the frames, pixels.
const SIZE_PX: (usize, usize) = (640, 480);
/// Frames of the drive, which begins anew after the last.
const FRAMES: usize = 60;
/// Frames left out of the comparison, in which broken lines may not have shown yet.
const FIRST_FRAMES: usize = 10;
/// Speed on the motorway, m/s, and its length, metres: as far as the frames go and are seen.
const SPEED_MPS: f64 = 30.0;
const LENGTH_M: f64 = 1500.0;
/// How many times as fast as the OpenCV program the path is promised to be.
const PROMISED: f64 = 3.0;
/// Time of a frame that is promised, milliseconds.
const PROMISED_MS: f64 = 1.5;
/// Rows between two of the OpenCV program's points, pixels: Fingerpost's.
const POINT_ROWS: usize = 6;
/// Room for the horizon, share of the picture's height, and for an edge's direction, radians: Fingerpost's.
const HORIZON_SHARE: f64 = 0.035;
const DIRECTION_RAD: f64 = 0.14;
/// How far from the truth an edge may be in the middle of the frames for results to agree, pixels.
const AGREED_PX: f64 = 6.0;

/// Times the lane path, after comparing both with the drive's truth.
pub fn lanes(opencv: &mut OpenCv, effort: Effort) -> Result<Section> {
    let mut section = Section::new(
        "Lanes",
        "one thread, without decoding; a simulated motorway with broken lines, the region of interest alike",
    );
    let drive = Drive::simulate()?;
    drive.prepare(opencv)?;
    let agreement = drive.agreement(opencv)?;
    let size = format!("{} x {}", SIZE_PX.0, SIZE_PX.1);
    let what = "WHOLE LANE PATH";
    let mut row = Row::new(what, &size, Vec::new(), None);
    if effort.rounds > 0 {
        let mut contestants = vec![drive.contestant()?, opencv.contestant()];
        let measured = side_by_side(effort, &mut contestants)?;
        row = Row::new(what, &size, measured, Some(PROMISED));
        row.promised_ms = Some(PROMISED_MS);
        drop(contestants);
        let stages_ms = opencv.time(FRAMES)?.stages_ms;
        let laps = stages_ms.into_iter().map(|(name, mut laps)| format!("{name} {:.3}", median(&mut laps)));
        section.note += &format!("\nOpenCV's steps, ms: {}", laps.collect::<Vec<_>>().join(", "));
    }
    row.agreement = Some(agreement);
    section.rows.push(row);
    Ok(section)
}

/// A frame, what the vehicle's bus says with it, and the true columns of the lane's edges by rows.
struct Moment {
    picture: RgbImage,
    vehicle: VehicleState,
    edges_px: [Vec<[f64; 2]>; 2],
}

/// A simulated drive on a motorway.
struct Drive {
    camera: Camera,
    config: LanesConfig,
    moments: Vec<Moment>,
    dt_s: f64,
    region: LaneRegion,
}

impl Drive {
    fn simulate() -> Result<Self> {
        let (graph, route) = RoadCourse::highway(1, LENGTH_M).roads()?;
        let camera = windscreen_camera(SIZE_PX.0, SIZE_PX.1)?;
        let sim = SimConfig {
            conditions: Conditions::LANE_BROKEN,
            cruise_speed_mps: SPEED_MPS,
            start_m: LENGTH_M / 3.0,
            ..SimConfig::default()
        };
        let simulator = Simulator::new(&graph, &route, &camera, &sim)?;
        let moments = (0..FRAMES.min(simulator.frames())).map(|index| {
            let frame = simulator.frame(index);
            let vehicle = VehicleState {
                speed_mps: Some(frame.truth.speed_mps),
                yaw_rate_rps: Some(frame.truth.yaw_rate_rps),
                ..VehicleState::default()
            };
            let edges_px = [frame.truth.lane_left_px, frame.truth.lane_right_px];
            Moment { picture: frame.picture, vehicle, edges_px }
        });
        let moments: Vec<Moment> = moments.collect();
        // Lines are searched for as far as edges are read, as by the OpenCV program.
        let defaults = LanesConfig::default();
        let config = LanesConfig { least_range_m: defaults.most_range_m, ..defaults };
        let mut drive = Self { camera, config, moments, dt_s: 1.0 / sim.fps, region: LaneRegion::default() };
        let mut finder = LaneFinder::new(&drive.config)?;
        let evidence = finder.find(&drive.camera, &drive.input(0), &mut None)?;
        drive.region = evidence.region.clone();
        Ok(drive)
    }

    fn input(&self, index: usize) -> LaneInput<'_> {
        let moment = &self.moments[index];
        let dt_s = (index > 0).then_some(self.dt_s);
        LaneInput { frame: &moment.picture, dt_s, vehicle: &moment.vehicle, pitch_change: None }
    }

    /// Hands the frames over, with what the OpenCV program needs of the camera.
    fn prepare(&self, opencv: &mut OpenCv) -> Result<()> {
        let (width, height) = SIZE_PX;
        let bytes: Vec<u8> =
            self.moments.iter().flat_map(|moment| moment.picture.as_slice()).copied().collect();
        let frames = Array::of_u8(&[self.moments.len(), height, width, RgbImage::CHANNELS], &bytes);
        let rows: Vec<[f32; 6]> = (self.region.top_row..height)
            .map(|row| self.row_limits(row).context("a row of the region that shows no road"))
            .collect::<Result<_>>()?;
        let rows = Array::of_f32(&[rows.len(), 6], rows.as_flattened());
        let top = self.region.top_row;
        let sections = self.region.sections.iter().map(|&[upper, lower]| [upper - top, lower - top]);
        let parameters = json!({
            "top_row": top,
            "sections": sections.collect::<Vec<_>>(),
            "buffer_frames": self.config.buffer_frames,
            "canny_high": self.config.canny_high,
            "canny_low_share": self.config.canny_low_share,
            "slack_rows": HORIZON_SHARE * height as f64,
            "direction_rad": DIRECTION_RAD,
            "min_area_px": self.config.min_area_px,
            "keep_frames": self.config.keep_frames,
            "point_rows": POINT_ROWS,
        });
        opencv.prepare("lane_detection", &parameters, &[frames, rows])
    }

    /// Of a row: columns between which edges may lie, the column ahead, the horizon's stretch and row in the region.
    fn row_limits(&self, row: usize) -> Option<[f32; 6]> {
        const FAR_M: f64 = 2000.0;
        let middle = (SIZE_PX.0 - 1) as f64 / 2.0;
        let ahead_m = self.camera.ground_of_pixel(Pixel::new(middle, row as f64))?.x;
        let reach_m = self.config.max_offset_m + 0.1 * ahead_m;
        let most_rad = self.config.max_heading_deg.to_radians();
        let column = |left_m: f64| self.camera.pixel_of_ground(Point2::new(ahead_m, left_m)).map(|p| p.u);
        let far = |heading: f64| {
            self.camera.pixel_of_ground(Point2::new(FAR_M * libm::cos(heading), FAR_M * libm::sin(heading)))
        };
        let horizon_row = far(0.0)?.v - self.region.top_row as f64;
        let limits = [
            column(reach_m)?,
            column(-reach_m)?,
            column(0.0)?,
            far(most_rad)?.u,
            far(-most_rad)?.u,
            horizon_row,
        ];
        Some(limits.map(|limit| limit as f32))
    }

    /// Compares both with the truth in the middle of the region.
    fn agreement(&self, opencv: &mut OpenCv) -> Result<Agreement> {
        let mut finder = LaneFinder::new(&self.config)?;
        let mut lane = None;
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        let (top, base) = (self.region.top_row, SIZE_PX.1);
        // The OpenCV program's points lie in every so many rows, counted from the region's lowest.
        let points = (base - top - 1).div_ceil(POINT_ROWS);
        let point = points / 2;
        let row = (base - 1 - (points - 1 - point) * POINT_ROWS) as f64;
        for index in 0..self.moments.len() {
            finder.find(&self.camera, &self.input(index), &mut lane)?;
            let columns = opencv.outputs()?[0].f32s();
            if index < FIRST_FRAMES {
                continue;
            }
            for (side_index, side) in Side::BOTH.into_iter().enumerate() {
                let Some(truth) = column_at(&self.moments[index].edges_px[side_index], row) else { continue };
                ours.push(our_column(lane.as_ref(), side, row).map_or(f64::INFINITY, |u| (u - truth).abs()));
                let off_px = (f64::from(columns[side_index * points + point]) - truth).abs();
                theirs.push(if off_px.is_nan() { f64::INFINITY } else { off_px });
            }
        }
        let [ours_px, theirs_px] = [median(&mut ours), median(&mut theirs)];
        let found = format!("from the truth: Fingerpost {ours_px:.1} px, OpenCV {theirs_px:.1} px");
        Ok(Agreement { found, holds: ours_px <= AGREED_PX && theirs_px <= AGREED_PX })
    }

    /// The finder on frame after frame; at the drive's end it begins anew.
    fn contestant(&self) -> Result<Contestant<'_>> {
        let mut finder = LaneFinder::new(&self.config)?;
        let (mut lane, mut next) = (None, 0);
        Ok(Contestant::here("Fingerpost", move || {
            if next == self.moments.len() {
                finder.reset();
                next = 0;
            }
            // The frames all have the camera's size.
            let _ = finder.find(&self.camera, &self.input(next), &mut lane);
            next += 1;
        }))
    }
}

fn our_column(lane: Option<&Lane>, side: Side, row: f64) -> Option<f64> {
    let points: Vec<[f64; 2]> = lane?.edge(side)?.points_px.iter().map(|p| [p.u, p.v]).collect();
    column_at(&points, row)
}

/// The column of a curve, points of column and row, in a row.
fn column_at(points: &[[f64; 2]], row: f64) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let [[from_u, from_v], [to_u, to_v]] = [pair[0], pair[1]];
        let share = (row - from_v) / (to_v - from_v);
        (0.0..=1.0).contains(&share).then_some(from_u + share * (to_u - from_u))
    })
}
