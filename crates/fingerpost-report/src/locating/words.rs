//! The result in words.

use fingerpost_format::LocationSummary;
use fingerpost_locate::{ALERT_LIMIT_M, Fix, Rival, Status};

use super::drive::{Convergence, LocatedDrive};

/// Hypotheses about which the place of most weight is looked for.
const HEAVIEST: usize = 8;

/// Sentences: how it ended and why, since when the place was known, and how well.
pub(super) fn result(drive: &LocatedDrive, summary: &LocationSummary) -> Vec<String> {
    let Some(fix) = &drive.last else {
        return vec!["No row of the motion log gave a fix.".to_owned()];
    };
    let places = drive.moments.last().map_or(&[][..], |moment| &moment.places);
    let mut sentences = vec![ending(fix, places, summary.risk)];
    sentences.push(match drive.converged {
        Some(Convergence { after_s, after_m, .. }) => {
            format!("It first converged after {after_m:.0} m by the log's speeds, {after_s:.0} s from its first row.")
        }
        None => "It never converged.".to_owned(),
    });
    if let Some(scores) = &summary.truth
        && let Some(error_m) = scores.fix_error_m
    {
        let violations = match scores.bound_violations {
            0 => "no converged row was".to_owned(),
            1 => "1 converged row was".to_owned(),
            rows => format!("{rows} converged rows were"),
        };
        sentences.push(format!(
            "From then on the fix was {:.1} m from the true place in the median and at most {:.1} m; {violations} farther from it than \
             the protection level.",
            error_m.p50, error_m.max
        ));
    }
    sentences
}

fn ending(fix: &Fix, places: &[Rival], risk: f64) -> String {
    let level = fix
        .level_m
        .map(|level_m| format!("within {level_m:.1} m but for a probability of {}", percent(risk)));
    match fix.status {
        Status::Converged => {
            format!("At the end the place is known: {}.", level.unwrap_or_else(|| "converged".to_owned()))
        }
        Status::Ambiguous => format!("At the end the place is ambiguous: {}.", rivalry(fix, places)),
        Status::Coasting => format!(
            "At the end it is coasting: the place that was known has a probability of {} still, but another is not \
             ruled out, or the roads contradicted it a short way back ({}).",
            percent(fix.mass),
            level.unwrap_or_else(|| "no protection level can be said".to_owned())
        ),
        Status::Lost => format!(
            "At the end the vehicle is lost: on no road of the map with a probability of {}.",
            percent(fix.off_map)
        ),
    }
}

/// Why the end is ambiguous.
fn rivalry(fix: &Fix, places: &[Rival]) -> String {
    let here = Rival { place_m: fix.place_m, heading_rad: fix.heading_rad, weight: fix.mass };
    let best = percent(here.weight);
    // The place of most weight is about one of the heaviest hypotheses.
    let elsewhere = places.iter().filter(|place| !place.is_one_place(&here)).take(HEAVIEST);
    let rival = elsewhere
        .map(|centre| (place_weight(places, centre), centre))
        .reduce(|heaviest, next| if next.0 > heaviest.0 { next } else { heaviest });
    match (rival, fix.level_m) {
        (Some((weight, rival)), _) if weight > fix.off_map => {
            let turned = Rival { heading_rad: here.heading_rad, ..*rival };
            let other = if turned.is_one_place(&here) {
                "the same in another direction".to_owned()
            } else {
                format!("another, {:.0} m away,", (rival.place_m - here.place_m).norm())
            };
            let weight = percent(weight);
            format!(
                "the likeliest place has a probability of {best}, {other} one of {weight}; what was driven fits both"
            )
        }
        (_, None) if fix.off_map > 0.5 * (1.0 - fix.mass) => format!(
            "the likeliest place has a probability of {best}, being on no road of the map one of {}",
            percent(fix.off_map)
        ),
        (_, None) => format!(
            "the likeliest place has a probability of {best}, the rest is spread over many others; that is too much for a protection level"
        ),
        (_, Some(level_m)) if level_m > ALERT_LIMIT_M => format!(
            "one place is left, but it is known to {level_m:.0} m only, and converged is said up to {ALERT_LIMIT_M:.0} m"
        ),
        _ => "one place is left, but the roads contradicted it a short way back".to_owned(),
    }
}

/// Weight of all hypotheses that are one place with one of them.
fn place_weight(places: &[Rival], centre: &Rival) -> f64 {
    places.iter().filter(|place| place.is_one_place(centre)).map(|place| place.weight).sum()
}

/// A probability for people.
pub(super) fn percent(probability: f64) -> String {
    let percent = 100.0 * probability;
    match percent {
        p if p <= 0.0 => "0 %".to_owned(),
        p if p < 0.1 => "below 0.1 %".to_owned(),
        p if p > 99.9 => "above 99.9 %".to_owned(),
        p if p < 10.0 => format!("{p:.1} %"),
        p => format!("{p:.0} %"),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix2, Point2};

    use super::*;

    fn fix(status: Status, mass: f64, off_map: f64, level_m: Option<f64>) -> Fix {
        Fix {
            t_s: 1.0,
            driven_m: 10.0,
            place_m: Point2::origin(),
            heading_rad: 0.0,
            covariance_m2: Matrix2::identity(),
            speed_scale: [0.0, 0.01],
            level_m,
            status,
            mass,
            off_map,
            rivals: Vec::new(),
            hypotheses: 1,
        }
    }

    #[test]
    fn every_ending_says_why() {
        let here = |heading_rad, weight| Rival { place_m: Point2::origin(), heading_rad, weight };
        let both_ways = [here(0.0, 0.52), here(std::f64::consts::PI, 0.48)];
        let ambiguous = |mass, off_map, level_m| fix(Status::Ambiguous, mass, off_map, level_m);
        for (fix, places, words) in [
            (ambiguous(0.52, 0.0, None), &both_ways[..], "the same in another direction one of 48 %"),
            (ambiguous(0.9, 0.1, None), &[], "being on no road of the map one of 10 %"),
            (ambiguous(0.98, 0.001, None), &[], "the rest is spread"),
            (ambiguous(1.0, 0.0, Some(31.0)), &[], "known to 31 m only"),
            (ambiguous(1.0, 0.0, Some(8.0)), &[], "contradicted it"),
            (fix(Status::Coasting, 0.8, 0.0, None), &[], "a probability of 80 % still"),
            (fix(Status::Lost, 0.2, 0.8, None), &[], "on no road of the map with a probability of 80 %"),
            (fix(Status::Converged, 1.0, 0.0, Some(6.0)), &[], "within 6.0 m but for a probability of 0.1 %"),
        ] {
            let said = ending(&fix, places, 1e-3);
            assert!(said.contains(words), "{said}");
        }
    }

    #[test]
    fn probabilities_are_never_rounded_to_certainty() {
        let said = [0.0, 1e-5, 1e-3, 0.0456, 0.5, 0.9995].map(percent);
        assert_eq!(said, ["0 %", "below 0.1 %", "0.1 %", "4.6 %", "50 %", "above 99.9 %"]);
    }
}
