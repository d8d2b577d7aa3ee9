//! One closed-loop drive: the camera's picture to the method, its advice to the vehicle, and nothing else.

use std::path::PathBuf;

use anyhow::{Error, Result};
use fingerpost::Sensors;
use fingerpost::advice::{Advice, Stop};
use fingerpost::track::State;
use fingerpost_eval::LoopWatch;
use fingerpost_format::{JUNCTION_M, LoopDrive, LoopEnd, LoopFrame, TruthRecord};
use fingerpost_io::{
    FfmpegPrograms, JsonLinesFile, LOOP_FRAMES_FILE, PLAN_FILE, RunFolder, write_private_file,
};
use fingerpost_map::{LatLon, write_route};
use fingerpost_record::FrameTime;
use fingerpost_report::{PlanView, plan_view_svg};
use fingerpost_sim::{Actuation, Arrival, CameraChannel, DriveCommand, SteeredDrive, SteeredPlace};
use indicatif::ProgressBar;

use super::LoopSetting;
use super::fault::{Fault, gps};
use crate::campaign::Plan;
use crate::driver::{Driver, FrameResult, RunSetting, Sequence};
use crate::recorder::{Pictures, Recorder, RecordingWish, RunEnd, VideoWish, Wishes};
use crate::{inputs, output};

/// Every so many frames of a drive with a report one is written with all that was seen in it: one in two seconds.
const PICTURE_EVERY_FRAMES: u64 = 20;
/// A vehicle that has heard nothing for so long brakes, seconds.
const HEARS_NOTHING_S: f64 = 0.5;

/// What was advised last.
#[derive(Debug, Clone, Default)]
struct Heard {
    t_s: f64,
    command: DriveCommand,
    has_line: bool,
    lost: bool,
    line: String,
    because: String,
}

impl Heard {
    fn new(t_s: f64, advice: &Advice, state: State) -> Self {
        Self {
            t_s,
            command: DriveCommand { steer_rad: advice.steer_rad, speed_mps: advice.speed_mps },
            has_line: advice.line.is_some() && advice.stop.is_none(),
            lost: state == State::Lost || matches!(advice.stop, Some(Stop::NoLine | Stop::Strayed { .. })),
            line: advice.line.map_or(String::new(), |line| line.name().to_owned()),
            because: advice.because.clone(),
        }
    }

    /// What the vehicle does at a time, seconds.
    fn command_at(&self, t_s: f64) -> DriveCommand {
        if t_s - self.t_s > HEARS_NOTHING_S {
            DriveCommand { speed_mps: 0.0, ..self.command }
        } else {
            self.command
        }
    }
}

/// The drive of a seed; none when it was interrupted.
pub(super) fn drive(setting: &LoopSetting<'_>, named: &LoopDrive) -> Option<LoopDrive> {
    let failed = |error: &Error| {
        let error = Some(output::cause_chain(error));
        Some(LoopDrive { error, end: LoopEnd::Failed, ..named.clone() })
    };
    try_drive(setting, named).unwrap_or_else(|error| failed(&error))
}

fn try_drive(setting: &LoopSetting<'_>, named: &LoopDrive) -> Result<Option<LoopDrive>> {
    let plan = setting.plan(named)?;
    let simulator = &plan.simulator;
    let mut steered = SteeredDrive::new(simulator, Actuation::default())?;
    let mut channel = CameraChannel::new(Fault::of_camera(setting.fault), named.seed);
    let named = LoopDrive {
        route_m: plan.route.polyline()?.length_m(),
        features: simulator.features_m().count() as u64,
        ..named.clone()
    };
    let mut watch = LoopWatch::new(named.clone(), simulator.end_m());
    let mut run = Run::start(setting, &named, &plan)?;
    let mut heard = Heard::default();
    let end = loop {
        if setting.interrupt.wanted() {
            return Ok(None);
        }
        let (frame, t_s, place) = (steered.frame_index(), steered.t_s(), steered.place());
        let seen = steered.frame();
        let here = LatLon::new(seen.truth.lat, seen.truth.lon)?;
        run.truth.push(seen.truth);
        for arrival in channel.send(Arrival { frame, t_s, picture: seen.picture }) {
            let sensors = run.sensors(setting.fault, t_s, here, &plan);
            if let Some((advice, state)) = run.take(&arrival, sensors)? {
                heard = Heard::new(t_s, &advice, state);
            }
        }
        let command = heard.command_at(t_s);
        let near = simulator.features_m().any(|m| (m - place.route_m).abs() < JUNCTION_M);
        let loop_frame = loop_frame(t_s, &place, near, &heard, command);
        let end = watch.take(&loop_frame);
        run.frames.push(loop_frame);
        if let Some(end) = end {
            break end;
        }
        steered.drive(command);
    };
    let done = watch.finish(end);
    run.finish(&plan, &done)?;
    Ok(Some(done))
}

