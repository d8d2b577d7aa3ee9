//! Boards that are drawn at known places.

use super::*;

const COLUMNS: usize = 9;
const ROWS: usize = 6;

/// How a board is seen: turned, in perspective, and bent by a lens about the picture's middle.
#[derive(Debug, Clone, Copy)]
struct View {
    size: (usize, usize),
    /// Side of a square where the board's middle is, pixels.
    square_px: f64,
    /// The board's middle, pixels from the picture's.
    middle_px: [f64; 2],
    /// Turn in the picture, radians clockwise.
    turn_rad: f64,
    /// How much farther away each square to the right and down is than the one before, as a share.
    recede: [f64; 2],
    /// Shrinks by `1 + bend r^2`, with r in half widths of the picture: negative as for a barrel.
    bend: f64,
    /// Grey levels of dark and light squares.
    levels: [f64; 2],
}

const PLAIN: View = View {
    size: (320, 240),
    square_px: 22.0,
    middle_px: [3.3, -4.6],
    turn_rad: 0.1,
    recede: [0.03, -0.04],
    bend: 0.0,
    levels: [40.0, 220.0],
};

impl View {
    /// Where a place on the board, in squares from its middle, appears.
    fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let away = 1.0 + self.recede[0] * x + self.recede[1] * y;
        let (right, down) = (self.square_px * x / away, self.square_px * y / away);
        let (sin, cos) = libm::sincos(self.turn_rad);
        let straight =
            [cos * right - sin * down + self.middle_px[0], sin * right + cos * down + self.middle_px[1]];
        let bent = 1.0 + self.bend * self.square_radius(straight);
        [straight[0] * bent + self.centre()[0], straight[1] * bent + self.centre()[1]]
    }

    /// The place on the board that a pixel shows, in squares from its middle.
    fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let seen = [u - self.centre()[0], v - self.centre()[1]];
        let mut straight = seen;
        for _ in 0..12 {
            let bent = 1.0 + self.bend * self.square_radius(straight);
            straight = [seen[0] / bent, seen[1] / bent];
        }
        let (sin, cos) = libm::sincos(self.turn_rad);
        let (right, down) = (straight[0] - self.middle_px[0], straight[1] - self.middle_px[1]);
        let (a, b) =
            ((cos * right + sin * down) / self.square_px, (cos * down - sin * right) / self.square_px);
        let away = 1.0 / (1.0 - self.recede[0] * a - self.recede[1] * b);
        [a * away, b * away]
    }

    fn square_radius(&self, [right, down]: [f64; 2]) -> f64 {
        let half = 0.5 * self.size.0 as f64;
        (right * right + down * down) / (half * half)
    }

    fn centre(&self) -> [f64; 2] {
        [0.5 * (self.size.0 as f64 - 1.0), 0.5 * (self.size.1 as f64 - 1.0)]
    }

    /// The picture of a board of `columns` x `rows` inner corners on a light wall, smoothed as a lens does.
    fn picture(&self, columns: usize, rows: usize) -> Plane<u8> {
        let mut picture = Plane::new(self.size.0, self.size.1, 0);
        for y in 0..self.size.1 {
            for (x, value) in picture.row_mut(y).iter_mut().enumerate() {
                let share = self.light_share([x as f64, y as f64], [columns as i64 + 1, rows as i64 + 1]);
                *value = (self.levels[0] + share * (self.levels[1] - self.levels[0])).round() as u8;
            }
        }
        picture
    }

    /// The share of light about a pixel, over a pixel and a half, of a board with so many squares.
    fn light_share(&self, pixel: [f64; 2], squares: [i64; 2]) -> f64 {
        const SAMPLES: usize = 144;
        const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;
        let square_at = |[right, down]: [f64; 2]| {
            let place = self.place([pixel[0] + right, pixel[1] + down]);
            [0, 1].map(|i| (place[i] + 0.5 * squares[i] as f64).floor() as i64)
        };
        let is_light = |square: [i64; 2]| {
            let on_board = (0..2).all(|i| (0..squares[i]).contains(&square[i]));
            !on_board || (square[0] + square[1]) % 2 == 1
        };
        let around = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(square_at);
        if around.iter().all(|&square| square == around[0]) {
            return f64::from(u8::from(is_light(around[0])));
        }
        // A lattice by the golden ratio: no edge runs along a row of its samples.
        let sample = |i: usize| [i as f64 / SAMPLES as f64, (i as f64 / GOLDEN_RATIO).fract()];
        let samples = (0..SAMPLES).map(|i| sample(i).map(|share| 1.5 * (share - 0.5 + 0.5 / SAMPLES as f64)));
        samples.filter(|&at| is_light(square_at(at))).count() as f64 / SAMPLES as f64
    }

    /// Where the inner corners are, row by row as the board was drawn.
    fn corners(&self, columns: usize, rows: usize) -> Vec<[f64; 2]> {
        let middle = |count: usize| 0.5 * (count as f64 - 1.0);
        let at = |i: usize| [(i % columns) as f64 - middle(columns), (i / columns) as f64 - middle(rows)];
        (0..columns * rows).map(|i| self.pixel(at(i))).collect()
    }
}

