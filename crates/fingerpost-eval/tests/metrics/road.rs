//! Road probabilities against labels, counted by hand.

use fingerpost_eval::{EvalError, RoadLabels, RoadScores};

const LABELS: RoadLabels = RoadLabels { road: 3, void: Some(11) };

/// Intersection over union of pixels at least so probable, plainly.
fn iou(probabilities: &[u8], labels: &[u8], threshold: u8) -> f64 {
    let count = |of: fn(bool, bool) -> bool| {
        let pixels = probabilities.iter().zip(labels).filter(|&(_, &label)| label != 11);
        pixels.filter(|&(&p, &label)| of(p >= threshold, label == 3)).count() as f64
    };
    count(|found, road| found && road) / count(|found, road| found || road)
}

#[test]
fn the_best_threshold_of_a_set_is_the_one_that_serves_all_its_pictures() {
    // Alone, the first picture would be told best at 200, the second at 60.
    let pictures: [(&[u8], &[u8]); 2] =
        [(&[220, 200, 150, 10], &[3, 3, 4, 4]), (&[80, 60, 20, 250, 90], &[3, 3, 4, 11, 3])];
    let mut scores = RoadScores::new(LABELS);
    for (probabilities, labels) in pictures {
        scores.add(probabilities, labels).unwrap();
    }
    let best = scores.best().unwrap();
    // At 60: five of five road pixels and one other.
    assert!((best.iou - 5.0 / 6.0).abs() < 1e-12, "{best:?}");
    assert!((best.max_f - 10.0 / 11.0).abs() < 1e-12, "{best:?}");
    assert!((best.threshold - 60.0 / 255.0).abs() < 1e-12, "{best:?}");
    // At 0.5: two of five, and one other.
    assert!((best.iou_at_half - 2.0 / 6.0).abs() < 1e-12, "{best:?}");
}

#[test]
fn it_is_the_best_of_all_thresholds() {
    let noise = |index: u64, shift: u32| (index.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> shift) as u8;
    let labels: Vec<u8> = (1..2000).map(|index| [3, 4, 11][usize::from(noise(index, 40) % 3)]).collect();
    let lighter = |label: u8| if label == 3 { 70 } else { 0 };
    let probabilities: Vec<u8> =
        labels.iter().zip(1..).map(|(&label, index)| noise(index, 50) / 2 + lighter(label)).collect();
    let mut scores = RoadScores::new(LABELS);
    scores.add(&probabilities, &labels).unwrap();
    let best = scores.best().unwrap();
    let ious: Vec<f64> = (0..=255).map(|threshold| iou(&probabilities, &labels, threshold)).collect();
    let largest = ious.iter().copied().fold(0.0, f64::max);
    assert!((best.iou - largest).abs() < 1e-12, "{best:?}, {largest}");
    let at_threshold = ious[(best.threshold * 255.0).round() as usize];
    assert!((at_threshold - largest).abs() < 1e-12 && largest > 0.5 && largest < 0.95);
}

#[test]
fn what_cannot_be_scored_is_an_error() {
    let mut scores = RoadScores::new(LABELS);
    assert_eq!(scores.best(), Err(EvalError::NoRoad { road: 3 }));
    let error = scores.add(&[1, 2], &[3]).unwrap_err();
    assert_eq!(error, EvalError::LabelCount { probabilities: 2, labels: 1 });
    scores.add(&[255, 255], &[11, 4]).unwrap();
    assert_eq!(scores.best(), Err(EvalError::NoRoad { road: 3 }));
    scores.add(&[0], &[3]).unwrap();
    let best = scores.best().unwrap();
    assert!((best.iou - 0.5).abs() < 1e-12 && best.threshold.abs() < 1e-12, "all is road: {best:?}");
}
