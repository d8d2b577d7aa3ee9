//! The part of the camera's picture that a network of fixed size is to look at.
//!
//! A crossing road fifteen metres ahead is a few rows high, and the sky is a third of the picture: what shows no ground that is wanted
//! costs the rows that would tell a junction. So the network sees from somewhat above the horizon, where what stands beside the road tells
//! what it is, down to the nearest ground that is wanted.

use fingerpost_geometry::GroundPixel;
use fingerpost_vision::picture::Rect;

use super::perspective::KnownPerspective;
use super::{Perspective, RoadInput};

/// Share of the part's height that lies above the horizon.
const ABOVE_HORIZON: f64 = 0.25;
/// Widest part, as a ratio: the widest pictures that the network was trained on (`training/pictures.py`).
const WIDEST: f64 = 3.3;

/// The part, kept while the perspective and the picture's size are.
#[derive(Debug, Default)]
pub(super) struct LookedAt {
    known: Option<(KnownPerspective, (usize, usize), Rect)>,
}

impl LookedAt {
    /// The part for what `input` asks.
    pub(super) fn part(&mut self, input: &RoadInput<'_>) -> Rect {
        let size = input.camera_picture().size();
        let (.., part) = match self.known.take() {
            Some(known) if known.0.is(input.perspective) && known.1 == size => self.known.insert(known),
            _ => {
                let part = part(size, input.vanishing_point().v, nearest_row(input));
                self.known.insert((KnownPerspective::of(input.perspective), size, part))
            }
        };
        *part
    }
}

/// Rows from somewhat above the horizon down to that of the nearest ground wanted, all columns.
fn part((width, height): (usize, usize), horizon_row: f64, nearest_row: f64) -> Rect {
    let last = height as f64;
    let bottom = nearest_row.clamp(1.0, last);
    let below = (bottom - horizon_row.clamp(0.0, bottom)).max(1.0);
    let rows = (below / (1.0 - ABOVE_HORIZON)).max(width as f64 / WIDEST).min(last);
    // What is too wide for the network is made higher, upwards first.
    let top = (bottom - rows).max(0.0).floor();
    let y = top as usize;
    Rect { x: 0, y, width, height: ((top + rows).ceil().min(last) as usize).saturating_sub(y).max(1) }
}

/// Row of the camera's picture below which nothing is wanted, pixels from its upper edge.
fn nearest_row(input: &RoadInput<'_>) -> f64 {
    let height = input.camera_picture().height() as f64;
    let Perspective::Ground { view, .. } = input.perspective else { return height };
    let row = view.grid().rows().saturating_sub(1) as f64;
    let columns = (0..view.grid().columns()).map(|column| GroundPixel { column: column as f64, row });
    let rows = columns.filter_map(|p| input.camera_from_asked([p.column, p.row]));
    // Where the camera does not see the nearest ground it sees none nearer than its lowest row.
    let lowest = rows.map(|p| p.v + 1.0).fold(f64::NEG_INFINITY, f64::max);
    if lowest.is_finite() { lowest } else { height }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reaches_from_above_the_horizon_to_the_nearest_ground() {
        assert_eq!(part((320, 240), 120.0, 210.0), Rect { x: 0, y: 90, width: 320, height: 120 });
        assert_eq!(part((320, 240), 120.0, 300.0), Rect { x: 0, y: 80, width: 320, height: 160 });
    }

    #[test]
    fn a_flat_part_is_made_as_high_as_the_network_knows_it() {
        assert_eq!(part((1240, 376), 185.0, 376.0), Rect { x: 0, y: 0, width: 1240, height: 376 });
        assert_eq!(part((330, 240), 120.0, 150.0), Rect { x: 0, y: 50, width: 330, height: 100 });
    }

    #[test]
    fn a_horizon_outside_the_picture_leaves_a_part_of_it() {
        for (horizon, nearest) in [(-500.0, 240.0), (900.0, 240.0), (f64::from(u16::MAX), 1e9), (120.0, -4.0)]
        {
            let part = part((320, 240), horizon, nearest);
            assert!(part.height > 0 && part.y + part.height <= 240, "{part:?}");
        }
    }
}
