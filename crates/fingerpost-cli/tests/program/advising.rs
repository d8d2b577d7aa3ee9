//! `advise`: frames in, advice out, in lockstep; what is wrong with a frame costs that frame.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use fingerpost_format::FrameRecord;
use serde_json::json;
use tempfile::TempDir;

use crate::advisor::{Advisor, Ended, drive, header};
use crate::drive::Drive;
use crate::program::{call_line, frames};

#[test]
fn a_drive_is_advised_frame_by_frame_as_a_run_says_it() {
    let out = TempDir::new().unwrap();
    let run = out.path().join("run");
    let drive_files = Drive::get();
    let (folder, camera, route) = (drive_files.path(), drive_files.camera(), drive_files.route());
    let (folder, camera, route) = (folder.display(), camera.display(), route.display());
    call_line(&format!("run {folder} --camera {camera} --route {route} --start-m 0 --out {}", run.display()))
        .done();
    let mut advisor = Advisor::start(&[]);
    let mut advised = Vec::new();
    for (truth, pixels) in drive() {
        let bare = json!({"t_s": truth.t_s, "width": 320, "height": 240}).to_string();
        advised.push(advisor.asked(&bare, &pixels));
    }
    let Ended { rest, code, messages } = advisor.end();
    assert!(rest.is_empty() && code == Some(0) && messages.is_empty(), "{messages}");
    for (advised, run) in advised.iter().zip(frames(&run)) {
        let times = run.stage_ms.clone();
        assert_eq!(FrameRecord { stage_ms: times, ..advised.clone() }, run);
        let advice = run.advice.unwrap();
        assert!(advice.line.is_some() || advice.stop.is_some(), "{}", advice.because);
        assert!(!advice.because.is_empty());
    }
    // The road turns left at the junction, and the driving line leads there.
    let led = |record: &&FrameRecord| record.advice.as_ref().unwrap().line.as_deref() == Some("driving_line");
    let most = advised
        .iter()
        .filter(led)
        .map(|record| record.advice.as_ref().unwrap().steer_rad)
        .fold(0.0, f64::max);
    assert!(most > 0.1, "{most} rad to the left");
}

