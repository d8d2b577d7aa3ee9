//! Widths and lengths as mappers write them (the wiki's pages Key:width and Map features/Units).

/// Widths beyond these are typing errors (a way's length, millimetres), metres: a cart track and a twelve-lane toll plaza.
pub(crate) const PLAUSIBLE_WIDTH_M: std::ops::RangeInclusive<f64> = 1.5..=60.0;
/// Metres in a foot (international foot) and in an inch.
const FOOT_M: f64 = 0.3048;
const INCH_M: f64 = 0.0254;

/// Units of length with their metres. Primes are written with the keyboard's signs, and with typographers'.
const UNITS: [(&[&str], f64); 10] = [
    (&["m", "metre", "metres", "meter", "meters"], 1.0),
    (&["mm"], 1e-3),
    (&["cm"], 1e-2),
    (&["dm"], 1e-1),
    (&["km"], 1e3),
    (&["mi", "mile", "miles"], 1609.344),
    (&["nmi"], 1852.0),
    (&["yd", "yard", "yards"], 0.9144),
    (&["ft", "feet", "foot", "'", "\u{2032}", "\u{2019}"], FOOT_M),
    (&["in", "inch", "inches", "\"", "\u{2033}", "\u{201d}", "''", "\u{2032}\u{2032}"], INCH_M),
];

/// A `width` tag in metres: "5.5", "5,5 m", "250 cm", "16'3\"", "16 ft 3 in", "~6"; `None` for what is no plausible width.
pub fn parse_width_m(text: &str) -> Option<f64> {
    let mut rest = text.trim().trim_start_matches('~').trim_start();
    let (first, unit_m) = take_length(&mut rest)?;
    let mut width_m = first * unit_m.unwrap_or(1.0);
    if !rest.is_empty() {
        // Inches may stand behind feet, with their unit or without.
        let (inches, inch_m) = take_length(&mut rest)?;
        if unit_m != Some(FOOT_M) || inch_m.is_some_and(|inch_m| inch_m != INCH_M) || !rest.is_empty() {
            return None;
        }
        width_m = first * FOOT_M + inches * INCH_M;
    }
    PLAUSIBLE_WIDTH_M.contains(&width_m).then_some(width_m)
}

/// Takes a number and its unit, in metres, off the text; no unit where none is written, nothing where either is unknown.
fn take_length(text: &mut &str) -> Option<(f64, Option<f64>)> {
    let is_of_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',');
    let (number, rest) = text.split_at(text.find(|c| !is_of_number(c)).unwrap_or(text.len()));
    let number: f64 = number.replace(',', ".").parse().ok()?;
    let rest = rest.trim_start();
    let ends_unit = |c: char| c.is_ascii_digit() || c.is_whitespace();
    let (unit, rest) = rest.split_at(rest.find(ends_unit).unwrap_or(rest.len()));
    *text = rest.trim_start();
    if unit.is_empty() {
        return Some((number, None));
    }
    let named = UNITS.iter().find(|(names, _)| names.iter().any(|name| name.eq_ignore_ascii_case(unit)));
    named.map(|(_, unit_m)| (number, Some(*unit_m)))
}
