//! `advise` whose pictures stop coming: it says stop without the next one, and every picture has its one answer all the same.

use std::thread;
use std::time::Duration;

use fingerpost_format::FrameRecord;

use crate::advisor::{Advisor, drive, header};

/// Longer than pictures may stay away.
const PAUSE: Duration = Duration::from_millis(700);

#[test]
fn a_silence_is_said_once_and_sets_nothing_going_until_a_picture_comes() {
    let frames = drive();
    let mut advisor = Advisor::start(&["--watchdog-s", "0.5"]);
    let ask = |advisor: &mut Advisor, i: usize| advisor.asked(&header(&frames[i].0), &frames[i].1);
    thread::sleep(PAUSE);
    ask(&mut advisor, 0);
    assert_eq!(advisor.silences, 0, "before the first picture nothing was advised");
    let before = (1..6).map(|i| ask(&mut advisor, i)).last().unwrap().advice.unwrap();
    assert!(before.speed_mps > 1.0, "{}", before.because);
    let silence = advisor.silence();
    assert!(silence.silent_s >= 0.5, "{} s", silence.silent_s);
    let advice = silence.advice;
    assert_eq!((advice.speed_mps, advice.steer_rad), (0.0, before.steer_rad));
    assert_eq!(advice.stop.as_deref(), Some("no_picture"));
    assert!(advice.because.starts_with("stop: no new picture has come for "), "{}", advice.because);
    thread::sleep(PAUSE);
    let said = advisor.silences;
    let broken = advisor.asked("no frame", &[]);
    assert_eq!((broken.frame, broken.advice.unwrap().speed_mps), (6, 0.0));
    let again = ask(&mut advisor, 6);
    assert_eq!((again.frame, again.error, advisor.silences), (7, None, said), "once a silence");
    assert!(again.advice.unwrap().speed_mps > 0.0);
    assert!(advisor.silence().silent_s >= 0.5);
}

#[test]
fn a_silence_in_the_middle_of_a_frame_is_said_and_costs_no_frame() {
    let frames = drive();
    let mut advisor = Advisor::start(&["--watchdog-s", "0.2"]);
    advisor.asked(&header(&frames[0].0), &frames[0].1);
    let (first, second) = frames[1].1.split_at(5000);
    advisor.give(format!("{}\n", header(&frames[1].0)).as_bytes());
    advisor.give(first);
    assert!(advisor.silence().silent_s >= 0.2);
    advisor.give(second);
    let answer = advisor.answer();
    assert_eq!((answer.frame, answer.error), (1, None));
}

#[test]
fn a_simulator_slower_than_the_watchdog_gets_the_same_answers() {
    let frames = drive();
    let ask = |advisor: &mut Advisor, i: usize| advisor.asked(&header(&frames[i].0), &frames[i].1);
    let (mut watched, mut unwatched) =
        (Advisor::start(&["--watchdog-s", "0.1"]), Advisor::start(&["--no-watchdog"]));
    for i in 0..4 {
        let expected = ask(&mut unwatched, i);
        let got = ask(&mut watched, i);
        assert_eq!(FrameRecord { stage_ms: expected.stage_ms.clone(), ..got }, expected);
        watched.silence();
    }
    thread::sleep(PAUSE);
    assert_eq!((ask(&mut unwatched, 4).frame, unwatched.silences), (4, 0));
}
