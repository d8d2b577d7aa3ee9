//! Shapes in edge pictures: dilation and connected components.

use std::collections::HashMap;

use anyhow::Result;
use fingerpost_vision::components::{ConnectedComponents, Connectivity};
use fingerpost_vision::morphology::{Dilation, StructuringElement};
use fingerpost_vision::picture::Plane;
use serde_json::json;

use super::edges::edge_picture;
use super::{Bench, Kernel, Promise, SIDE_PX, agreement, array_of_plane, rust_crates, size_of};
use crate::results::{Agreement, Row};

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let edges = edge_picture(&bench.frames[0])?;
    let mut rows = dilation(bench, &edges, 3, Shape::Rectangle)?;
    rows.extend(dilation(bench, &edges, 5, Shape::Rectangle)?);
    rows.extend(dilation(bench, &edges, 5, Shape::Ellipse)?);
    rows.extend(components(bench, &edges, "components")?);
    rows.extend(components(bench, &edges, "component_statistics")?);
    Ok(rows)
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Rectangle,
    Ellipse,
}

fn dilation(bench: &mut Bench<'_>, edges: &Plane<u8>, side: usize, shape: Shape) -> Result<Vec<Row>> {
    let (name, element) = match shape {
        Shape::Rectangle => ("rectangle", StructuringElement::rectangle(side, side)?),
        Shape::Ellipse => ("ellipse", StructuringElement::ellipse(side, side)?),
    };
    let parameters = json!({"side": side, "shape": name});
    let theirs = bench.opencv_gives("dilation", &parameters, &[array_of_plane(edges)])?;
    let others = match shape {
        Shape::Rectangle => rust_crates::square_dilations(edges, side),
        Shape::Ellipse => Vec::new(),
    };
    let kernel = Kernel {
        what: &format!("dilation {side} x {side}, {name}"),
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (Dilation::new(element), Plane::new(SIDE_PX, SIDE_PX, 0)),
        work: &|(filter, wide)| Ok(filter.apply(edges.view(), wide)?),
        compare: &|(_, wide)| Ok(agreement::identical(wide.as_slice(), theirs[0].u8s())),
    };
    bench.rows(&kernel, others)
}

fn components(bench: &mut Bench<'_>, edges: &Plane<u8>, operation: &str) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives(operation, &json!({}), &[array_of_plane(edges)])?;
    let their_count = theirs[0].i32s().first().copied().unwrap_or_default();
    let (what, others) = if operation == "components" {
        ("connected components, labels", rust_crates::components(edges))
    } else {
        ("connected components, labels and statistics", Vec::new())
    };
    let kernel = Kernel {
        what,
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (ConnectedComponents::new(Connectivity::Eight), Plane::new(SIDE_PX, SIDE_PX, 0_u32)),
        work: &|(finder, labels)| {
            finder.find(edges.view());
            Ok(finder.write_labels(labels)?)
        },
        compare: &|(finder, labels)| {
            let count = finder.find(edges.view()).len();
            Ok(same_partition(labels.as_slice(), &theirs[1].i32s(), count, their_count))
        },
    };
    bench.rows(&kernel, others)
}

/// The same components, whatever numbers they go by; OpenCV counts the background.
fn same_partition(ours: &[u32], theirs: &[i32], count: usize, their_count: i32) -> Agreement {
    let (mut there, mut here) = (HashMap::new(), HashMap::new());
    let same = ours
        .iter()
        .zip(theirs)
        .filter(|(a, b)| *there.entry(**a).or_insert(**b) == **b && *here.entry(**b).or_insert(**a) == **a);
    let all_same = same.count() == ours.len().max(theirs.len());
    let found = format!("{count} components, {} of OpenCV's", their_count - 1);
    Agreement { found, holds: all_same && count as i32 == their_count - 1 }
}
