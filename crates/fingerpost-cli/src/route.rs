//! `fingerpost route`: a route on a map, cut into features.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use fingerpost_format::MapNoticeRecord;
use fingerpost_map::{ArmRole, FeatureOptions, LatLon, RoadGraph, Route, match_track, plan, write_route};
use fingerpost_record::kind_name;
use serde::Serialize;

use crate::arguments::{InputLimit, Place};
use crate::examples::examples;
use crate::output_path::FileKind;
use crate::{facts, inputs, output, output_path};

/// Plan a route on an OpenStreetMap map, or match a GPS track to it, and write it with its junctions, side roads and
/// bends as route.geojson.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "route --map town.osm.pbf --from 47.217850,9.539682 --to 47.221489,9.536800 --out route.geojson",
    "route --map town.osm.pbf --gpx track.gpx --out route.geojson"
))]
pub(crate) struct RouteArgs {
    /// OpenStreetMap data of the area, .osm (XML) or .osm.pbf.
    #[arg(long, value_name = "FILE")]
    map: PathBuf,
    #[command(flatten)]
    limit: InputLimit,
    /// Where the route starts, degrees; moved to the nearest road within 100 m.
    #[arg(
        long,
        value_name = "LAT,LON",
        allow_hyphen_values = true,
        requires = "to",
        required_unless_present = "gpx"
    )]
    from: Option<Place>,
    /// Where the route ends, degrees.
    #[arg(long, value_name = "LAT,LON", allow_hyphen_values = true, requires = "from")]
    to: Option<Place>,
    /// A place to pass on the way, degrees; may be given several times, in the order of driving.
    #[arg(long, value_name = "LAT,LON", allow_hyphen_values = true, requires = "from")]
    via: Vec<Place>,
    /// A track that was driven, GPX or a receiver's log, in place of --from and --to.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["from", "to", "via"])]
    gpx: Option<PathBuf>,
    /// The route file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print the length and the features as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct RouteReport<'a> {
    length_m: f64,
    features: Vec<FeatureReport<'a>>,
    /// What of the map was not understood.
    map_notices: Vec<MapNoticeRecord>,
}

#[derive(Debug, Serialize)]
struct FeatureReport<'a> {
    id: i64,
    name: &'a str,
    kind: &'static str,
    route_m: f64,
    turn_deg: f64,
    arms: usize,
}

/// Makes the route file.
pub(crate) fn route(args: &RouteArgs) -> Result<()> {
    let inputs = [Some(&args.map), args.gpx.as_ref()].into_iter().flatten().map(PathBuf::as_path);
    output_path::check_file(&args.out, FileKind::Route, inputs)?;
    let graph = inputs::road_graph(&args.map, args.limit)?;
    let options = FeatureOptions::default();
    let route = match &args.gpx {
        Some(path) => {
            let log = inputs::gps_log(path, args.limit)?;
            let track: Vec<LatLon> = log.points.iter().map(|point| point.at).collect();
            match_track(&graph, &track, &options).with_context(|| path.display().to_string())?
        }
        None => {
            let stops: Vec<LatLon> =
                args.from.iter().chain(&args.via).chain(&args.to).map(|stop| stop.0).collect();
            plan(&graph, &stops, &options)?
        }
    };
    fingerpost_io::write_file(&args.out, write_route(&route)?)?;
    let report = report(&route, &graph)?;
    print_table(&report, &route);
    output::message(&format!(
        "{:.0} m with {} features in {}",
        report.length_m,
        report.features.len(),
        args.out.display()
    ));
    if args.json { output::print_json(&report) } else { Ok(()) }
}

fn report<'a>(route: &'a Route, graph: &RoadGraph) -> Result<RouteReport<'a>> {
    let features = route.features.iter().map(|feature| FeatureReport {
        id: feature.id,
        name: &feature.name,
        kind: kind_name(feature.kind),
        route_m: feature.route_m,
        turn_deg: feature.turn_rad.to_degrees(),
        arms: feature.arms.len(),
    });
    let length_m = route.polyline()?.length_m();
    Ok(RouteReport { length_m, features: features.collect(), map_notices: facts::of_notices(graph) })
}

fn print_table(report: &RouteReport<'_>, route: &Route) {
    output::message("  at m  kind       turn        node         arms  name");
    for (row, feature) in report.features.iter().zip(&route.features) {
        let sides = feature.arms.iter().filter(|arm| arm.role == ArmRole::Side).count();
        output::message(&format!(
            "{:6.0}  {:<9}  {:<10}  {:<11}  {} ({} aside)  {}",
            row.route_m,
            row.kind,
            turn_in_words(row.turn_deg),
            row.id,
            row.arms,
            sides,
            row.name
        ));
    }
}

fn turn_in_words(turn_deg: f64) -> String {
    // Less than this nobody would call a turn.
    const STRAIGHT_DEG: f64 = 15.0;
    match turn_deg {
        turn if turn > STRAIGHT_DEG => format!("left {turn:.0}°"),
        turn if turn < -STRAIGHT_DEG => format!("right {:.0}°", -turn),
        _ => "straight".to_owned(),
    }
}
