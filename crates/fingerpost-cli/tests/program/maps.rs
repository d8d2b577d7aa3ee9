//! Maps that are not as they seem, and places that are not on them.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use crate::drive::{Drive, MAP};
use crate::program::{call_line, summary};

#[test]
fn what_of_a_map_is_not_understood_is_said_once_and_is_in_results() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let map = folder.path().join("odd.osm");
    let odd = MAP.replace("<tag k=\"highway\"", "<tag k=\"width\" v=\"wide\"/><tag k=\"highway\"");
    fs::write(&map, odd.replace("</osm>", "<remark>runtime error: timed out</remark></osm>")).unwrap();
    let (map, out) = (map.display(), folder.path().join("out"));
    let words =
        ["widths not understood: 2, first: way 10, width=wide", "runtime error: timed out; what they"];
    let expected = |notices: &Value| {
        assert_eq!((&notices[0]["kind"], &notices[0]["count"]), (&"remark".into(), &1.into()), "{notices}");
        assert_eq!((&notices[1]["kind"], &notices[1]["count"]), (&"width".into(), &2.into()), "{notices}");
        assert_eq!(notices[1]["first"], "way 10, width=wide");
    };

    let routed =
        call_line(&format!("route --map {map} --from 47,9.5 --to 47,9.501 --json --out {}", out.display()))
            .done();
    assert!(words.iter().all(|word| routed.stderr.matches(word).count() == 1), "{}", routed.stderr);
    expected(&serde_json::from_str::<Value>(&routed.stdout).unwrap()["map_notices"]);

    let motion = folder.path().join("motion.csv");
    fs::write(&motion, "t_s,speed_mps,yaw_rate_rps\n0,5,0\n1,5,0\n").unwrap();
    let located = folder.path().join("located");
    let line = format!("locate --map {map} --motion {} --json --out {}", motion.display(), located.display());
    let said = call_line(&line).done();
    assert!(words.iter().all(|word| said.stderr.matches(word).count() == 1), "{}", said.stderr);
    expected(&serde_json::from_str::<Value>(&said.stdout).unwrap()["map_notices"]);

    let run = folder.path().join("run");
    let said = call_line(&format!("{} --frames 2 --map {map}", drive.run_line(&drive.path(), &run))).done();
    assert!(words.iter().all(|word| said.stderr.matches(word).count() == 1), "{}", said.stderr);
    assert_eq!(summary(&run).map_notices.len(), 2);
    let said = call_line(&format!(
        "{} --frames 2 --map {}",
        drive.run_line(&drive.path(), &run),
        drive.map().display()
    ));
    assert!(!said.done().stderr.contains("first:") && summary(&run).map_notices.is_empty());
}

#[test]
fn a_place_off_the_map_is_refused_alike_by_every_command() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let (map, route, out) = (drive.map(), drive.route(), folder.path().join("out"));
    let (map, route, out) = (map.display(), route.display(), out.display());
    let run = drive.run_line(&drive.path(), &folder.path().join("out"));
    let camera = drive.path().join("camera.toml");
    for (place, words) in [
        ("9.5,47.0", ["km from the nearest road", "exchanged?"]),
        ("47.01,9.5", ["m from the nearest road", "take a map that covers it"]),
        ("-47.0,-170.5", ["km from the nearest road", "take a map that covers it"]),
    ] {
        let bounds = "latitudes 47.00000 to 47.00060, longitudes 9.50000 to 9.50140";
        for line in [
            format!("route --map {map} --from {place} --to 47,9.501 --out {out}"),
            format!("route --map {map} --from 47,9.501 --to {place} --out {out}"),
            format!("{run} --map {map} --near {place}"),
            format!(
                "advise --camera {} --route {route} --start-m 5 --map {map} --near {place}",
                camera.display()
            ),
        ] {
            let called = call_line(&line);
            called.refused(1, &words);
            called.refused(1, &[bounds]);
            assert!(!folder.path().join("out").exists(), "{line}");
        }
    }
}

#[test]
fn a_junction_of_more_roads_than_there_are_is_refused_alike() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let map = folder.path().join("star.osm");
    let arm = |i: usize| {
        format!(
            "<node id=\"{}\" lat=\"47.0{:03}\" lon=\"9.501\"/><way id=\"{}\"><nd ref=\"2\"/><nd ref=\"{0}\"/>\
             <tag k=\"highway\" v=\"track\"/></way>",
            100 + i,
            i + 1,
            100 + i
        )
    };
    fs::write(&map, MAP.replace("</osm>", &format!("{}</osm>", (0..200).map(arm).collect::<String>())))
        .unwrap();
    let motion = folder.path().join("motion.csv");
    fs::write(&motion, "t_s,speed_mps,yaw_rate_rps\n0,5,0\n1,5,0\n").unwrap();
    let (map, motion, out) = (map.display(), motion.display(), folder.path().join("out"));
    for line in [
        format!("route --map {map} --from 47,9.5 --to 47,9.501 --out {}", out.display()),
        format!("locate --map {map} --motion {motion} --out {}", out.display()),
        format!("{} --map {map}", drive.run_line(&drive.path(), &out)),
    ] {
        call_line(&line).refused(1, &["203 pieces of road meet at node 2", "no junction has more than 16"]);
        assert!(!out.exists(), "{line}");
    }
}
