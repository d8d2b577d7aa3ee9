//! Saddles of brightness: where a chessboard's corners may be.
//!
//! Bennett and Lasenby 2014, section 2: on a ring of 16 pixels about a corner, opposite pixels are alike and those a
//! quarter turn apart are not. Their response is the sum response less the difference and the mean responses (equations 1
//! to 4), and positive at corners alone.

use std::cmp::Reverse;
use std::collections::VecDeque;

use crate::picture::PlaneView;

/// The ring, clockwise from the top: the circle of 5 pixels' radius, columns and rows from its middle.
const RING: [(isize, isize); 16] = [
    (0, -5),
    (2, -5),
    (4, -4),
    (5, -2),
    (5, 0),
    (5, 2),
    (4, 4),
    (2, 5),
    (0, 5),
    (-2, 5),
    (-4, 4),
    (-5, 2),
    (-5, 0),
    (-5, -2),
    (-4, -4),
    (-2, -5),
];
/// Pixels at the picture's edges without a whole ring.
const EDGE_PX: usize = 5;
/// Pixels within which a saddle must be the strongest: less than the smallest square.
const APART_PX: usize = 3;
/// Smallest response that counts, grey levels; that of a board whose squares differ by 20 levels is 100 and more.
const LEAST_RESPONSE: i32 = 30;
/// Most saddles that are looked at, the strongest: those of the largest board, and as many again of clutter.
const MOST_SADDLES: usize = 8192;

/// The picture's saddles, `(column, row)` in pixels, the strongest first.
pub(super) fn saddles(grey: PlaneView<'_, u8>) -> Vec<(usize, usize)> {
    let (width, height) = grey.size();
    if width <= 2 * EDGE_PX || height <= 2 * EDGE_PX {
        return Vec::new();
    }
    let responses = |y: usize| (0..width).map(|x| response(grey, x, y)).collect::<Vec<i32>>();
    // The rows about the one that is looked at, so that a large picture's responses need not be held.
    let mut rows: VecDeque<Vec<i32>> = (EDGE_PX - APART_PX..EDGE_PX + APART_PX).map(responses).collect();
    let mut found = Vec::new();
    for y in EDGE_PX..height - EDGE_PX {
        rows.push_back(responses(y + APART_PX));
        for x in EDGE_PX..width - EDGE_PX {
            let here = rows[APART_PX][x];
            if here >= LEAST_RESPONSE && is_strongest(&rows, x) {
                found.push((here, x, y));
            }
        }
        rows.pop_front();
    }
    found.sort_by_key(|&(response, x, y)| (Reverse(response), y, x));
    found.truncate(MOST_SADDLES);
    found.into_iter().map(|(_, x, y)| (x, y)).collect()
}

/// Whether in the rows nearby no pixel responds more than the one in the middle row's column `x`, and none before it as much.
fn is_strongest(rows: &VecDeque<Vec<i32>>, x: usize) -> bool {
    let here = rows[APART_PX][x];
    rows.iter().enumerate().all(|(row, responses)| {
        (x - APART_PX..=x + APART_PX).all(|column| {
            let there = responses[column];
            there < here || (there == here && (row, column) >= (APART_PX, x))
        })
    })
}

/// The response of a pixel, grey levels; 0 where the ring leaves the picture.
fn response(grey: PlaneView<'_, u8>, x: usize, y: usize) -> i32 {
    let (width, height) = grey.size();
    if x < EDGE_PX || y < EDGE_PX || x + EDGE_PX >= width || y + EDGE_PX >= height {
        return 0;
    }
    let at = |(right, down): (isize, isize)| {
        i32::from(grey.row(y.wrapping_add_signed(down))[x.wrapping_add_signed(right)])
    };
    let ring = RING.map(at);
    let sum: i32 = (0..4).map(|n| (ring[n] + ring[n + 8] - ring[n + 4] - ring[n + 12]).abs()).sum();
    let difference: i32 = (0..8).map(|n| (ring[n] - ring[n + 8]).abs()).sum();
    if sum - difference < LEAST_RESPONSE {
        return 0;
    }
    let middle = [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)].map(at);
    let mean = (5 * ring.iter().sum::<i32>() - 16 * middle.iter().sum::<i32>()).abs() / 5;
    sum - difference - mean
}
