//! Rays against objects of known size.

use super::*;

fn house() -> Object {
    let shape = Shape::House { ridge: [1.0, 0.0], half_m: [5.0, 4.0], height_m: [3.0, 6.0] };
    Object { foot: [20.0, 0.0, 0.0], shape, hash: 0 }
}

#[test]
fn a_house_has_walls_a_roof_and_nothing_above_it() {
    let from = |z: f32, up: f32| house().hit(&Ray { origin: [0.0, 0.0, z], direction: [1.0, 0.0, up] });
    let wall = from(1.5, 0.0).unwrap();
    assert!((wall.t - 15.0).abs() < 1e-5 && wall.part == Part::Wall && wall.normal[0] < -0.99);
    assert!(from(7.0, 0.0).is_none());
    let across = Ray { origin: [20.0, -30.0, 4.5], direction: [0.0, 1.0, 0.0] };
    let roof = house().hit(&across).unwrap();
    assert!(roof.part == Part::Roof && (roof.t - 28.0).abs() < 1e-4, "half way up the roof, half way in");
    assert!(
        from(1.5, 0.0).is_some()
            && house().hit(&Ray { origin: [40.0, 0.0, 1.0], direction: [1.0, 0.0, 0.0] }).is_none()
    );
}

#[test]
fn a_tree_has_a_trunk_below_its_crown() {
    let shape = Shape::Tree { trunk_m: 0.2, crown_m: [2.0, 2.5], middle_m: 5.0 };
    let tree = Object { foot: [10.0, 1.0, 0.0], shape, hash: 0 };
    let at = |z: f32, y: f32| tree.hit(&Ray { origin: [0.0, y, z], direction: [1.0, 0.0, 0.0] });
    assert!(at(1.0, 1.0).is_some_and(|hit| hit.part == Part::Trunk && (hit.t - 9.8).abs() < 1e-4));
    assert!(at(5.0, 1.0).is_some_and(|hit| hit.part == Part::Crown && (hit.t - 8.0).abs() < 1e-4));
    assert!(at(1.0, 1.5).is_none() && at(9.0, 1.0).is_none());
    assert!((tree.height_m() - 7.5).abs() < 1e-6);
}
