//! Which points no other beats, and how much room each has among its like.

/// Whether `a` is better than `b` in one objective at the least and worse in none (Deb et al. 2002, section III). Objectives
/// that one of the two lacks are not compared.
///
/// ```
/// use fingerpost_search::dominates;
/// assert!(dominates(&[1.0, 2.0], &[1.0, 3.0]));
/// assert!(!dominates(&[1.0, 2.0], &[2.0, 1.0]));
/// assert!(!dominates(&[1.0, 2.0], &[1.0, 2.0]));
/// ```
pub fn dominates(a: &[f64], b: &[f64]) -> bool {
    let mut better = false;
    for (a, b) in a.iter().zip(b) {
        if a > b {
            return false;
        }
        better |= a < b;
    }
    better
}

/// The indices of the points, front by front: those that no other dominates, then those that only these dominate, and so on,
/// in ascending order within a front (Deb et al. 2002, section III-A, "fast nondominated sorting").
///
/// ```
/// use fingerpost_search::fronts;
/// assert_eq!(fronts(&[[1.0, 2.0], [3.0, 3.0], [2.0, 1.0]]), [vec![0, 2], vec![1]]);
/// ```
pub fn fronts<P: AsRef<[f64]>>(points: &[P]) -> Vec<Vec<usize>> {
    let dominated_by = |i: usize| {
        let beats = move |&j: &usize| dominates(points[i].as_ref(), points[j].as_ref());
        (0..points.len()).filter(beats).collect::<Vec<_>>()
    };
    let dominated: Vec<Vec<usize>> = (0..points.len()).map(dominated_by).collect();
    let mut dominators = vec![0_usize; points.len()];
    dominated.iter().flatten().for_each(|&j| dominators[j] += 1);
    let mut fronts = Vec::new();
    let mut front: Vec<usize> = (0..points.len()).filter(|&i| dominators[i] == 0).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for &j in front.iter().flat_map(|&i| &dominated[i]) {
            dominators[j] -= 1;
            if dominators[j] == 0 {
                next.push(j);
            }
        }
        next.sort_unstable();
        fronts.push(std::mem::replace(&mut front, next));
    }
    fronts
}

/// How much room each member of a front has: over all objectives, the distance between its two neighbours as a share of the
/// front's extent (Deb et al. 2002, section III-B). Those at the ends have more than any other. An objective that all share, or that is
/// nowhere finite but at one place, tells nothing.
pub fn crowding<P: AsRef<[f64]>>(points: &[P], front: &[usize]) -> Vec<f64> {
    let objectives = front.first().map_or(0, |&i| points[i].as_ref().len());
    let mut room = vec![0.0; front.len()];
    for objective in 0..objectives {
        let value =
            |place: usize| points[front[place]].as_ref().get(objective).copied().unwrap_or(f64::INFINITY);
        let mut order: Vec<usize> = (0..front.len()).filter(|&place| value(place).is_finite()).collect();
        order.sort_by(|&a, &b| value(a).total_cmp(&value(b)));
        let (Some(&first), Some(&last)) = (order.first(), order.last()) else { continue };
        let extent = value(last) - value(first);
        if extent <= 0.0 {
            continue;
        }
        for end in [first, last] {
            room[end] = f64::INFINITY;
        }
        for three in order.windows(3) {
            room[three[1]] += (value(three[2]) - value(three[0])) / extent;
        }
    }
    room
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fronts by their definition: take away what nothing dominates, again and again.
    fn plain_fronts(points: &[[f64; 3]]) -> Vec<Vec<usize>> {
        let mut left: Vec<usize> = (0..points.len()).collect();
        let mut fronts = Vec::new();
        while !left.is_empty() {
            let is_best = |i: &usize| !left.iter().any(|&j| dominates(&points[j], &points[*i]));
            let (front, rest) = left.iter().partition(|i| is_best(i));
            fronts.push(front);
            left = rest;
        }
        fronts
    }

    #[test]
    fn fronts_are_those_of_the_definition() {
        let mut random = crate::random::Random::new(3, 0);
        for count in [0, 1, 2, 7, 60] {
            // Few values, so that many are equal; some worse than any number.
            let mut value = || match random.below(7) {
                6 => f64::INFINITY,
                value => value as f64,
            };
            let points: Vec<[f64; 3]> = (0..count).map(|_| [value(), value(), value()]).collect();
            assert_eq!(fronts(&points), plain_fronts(&points));
        }
    }

    #[test]
    fn equal_points_share_a_front() {
        assert_eq!(fronts(&[[1.0, 1.0], [1.0, 1.0], [2.0, 1.0]]), [vec![0, 1], vec![2]]);
    }

    #[test]
    fn ends_have_the_most_room_and_crowded_points_the_least() {
        let points = [[0.0, 10.0], [1.0, 9.0], [2.0, 8.0], [6.0, 4.0], [10.0, 0.0]];
        let room = crowding(&points, &[0, 1, 2, 3, 4]);
        assert!(room[0].is_infinite() && room[4].is_infinite());
        // Neighbours of 1 are 2 of 10 apart in either objective; of 2, 5; of 3, 8.
        for (room, expected) in room[1..4].iter().zip([0.4, 1.0, 1.6]) {
            assert!((room - expected).abs() < 1e-12, "{room} {expected}");
        }
    }

    #[test]
    fn what_tells_nothing_gives_no_room() {
        assert_eq!(crowding(&[[1.0], [1.0], [1.0]], &[0, 1, 2]), [0.0; 3]);
        assert_eq!(crowding(&[[f64::INFINITY], [1.0]], &[0, 1]), [0.0; 2]);
        assert!(crowding(&[[1.0]; 0], &[]).is_empty());
    }
}