fn loop_frame(
    t_s: f64,
    place: &SteeredPlace,
    junction: bool,
    heard: &Heard,
    command: DriveCommand,
) -> LoopFrame {
    LoopFrame {
        t_s,
        x_m: place.p_in_map.x,
        y_m: place.p_in_map.y,
        heading_rad: place.heading_rad,
        speed_mps: place.speed_mps,
        steer_rad: place.steer_rad,
        route_m: place.route_m,
        left_m: place.left_m,
        wheel_off_m: place.wheel_off_m,
        axle_off: place.axle_off,
        junction,
        has_line: heard.has_line,
        lost: heard.lost,
        line: heard.line.clone(),
        advised_steer_rad: command.steer_rad,
        advised_speed_mps: command.speed_mps,
        because: heard.because.clone(),
    }
}

/// The method on a drive.
struct Run {
    driver: Driver,
    /// Where a report is wanted.
    recorder: Option<Recorder>,
    folder: PathBuf,
    truth: Vec<TruthRecord>,
    frames: Vec<LoopFrame>,
}

impl Run {
    fn start(setting: &LoopSetting<'_>, named: &LoopDrive, plan: &Plan) -> Result<Self> {
        let run_setting = RunSetting {
            config: &plan.config,
            camera: &plan.camera,
            route: Some(&plan.route),
            start_m: Some(plan.start_m),
            sequence: Sequence::Drive,
        };
        let name = format!("{}_{}_{}", named.conditions, named.seed, named.controller);
        let reports = setting.args.reports;
        let pictures = if reports { Pictures::Every(PICTURE_EVERY_FRAMES) } else { Pictures::None };
        let programs = FfmpegPrograms { stop: Some(setting.interrupt.shared_flag()), ..inputs::ffmpeg() };
        let video = setting.args.video.then_some(VideoWish { fps: plan.fps, programs });
        let title = format!("Fingerpost closed loop: {name}");
        let wishes = Wishes { title, pictures, video, recording: RecordingWish::None, live: None };
        let driver = Driver::new(run_setting, &wishes, None)?;
        let folder = setting.args.out.join(name);
        let recorder = reports.then(|| {
            let subject = driver.subject(run_setting)?;
            Recorder::create(RunFolder::create_in_campaign(&folder)?, subject, wishes, ProgressBar::hidden())
        });
        let recorder = recorder.transpose()?;
        Ok(Self { driver, recorder, folder, truth: Vec::new(), frames: Vec::new() })
    }

    /// What is known besides the picture: nothing, but for a fault of GPS.
    fn sensors(&self, fault: Option<Fault>, t_s: f64, here: LatLon, plan: &Plan) -> Sensors {
        let plane = plan.route.plane().filter(|_| fault == Some(Fault::GpsJumps));
        Sensors { gps: plane.map(|plane| gps(t_s, here, &plane)), ..Sensors::default() }
    }

    /// Shows the method a picture; gives its advice, and none of a picture that it cannot use.
    fn take(&mut self, arrival: &Arrival, sensors: Sensors) -> Result<Option<(Advice, State)>> {
        let time = FrameTime { frame: arrival.frame, t_s: arrival.t_s };
        let result: FrameResult = self.driver.step(time, &arrival.picture, sensors)?;
        let advised = result.outcome.is_ok().then(|| self.driver.advice());
        self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.add(result))?;
        Ok(advised)
    }

    fn finish(self, plan: &Plan, drive: &LoopDrive) -> Result<()> {
        let Self { recorder, folder, truth, frames, .. } = self;
        let Some(recorder) = recorder else { return Ok(()) };
        recorder.finish(RunEnd::Complete, None, None)?;
        write_private_file(&folder.join("route.geojson"), write_route(&plan.route)?)?;
        let mut lines = JsonLinesFile::create(&folder.join("truth.jsonl"))?;
        truth.iter().try_for_each(|truth| lines.append(truth))?;
        lines.finish()?;
        let mut lines = JsonLinesFile::create(&folder.join(LOOP_FRAMES_FILE))?;
        frames.iter().try_for_each(|frame| lines.append(frame))?;
        lines.finish()?;
        let middle: Vec<_> = plan.simulator.lane_middle().map(|(_, p_in_map)| p_in_map).collect();
        let strips = plan.simulator.road_strips();
        let roads: Vec<_> = strips.iter().map(|strip| (strip.axis, strip.half_width_m)).collect();
        let picture = PlanView { drive, frames: &frames, lane_middle: &middle, roads: &roads };
        Ok(write_private_file(&folder.join(PLAN_FILE), plan_view_svg(&picture))?)
    }
}
