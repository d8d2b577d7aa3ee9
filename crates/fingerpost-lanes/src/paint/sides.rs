//! The colours of a bar and of the road on both sides of it.

use super::Side;

/// How far inside a line the road's colour is read, metres: as far as outside it. A shadow's edge is mostly farther away.
const ROAD_M: f64 = 0.15;
/// Pixels next to a bar that are blurred by the lens, the colour mosaic and the picture's compression: passed over.
const BLUR_PX: isize = 3;

/// Mean colours, red, green and blue, levels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct PaintSides {
    /// Inside the bar.
    pub(crate) inside: [f64; 3],
    /// Of the bar.
    pub(crate) paint: [f64; 3],
    /// Just outside, as far as the next bar.
    pub(crate) outside: [f64; 3],
}

/// Where a bar lies in a row, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct BarPlace {
    pub(super) side: Side,
    /// Column of its innermost pixel.
    pub(super) first: usize,
    pub(super) width_px: usize,
    /// How far outside it the road's colour is read.
    pub(super) outside_px: usize,
    /// Pixels between it and the next bar.
    pub(super) room_px: usize,
    /// Pixels of a metre across the lane.
    pub(super) px_per_m: f64,
}

impl PaintSides {
    /// Reads them from an RGB row.
    pub(super) fn read(row: &[u8], bar: &BarPlace) -> Self {
        let (pixels, _) = row.as_chunks::<3>();
        let colour = |from: isize, to: isize| {
            let (mut sums, mut count) = ([0.0; 3], 0.0_f64);
            for outward in from..to {
                let offset = if bar.side == Side::Right { outward } else { -outward };
                let Some(pixel) = bar.first.checked_add_signed(offset).and_then(|column| pixels.get(column))
                else {
                    continue;
                };
                sums.iter_mut().zip(pixel).for_each(|(sum, &level)| *sum += f64::from(level));
                count += 1.0;
            }
            sums.map(|sum| sum / count.max(1.0))
        };
        let road_px = (ROAD_M * bar.px_per_m).max(1.0) as isize;
        let [width_px, outside_px, room_px] =
            [bar.width_px, bar.outside_px, bar.room_px].map(|px| px as isize);
        // Between the lines of a double marking there may be little room.
        let blur_px = BLUR_PX.min(room_px / 2);
        let outside_px = outside_px.min(room_px - blur_px).max(1);
        Self {
            inside: colour(-BLUR_PX - road_px, -BLUR_PX),
            paint: colour(0, width_px),
            outside: colour(width_px + blur_px, width_px + blur_px + outside_px),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(sides: &PaintSides) -> [i32; 3] {
        [sides.inside[0], sides.paint[1], sides.outside[2]].map(|level| level.round() as i32)
    }

    #[test]
    fn either_side_of_a_bar_is_read_on_its_own_side() {
        // Road of 60, a bar of 200 in the columns 40 to 47, and a verge of 90 to its right.
        let level = |column: usize| {
            if column < 40 {
                60
            } else if column < 48 {
                200
            } else {
                90
            }
        };
        let row: Vec<u8> = (0..80).flat_map(|column| [level(column); 3]).collect();
        let read = |side, first| {
            PaintSides::read(
                &row,
                &BarPlace { side, first, width_px: 8, outside_px: 6, room_px: 30, px_per_m: 40.0 },
            )
        };
        let right = read(Side::Right, 40);
        assert_eq!(levels(&right), [60, 200, 90]);
        let left = read(Side::Left, 47);
        assert_eq!(levels(&left), [90, 200, 60]);
    }

    #[test]
    fn between_two_lines_the_second_one_is_not_read() {
        for room_px in 1..12 {
            // Lines of 200 in the columns 20 to 27 and from 28 plus the room on.
            let level = |column: usize| {
                let is_line = (20..28).contains(&column) || column >= 28 + room_px;
                if is_line { 200 } else { 60 }
            };
            let row: Vec<u8> = (0..80).flat_map(|column| [level(column); 3]).collect();
            let bar = BarPlace {
                side: Side::Right,
                first: 20,
                width_px: 8,
                outside_px: 9,
                room_px,
                px_per_m: 40.0,
            };
            assert_eq!(levels(&PaintSides::read(&row, &bar)), [60, 200, 60], "{room_px}");
        }
    }

    #[test]
    fn what_lies_outside_the_picture_is_left_out() {
        let row = [[70_u8; 3]; 10].concat();
        let bar =
            BarPlace { side: Side::Right, first: 5, width_px: 4, outside_px: 9, room_px: 9, px_per_m: 100.0 };
        let read = PaintSides::read(&row, &bar);
        assert_eq!(levels(&read), [70, 70, 0]);
    }
}