#[test]
fn a_bad_frame_is_answered_by_its_error_and_the_advice_to_slow_down() {
    let frames = drive();
    let mut advisor = Advisor::start(&[]);
    let good = |advisor: &mut Advisor, i: usize| {
        let record = advisor.asked(&header(&frames[i].0), &frames[i].1);
        assert_eq!(record.error, None);
        record.advice.unwrap()
    };
    let before = (0..6).map(|i| good(&mut advisor, i)).last().unwrap();
    assert!(before.speed_mps > 1.0, "{}", before.because);
    let pixels = &frames[6].1;
    for (header, pixels, words) in [
        ("no frame", &pixels[..0], "no JSON object"),
        (r#"{"t_s": 0.6}"#, &pixels[..0], "width and height"),
        (r#"{"t_s": NaN, "width": 320, "height": 240}"#, &pixels[..], "\"t_s\""),
        (r#"{"t_s": 0.6, "width": 320, "height": 240, "speed_mps": Infinity}"#, &pixels[..], "\"speed_mps\""),
        (r#"{"t_s": 0.6, "width": 240, "height": 320}"#, &pixels[..], "240 x 320"),
        (r#"{"t_s": 0.6, "width": 4, "height": 4}"#, &pixels[..48], "4 x 4"),
    ] {
        let record = advisor.asked(header, pixels);
        let (error, advice) = (record.error.unwrap(), record.advice.unwrap());
        assert!(error.contains(words), "{error}");
        assert!(
            advice.speed_mps < before.speed_mps && advice.because.starts_with("slow down"),
            "{}",
            advice.because
        );
        assert_eq!(advice.stop.as_deref(), Some("broken_frame"));
    }
    // It goes on as if nothing had been.
    let after = good(&mut advisor, 7);
    assert!(after.stop.is_none(), "{}", after.because);
    // Bytes that were never told of cost one frame.
    let record = advisor.asked("no frame", pixels);
    assert!(record.error.is_some());
    assert!(good(&mut advisor, 8).stop.is_none());
    advisor.give(format!("{}\n", header(&frames[9].0)).as_bytes());
    advisor.give(&frames[9].1[..1000]);
    let Ended { rest, code, messages } = advisor.end();
    assert_eq!((rest.len(), code), (1, Some(0)), "{messages}");
    assert!(rest[0].error.as_ref().unwrap().contains("1000 of the frame's 230400 bytes"));
    assert_eq!(messages.lines().count(), 8, "{messages}");
}

#[test]
fn who_stops_in_the_middle_of_a_frame_is_answered_and_who_says_nothing_is_left() {
    let frames = drive();
    let mut advisor = Advisor::start(&["--timeout-s", "0.3"]);
    let began = Instant::now();
    advisor.give(format!("{}\n", header(&frames[0].0)).as_bytes());
    advisor.give(&frames[0].1[..5000]);
    assert!(advisor.answer().error.unwrap().contains("5000 of"));
    let Ended { rest, code, messages } = advisor.ended();
    assert_eq!((rest.len(), code), (0, Some(1)));
    assert!(messages.contains("--timeout-s"), "{messages}");
    assert!(began.elapsed() < Duration::from_secs(60));
}

#[test]
fn an_empty_input_ends_well_and_wrong_rules_are_refused() {
    let Ended { rest, code, .. } = Advisor::start(&[]).end();
    assert_eq!((rest.len(), code), (0, Some(0)));
    let folder = TempDir::new().unwrap();
    let config = write_config(folder.path(), "rule if offset_deg is left then turn_deg is right");
    let Ended { rest, code, messages } = Advisor::start(&["--config", &config]).end();
    assert_eq!((rest.len(), code), (0, Some(1)));
    assert!(messages.contains("advice.rules: line 1 of the fuzzy rules"), "{messages}");
    // Rules that nobody goes by are no error, and are not passed over in silence.
    let path = folder.path().join("unused.toml");
    fs::write(&path, format!("[advice]\nrules = '''\n{OWN_RULES}'''\n")).unwrap();
    let Ended { code, messages, .. } = Advisor::start(&["--config", &path.display().to_string()]).end();
    assert_eq!(code, Some(0));
    assert!(messages.contains("and pure_pursuit steers: set advice.controller = \"fuzzy\""), "{messages}");
}

fn write_config(folder: &Path, rules: &str) -> String {
    let path = folder.join("fingerpost.toml");
    fs::write(&path, format!("[advice]\ncontroller = \"fuzzy\"\nrules = '''\n{rules}'''\n")).unwrap();
    path.display().to_string()
}

/// Two rules in place of the shipped ones.
const OWN_RULES: &str = "input offset_deg -30 30
  right -30 -30 5
  left   -5  30 30
output turn_deg -60 60
  to_right -60 -30 0
  to_left    0  30 60
rule if offset_deg is left then turn_deg is to_right
rule if offset_deg is right then turn_deg is to_left
";

#[test]
fn rules_of_ones_own_fire_in_the_report() {
    let folder = TempDir::new().unwrap();
    let drive = Drive::get();
    let config = write_config(folder.path(), OWN_RULES);
    let of_shipped = folder.path().join("shipped.toml");
    fs::write(&of_shipped, "[advice]\ncontroller = \"fuzzy\"\n").unwrap();
    let report = |name: &str, config: &str| {
        let out = folder.path().join(name);
        let line = format!(
            "run {} --camera {} --route {} --start-m 0 --frames 30 {config} --out {}",
            drive.path().display(),
            drive.camera().display(),
            drive.route().display(),
            out.display()
        );
        call_line(&line).done();
        let fired: Vec<usize> = frames(&out)
            .iter()
            .flat_map(|record| record.advice.clone().unwrap().rules)
            .map(|fired| fired.rule)
            .collect();
        (fs::read_to_string(out.join("report.html")).unwrap(), fired)
    };
    let (shipped_page, shipped) = report("shipped", &format!("--config {}", of_shipped.display()));
    let (own_page, own) = report("own", &format!("--config {config}"));
    assert!(shipped.iter().any(|rule| *rule > 2), "the shipped rules are many");
    assert!(!own.is_empty() && own.iter().all(|rule| [1, 2].contains(rule)));
    let (own_rule, shipped_rule) = (
        "<td>if offset_deg is left then turn_deg is to_right</td>",
        "<td>if offset_deg is middle and heading_deg is straight then turn_deg is on</td>",
    );
    assert!(own_page.contains(own_rule) && !own_page.contains(shipped_rule));
    assert!(shipped_page.contains(shipped_rule) && !shipped_page.contains(own_rule));
}

#[test]
fn a_frame_that_a_later_one_has_passed_is_left_out() {
    let frames = drive();
    let (mut in_order, mut swapped) = (Advisor::start(&[]), Advisor::start(&[]));
    let ask = |advisor: &mut Advisor, i: usize| advisor.asked(&header(&frames[i].0), &frames[i].1);
    // The fifth frame comes after the sixth.
    for i in 0..20 {
        if i != 4 {
            let expected = ask(&mut in_order, i);
            let got = ask(&mut swapped, i);
            assert_eq!(got.error, None);
            // The number counts what came.
            let got = FrameRecord { frame: expected.frame, stage_ms: expected.stage_ms.clone(), ..got };
            assert_eq!(got, expected);
        }
        if i == 5 {
            let passed = ask(&mut swapped, 4);
            let error = passed.error.unwrap();
            assert!(error.contains("0.100 s before") && error.contains("order"), "{error}");
            assert_eq!(passed.advice.unwrap().stop.as_deref(), Some("broken_frame"));
        }
    }
}
