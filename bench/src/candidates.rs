//! Candidate poses of a crossroads' four masks that the method's own search about a prediction tries in a second.

use std::time::Instant;

use anyhow::Result;

use crate::footage::Footage;
use crate::measure::{Effort, median};
use crate::results::{Bound, Figure, Section};
use crate::trapezium::Trapezium;
use crate::whole_loop::Loop;

/// Side of the ground view, pixels.
const SIDE_PX: usize = 512;
/// Candidates a second that are promised.
const PROMISED: f64 = 1e6;
/// Searches whose time is taken together: one takes well under a millisecond.
const SEARCHES: usize = 10;

/// Measures on the footage's road surface, and on a plane that is all road, where no candidate can be left early.
pub fn candidates(effort: Effort, footage: &Footage) -> Result<Section> {
    let mut section = Section::new(
        "Candidates",
        "poses a second on one thread, four masks with the validity mask on 512 x 512, the search about a predicted pose",
    );
    let mut work = Loop::new(&Trapezium::new(footage.size(), SIDE_PX)?)?;
    for frame in &footage.frames {
        work.step(frame)?;
    }
    for (what, all_road) in [("the footage's road surface", false), ("all road: no early exit", true)] {
        if all_road {
            work.set_all_road()?;
        }
        for (lattice, step_px) in [("own lattice", None), ("every pixel", Some(1.0))] {
            let mut rates = Vec::new();
            for _ in 0..effort.rounds {
                let (start, mut tried) = (Instant::now(), 0);
                for _ in 0..SEARCHES {
                    tried += work.search(step_px)?;
                }
                rates.push(tried as f64 / start.elapsed().as_secs_f64());
            }
            section.figures.push(Figure {
                what: format!("{what}, {lattice}"),
                value: median(&mut rates),
                unit: "poses/s",
                promised: Some(Bound::AtLeast(PROMISED)),
            });
        }
    }
    Ok(section)
}
