//! What the golden tests share: the files' shapes and the comparison of flows.

use std::path::PathBuf;

use fingerpost_vision::farneback::FlowField;

/// Columns and rows of every golden picture.
pub(crate) const WIDTH: usize = 128;
pub(crate) const HEIGHT: usize = 160;
pub(crate) fn golden(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Mean and largest distance between a flow and a golden one of every `step`-th column and row, pixels.
pub(crate) fn end_point_difference(flow: &FlowField, name: &str, step: usize) -> (f64, f64) {
    let bytes = golden(name);
    let (values, _) = bytes.as_chunks::<4>();
    let values: Vec<f32> = values.iter().map(|&value| f32::from_le_bytes(value)).collect();
    let (vectors, _) = values.as_chunks::<2>();
    assert_eq!(vectors.len(), WIDTH / step * (HEIGHT / step), "{name} has another size");
    let differences: Vec<f64> = vectors
        .iter()
        .enumerate()
        .map(|(index, &[dx, dy])| {
            let (x, y) = (index % (WIDTH / step) * step, index / (WIDTH / step) * step);
            let [found_dx, found_dy] = flow.get(x, y).unwrap();
            libm::hypot(f64::from(found_dx - dx), f64::from(found_dy - dy))
        })
        .collect();
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    (mean, differences.iter().copied().fold(0.0, f64::max))
}
