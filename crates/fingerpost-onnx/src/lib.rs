//! Road segmentation by a network that the user brings, as an ONNX file.
//!
//! | module | what |
//! |---|---|
//! | [`runtime`] | the shared library, loaded while the program runs |
//! | [`network`] | one picture in, the probability of road in every pixel of the network's output out |
//! | [`error`] | what can go wrong |
//!
//! ONNX Runtime is not linked: its shared library is loaded while the program runs (`ort` 2.0 with `load-dynamic`), so
//! that the program builds in seconds and runs without it as long as nobody asks for a network. Limits: networks
//! with one picture as input and `f32` scores, one picture at a time.

pub mod error;
pub mod network;
pub mod runtime;

pub use error::NetworkError;
pub use network::SegmentationNetwork;
pub use runtime::OnnxRuntime;
