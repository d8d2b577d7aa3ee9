//! Fixes on the map over time: what they are worth, where they are, and where the vehicle truly was.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use fingerpost_locate::{ALERT_LIMIT_M, Status};
use fingerpost_map::RoadGraph;
use maud::{Markup, html};
use nalgebra::Point2;

use crate::html::{Chart, Curve, Fit, Scale, Sheet, bands, joined, legend, px};
use crate::palette;
use crate::series::{Series, Stretches, thinned_path};

/// A place that lies so much farther from the one before than was driven is another, not a correction, metres: the greatest
/// correction of a converged fix on three recorded drives is 1.4 m.
const JUMP_M: f64 = 5.0;
/// Points of a track are kept this far apart, metres: below a pixel of every map on the page.
const TRACK_STEP_M: f64 = 1.0;
/// Room around what was driven, metres: a block of a town, so that the next roads are seen.
const AROUND_M: f64 = 100.0;
/// Bends of roads that are smaller than this are left out, pixels.
const ROAD_STEP_PX: f64 = 1.5;
/// Least protection level and error that the chart shows, metres: what the lines of good maps are off.
const LEAST_M: f64 = 0.1;

/// A fix as the page needs it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrackedFix {
    /// Time, seconds.
    pub(crate) t_s: f64,
    /// Distance driven so far, metres.
    pub(crate) driven_m: f64,
    /// Place, metres in a plane.
    pub(crate) place_m: Point2<f64>,
    /// Protection level, metres.
    pub(crate) level_m: Option<f64>,
    /// What it is worth.
    pub(crate) status: Status,
}

/// Fixes over time: curves are thinned as it goes on, tracks have a point a metre.
#[derive(Debug, Clone, Default)]
pub(crate) struct FixTrack {
    /// How many there are of each status.
    pub(crate) rows: BTreeMap<Status, usize>,
    pub(crate) statuses: Stretches<Status>,
    level_m: Series,
    error_m: Series,
    pieces: Vec<TrackPiece>,
    pub(crate) truth: Vec<Point2<f64>>,
    last: Option<TrackedFix>,
    /// The first converged one.
    converged_m: Option<Point2<f64>>,
}

/// A stretch of fixes of one status that goes on without a jump.
#[derive(Debug, Clone)]
struct TrackPiece {
    status: Status,
    points: Vec<Point2<f64>>,
}

impl FixTrack {
    /// Goes on with the next fix, and where the vehicle truly was then, metres in the same plane, where that is known.
    pub(crate) fn add(&mut self, fix: TrackedFix, true_m: Option<Point2<f64>>) {
        *self.rows.entry(fix.status).or_default() += 1;
        self.statuses.push(fix.t_s, fix.status);
        self.level_m.push(fix.t_s, fix.level_m);
        self.error_m.push(fix.t_s, true_m.map(|true_m| (fix.place_m - true_m).norm()));
        self.add_to_track(&fix);
        if let Some(true_m) = true_m
            && self.truth.last().is_none_or(|last| (true_m - last).norm() >= TRACK_STEP_M)
        {
            self.truth.push(true_m);
        }
        if fix.status == Status::Converged {
            self.converged_m.get_or_insert(fix.place_m);
        }
        self.last = Some(fix);
    }

    fn add_to_track(&mut self, fix: &TrackedFix) {
        let TrackedFix { status, place_m, .. } = *fix;
        let goes_on = |before: &&TrackedFix| {
            (place_m - before.place_m).norm() <= fix.driven_m - before.driven_m + JUMP_M
        };
        let joined_m = self.last.as_ref().filter(goes_on).map(|before| before.place_m);
        match self.pieces.last_mut() {
            Some(piece) if piece.status == status && joined_m.is_some() => {
                if piece.points.last().is_none_or(|last| (place_m - last).norm() >= TRACK_STEP_M) {
                    piece.points.push(place_m);
                }
            }
            _ => self
                .pieces
                .push(TrackPiece { status, points: joined_m.into_iter().chain([place_m]).collect() }),
        }
    }

    /// The same in another plane.
    pub(crate) fn moved(&self, moved: impl Fn(Point2<f64>) -> Point2<f64>) -> Self {
        let all = |points: &[Point2<f64>]| points.iter().map(|point| moved(*point)).collect();
        let last = self.last.map(|last| TrackedFix { place_m: moved(last.place_m), ..last });
        let pieces = self.pieces.iter();
        Self {
            pieces: pieces
                .map(|piece| TrackPiece { status: piece.status, points: all(&piece.points) })
                .collect(),
            truth: all(&self.truth),
            last,
            converged_m: self.converged_m.map(&moved),
            ..self.clone()
        }
    }

    /// What the colours of statuses mean.
    pub(crate) fn legend(&self) -> Markup {
        let statuses = self.rows.keys().map(|&status| palette::fix_status(status));
        legend("status", statuses.map(|(name, rgb)| (name.to_owned(), rgb)))
    }

