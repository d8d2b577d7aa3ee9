//! How costs grow with what is given: time and memory at several sizes, and the power of the size that joins them.

mod cost;
mod hours;
mod maps;
mod views;

use anyhow::Result;

pub use self::cost::Growth;
use crate::footage::Footage;
use crate::measure::Effort;
use crate::results::Section;

/// Everything whose size a user chooses.
pub fn growth(effort: Effort, footage: &Footage) -> Result<Section> {
    let mut section = Section::new(
        "Growth",
        "processor time of one thread; the power of the size with which time and memory grow, by least squares of logarithms, against the expected one",
    );
    section.growths.extend([
        views::widths(effort, footage)?,
        views::sides(effort, footage)?,
        views::reaches(effort, footage)?,
    ]);
    section.growths.extend(maps::routes(effort, footage)?);
    section.growths.push(maps::reading_maps());
    section.growths.extend(maps::locating()?);
    section.growths.push(hours::hours()?);
    Ok(section)
}
