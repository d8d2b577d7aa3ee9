use proptest::prelude::*;

use super::*;
use crate::test_pictures::{Framed, binary_pictures, config};

/// Labels by flooding from one pixel after the other.
fn plain(picture: &Framed, connectivity: Connectivity) -> Plane<u32> {
    let (width, height) = picture.view().size();
    let mut labels = Plane::new(width, height, 0);
    let mut next = 1;
    for y in 0..height {
        for x in 0..width {
            let mut pending = vec![(x as isize, y as isize)];
            let before = labels.get(x, y);
            while let Some((u, v)) = pending.pop() {
                if picture.get(u, v, 0) == 0 || labels.get(u as usize, v as usize) != Some(0) {
                    continue;
                }
                labels.row_mut(v as usize)[u as usize] = next;
                for (du, dv) in (-1..=1).flat_map(|du| (-1..=1).map(move |dv| (du, dv))) {
                    if connectivity == Connectivity::Eight || du == 0 || dv == 0 {
                        pending.push((u + du, v + dv));
                    }
                }
            }
            if labels.get(x, y) != before {
                next += 1;
            }
        }
    }
    labels
}

fn measured(labels: &Plane<u32>, label: u32) -> Component {
    let (width, height) = labels.size();
    let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let own: Vec<(usize, usize)> = all.filter(|&(x, y)| labels.get(x, y) == Some(label)).collect();
    let range = |values: Vec<usize>| (*values.iter().min().unwrap(), *values.iter().max().unwrap());
    let (left, right) = range(own.iter().map(|place| place.0).collect());
    let (top, bottom) = range(own.iter().map(|place| place.1).collect());
    let area = own.len() as f64;
    Component {
        label,
        area_px: own.len(),
        bounds: Rect { x: left, y: top, width: right + 1 - left, height: bottom + 1 - top },
        centroid_px: [
            own.iter().map(|place| place.0 as f64).sum::<f64>() / area,
            own.iter().map(|place| place.1 as f64).sum::<f64>() / area,
        ],
    }
}

proptest! {
    #![proptest_config(config(80))]

    #[test]
    fn components_are_what_flooding_finds_on_every_path(
        picture in binary_pictures(),
        connectivity in prop_oneof![Just(Connectivity::Four), Just(Connectivity::Eight)],
    ) {
        let expected = plain(&picture, connectivity);
        let mut finder = ConnectedComponents::new(connectivity);
        for path in CodePath::available() {
            let found = finder.find_on(path, picture.view()).to_vec();
            let mut labels = Plane::new(expected.width(), expected.height(), 7);
            finder.write_labels(&mut labels).unwrap();
            prop_assert_eq!(&labels, &expected, "{:?}", path);
            prop_assert_eq!(found.len(), expected.as_slice().iter().copied().max().unwrap_or(0) as usize);
            for component in found {
                prop_assert_eq!(component, measured(&expected, component.label));
            }
        }
    }
}

#[test]
fn small_components_are_left_out_of_a_mask() {
    let picture = Plane::from_vec(5, 2, vec![1_u8, 1, 0, 0, 1, 1, 0, 0, 0, 0]).unwrap();
    let mut finder = ConnectedComponents::new(Connectivity::Four);
    finder.find(picture.view());
    let mut mask = Plane::new(5, 2, 7);
    finder.write_mask(&mut mask, |component| component.area_px > 1).unwrap();
    assert_eq!(mask.as_slice(), &[255, 255, 0, 0, 0, 255, 0, 0, 0, 0]);
    assert_eq!(finder.components().len(), 2);
    assert!(finder.write_mask(&mut Plane::new(2, 5, 0), |_| true).is_err());
    assert!(finder.write_labels(&mut Plane::new(2, 5, 0)).is_err());
}