    /// Protection level over time, and the error where there is a truth.
    pub(crate) fn level_chart(&self, seconds: &RangeInclusive<f64>) -> Chart<'_> {
        let mut curves = vec![Curve { label: "protection level", class: "one", values: &self.level_m }];
        let mut title = "Protection level";
        if !self.error_m.is_empty() {
            title = "Protection level, and distance of the fix from the true place";
            curves.push(Curve { label: "error", class: "three", values: &self.error_m });
        }
        Chart {
            scale: Scale::Logarithmic,
            bands: bands(seconds, &self.statuses, |&status| {
                let (name, rgb) = palette::fix_status(status);
                Some((name.to_owned(), palette::css(rgb)))
            }),
            lines: vec![(ALERT_LIMIT_M, format!("converged only to {ALERT_LIMIT_M:.0} m"))],
            curves,
            ..Chart::over(seconds.clone(), title, "metres", LEAST_M..=100.0)
        }
    }

    /// The map of what was driven, on roads in the plane of the track; of all fixes where none was sure and no truth is known, and of
    /// all roads where there is no fix.
    pub(crate) fn map(&self, graph: &RoadGraph) -> Markup {
        let is_found = |status: Status| matches!(status, Status::Converged | Status::Coasting);
        let found = self.pieces.iter().filter(|piece| is_found(piece.status));
        let found: Vec<Point2<f64>> = found.flat_map(|piece| piece.points.iter().copied()).collect();
        let driven = || found.iter().chain(&self.truth).copied();
        let fit = if driven().next().is_some() {
            let around = [-AROUND_M, AROUND_M];
            let corners = |p: Point2<f64>| around.map(|by| Point2::new(p.x + by, p.y + by));
            Fit::new(Sheet::PAGE, driven().flat_map(corners))
        } else {
            Fit::new(Sheet::PAGE, graph.nodes().iter().map(|node| node.p_in_map))
        };
        // With how far down its name is written: a round trip ends where it starts.
        let ends = [
            (self.truth.first().copied(), "start", -7.0),
            (self.converged_m, "converged", -7.0),
            (self.last.map(|fix| fix.place_m), "end", 17.0),
        ];
        html! {
            (self.legend())
            figure class="chart map" {
                figcaption {
                    "North is up. Grey: roads. Coloured: the likeliest place, by status."
                    @if !self.truth.is_empty() { " Dashed: where the vehicle was." }
                }
                svg viewBox=(fit.view_box()) role="img" aria-label="Map of the drive" {
                    path class="road" d=(roads(graph, &fit)) {}
                    @for status in self.rows.keys() {
                        path class={ "fixes" @if !is_found(*status) { " vague" } } stroke=(palette::css(palette::fix_status(*status).1))
                            d=(self.path(*status, &fit)) {}
                    }
                    @if !self.truth.is_empty() {
                        polyline class="truth" points=(fit.path(self.truth.iter().copied())) {}
                    }
                    @for (place, name, down) in ends {
                        @if let Some([x, y]) = place.map(|place| fit.at(place)).filter(|at| fit.shows(*at, *at)) {
                            g class="feature" {
                                circle cx=(px(x)) cy=(px(y)) r="5" {}
                                text x=(px(x + 9.0)) y=(px(y + down)) { (name) }
                            }
                        }
                    }
                    (fit.scale_bar())
                }
            }
        }
    }

    /// Places of one status, as the data of an SVG path.
    fn path(&self, status: Status, fit: &Fit) -> String {
        let mut data = String::new();
        for piece in self.pieces.iter().filter(|piece| piece.status == status) {
            let points: Vec<[f64; 2]> = piece.points.iter().map(|p| fit.at(*p)).collect();
            if points.iter().any(|at| fit.shows(*at, *at)) {
                add_line(&mut data, points, 0.5);
            }
        }
        data
    }
}

/// The roads that the picture shows, as the data of an SVG path.
pub(crate) fn roads(graph: &RoadGraph, fit: &Fit) -> String {
    let mut data = String::new();
    for way in graph.ways() {
        let line: Vec<[f64; 2]> = graph.way_line(way).into_iter().map(|p| fit.at(p)).collect();
        // Points of a way in a row between which it is seen.
        let mut seen: Vec<[f64; 2]> = Vec::new();
        for ends in line.windows(2) {
            if fit.shows(ends[0], ends[1]) {
                if seen.is_empty() {
                    seen.push(ends[0]);
                }
                seen.push(ends[1]);
            } else {
                add_line(&mut data, std::mem::take(&mut seen), ROAD_STEP_PX);
            }
        }
        add_line(&mut data, seen, ROAD_STEP_PX);
    }
    data
}

/// Goes on with a line, thinned to points that far apart; a single point becomes a dot.
fn add_line(data: &mut String, points: Vec<[f64; 2]>, step_px: f64) {
    let points = thinned_path(points.into_iter(), step_px);
    if points.is_empty() {
        return;
    }
    data.push('M');
    data.push_str(&joined(points.iter().copied()));
    if points.len() == 1 {
        data.push_str("h0");
    }
}