fn size() -> BoardSize {
    BoardSize::new(COLUMNS, ROWS).unwrap()
}

/// Largest distance between corners found and true ones.
fn largest_error_px(view: &View) -> f64 {
    let found = find_chessboard(view.picture(COLUMNS, ROWS).view(), size()).unwrap();
    let truth = view.corners(COLUMNS, ROWS);
    let distance = |(a, b): (&[f64; 2], &[f64; 2])| libm::hypot(a[0] - b[0], a[1] - b[1]);
    found.iter().zip(&truth).map(distance).fold(0.0, f64::max)
}

#[test]
fn corners_are_found_where_they_were_drawn() {
    for (view, most_px) in [
        (PLAIN, 0.12),
        (View { turn_rad: -0.4, ..PLAIN }, 0.12),
        // Dim, and light and dark exchanged.
        (View { levels: [20.0, 50.0], ..PLAIN }, 0.15),
        (View { levels: [220.0, 40.0], ..PLAIN }, 0.12),
        (View { square_px: 11.0, ..PLAIN }, 0.2),
        (View { recede: [0.09, 0.0], square_px: 22.0, ..PLAIN }, 0.2),
    ] {
        let error_px = largest_error_px(&view);
        assert!(error_px < most_px, "{error_px} px: {view:?}");
    }
}

#[test]
fn a_strongly_bent_board_is_found() {
    for bend in [-0.25, 0.25] {
        let error_px = largest_error_px(&View { bend, square_px: 24.0, ..PLAIN });
        assert!(error_px < 0.15, "{error_px} px at {bend}");
    }
}

#[test]
fn a_large_soft_picture_is_looked_at_in_a_smaller_size() {
    let view = View { size: (640, 480), square_px: 50.0, ..PLAIN };
    let sharp = view.picture(COLUMNS, ROWS);
    // Out of focus: edges are some 20 pixels wide.
    let mut soft = Plane::new(640, 480, 0);
    GaussianBlur::new(31, 7.0).unwrap().apply(sharp.view(), &mut soft).unwrap();
    assert!(largest_lattice(soft.view()).unwrap().len() < 54);
    let found = find_chessboard(soft.view(), size()).unwrap();
    for (found, truth) in found.iter().zip(view.corners(COLUMNS, ROWS)) {
        assert!(libm::hypot(found[0] - truth[0], found[1] - truth[1]) < 0.5, "{found:?} {truth:?}");
    }
}

/// However the board is turned, rows run to the right in the picture and follow one another clockwise.
#[test]
fn corners_come_in_one_order() {
    for step in 0..6 {
        let turn_rad = f64::from(step) * std::f64::consts::FRAC_PI_3 + 0.2;
        let view = View { size: (280, 280), square_px: 18.0, turn_rad, ..PLAIN };
        for (columns, rows) in [(9, 6), (5, 5)] {
            let board = BoardSize::new(columns, rows).unwrap();
            let found = find_chessboard(view.picture(columns, rows).view(), board).unwrap();
            let (first, last, below) = (found[0], found[columns - 1], found[columns]);
            let (right, down) =
                ([last[0] - first[0], last[1] - first[1]], [below[0] - first[0], below[1] - first[1]]);
            assert!(right[0] > 0.0, "{right:?} at {}", view.turn_rad);
            assert!(right[0] * down[1] - right[1] * down[0] > 0.0, "{right:?} {down:?}");
            let truth = view.corners(columns, rows);
            let distance = |a: &[f64; 2], b: &[f64; 2]| libm::hypot(a[0] - b[0], a[1] - b[1]);
            let hit = |found: &[f64; 2]| truth.iter().any(|truth| distance(found, truth) < 0.2);
            assert!(found.iter().all(hit), "{found:?}");
        }
    }
}

/// The view's picture of a board, with a light square over one place of it.
fn covered(view: &View, columns: usize, rows: usize, place: [f64; 2]) -> Plane<u8> {
    let mut picture = view.picture(columns, rows);
    let [u, v] = view.pixel(place).map(|value| value.round() as usize);
    for y in v - 8..=v + 8 {
        picture.row_mut(y)[u - 8..=u + 8].fill(200);
    }
    picture
}

#[test]
fn what_is_no_whole_board_is_told() {
    let find = |picture: &Plane<u8>| find_chessboard(picture.view(), size());
    assert_eq!(find(&Plane::new(320, 240, 128)), Err(ChessboardError::NotFound));
    assert_eq!(find(&Plane::new(0, 0, 0)), Err(ChessboardError::NotFound));
    assert_eq!(find(&Plane::new(7, 300, 9)), Err(ChessboardError::NotFound));

    let aside = View { middle_px: [80.0, 0.0], ..PLAIN };
    assert!(
        matches!(find(&aside.picture(COLUMNS, ROWS)), Err(ChessboardError::CutOff { found, expected: 54, .. })
        if found > 30 && found < 54)
    );

    let hidden = covered(&PLAIN, COLUMNS, ROWS, [0.0, 0.5]);
    assert_eq!(
        find(&hidden),
        Err(ChessboardError::Incomplete { found: 53, expected: 54, columns: 9, rows: 6 })
    );

    // Wrong numbers of corners.
    let smaller = PLAIN.picture(7, 5);
    assert_eq!(
        find(&smaller),
        Err(ChessboardError::Incomplete { found: 35, expected: 54, columns: 7, rows: 5 })
    );
    let larger = View { square_px: 18.0, ..PLAIN }.picture(11, 7);
    assert_eq!(find(&larger), Err(ChessboardError::Larger { columns: 11, rows: 7 }));
    let gap = covered(&View { square_px: 18.0, ..PLAIN }, 10, 6, [0.5, 0.5]);
    assert_eq!(find(&gap), Err(ChessboardError::Larger { columns: 10, rows: 6 }));
    for (columns, rows) in [(2, 6), (9, 65), (0, 0)] {
        assert_eq!(BoardSize::new(columns, rows), Err(ChessboardError::Size { columns, rows }));
    }
}

/// Squares of noise, stripes and dots, which have saddles too.
#[test]
fn clutter_is_no_board() {
    let mut state = 7_u32;
    let mut noise = Plane::new(320, 240, 0_u8);
    for value in noise.as_mut_slice() {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        *value = (state >> 24) as u8;
    }
    let blocks: Vec<u8> = (0..320 * 240).map(|i| noise.row(i / 320 / 12)[i % 320 / 12]).collect();
    let blocks = Plane::from_vec(320, 240, blocks).unwrap();
    let stripes: Vec<u8> = (0..320 * 240).map(|i| if i % 320 / 9 % 2 == 0 { 30 } else { 200 }).collect();
    let stripes = Plane::from_vec(320, 240, stripes).unwrap();
    for picture in [noise, blocks, stripes] {
        assert!(find_chessboard(picture.view(), size()).is_err());
    }
}
