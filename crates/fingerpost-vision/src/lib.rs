//! Picture kernels of Fingerpost: arrays in, arrays out.
//!
//! The kernels know pixels and nothing of roads, vehicles or metres; they read no file, clock or environment, and the
//! same input gives the same bytes on every run. Pixel coordinates are those of the `image` frame: u (column) to the
//! right, v (row) down, the origin at the *centre* of the top-left pixel, so that pixel `(c, r)` has its centre at
//! `(c, r)` exactly.
//!
//! | module | what | source |
//! |---|---|---|
//! | [`picture`] | planes, views, colour pictures, rectangles | |
//! | [`warp`] | resampling through a table built once | |
//! | [`colour`] | grey, hue and saturation, histogram bins, planar YUV | ITU-R BT.601, BT.709; Smith 1978 |
//! | [`log_colour`], [`colour_clusters`] | log-chromaticity over blocks; distance to known colours | Finlayson et al. 2002 |
//! | [`histogram`] | two-dimensional hue-saturation histograms | Swain & Ballard 1992 |
//! | [`backprojection`] | probability of a surface from its histogram | Swain & Ballard 1992 |
//! | [`frame_buffer`] | mean of the last frames | paper 3, III-A |
//! | [`fusion`] | probability from two independent ones | Bayes 1763 |
//! | [`span`] | masks as row spans; how much lies under a mask | paper 1, equation 1 |
//! | [`smoothing`] | Gaussian and box blur of 8-bit pictures | |
//! | [`sobel`], [`canny`] | gradient and edges | Sobel & Feldman 1968; Canny 1986 |
//! | [`moments`] | mean and covariance | |
//! | [`line_gradient`] | slopes across lines towards a vanishing point | |
//! | [`passage`], [`geodesic`] | cost of a way over a picture, and the cheapest way | Fisher 1936; Toivanen 1996 |
//! | [`morphology`] | dilation, opening along rows, thinning | Serra 1982; Zhang & Suen 1984 |
//! | [`hough`] | straight lines and segments | Hough 1962; Duda & Hart 1972 |
//! | [`components`] | connected components | Galler & Fischer 1964 |
//! | [`filter`], [`pyramid`] | smoothing, resizing and halving | Burt & Adelson 1983 |
//! | [`resampling`] | colour pictures of another size: by area averaging where they shrink | |
//! | [`road_network`] | a small convolutional network in whole numbers | Howard et al. 2017; Jacob et al. 2018 |
//! | [`farneback`] | dense optical flow | Farneback 2003 |
//! | [`alignment`] | direct alignment of two pictures | Baker & Matthews 2004 |
//! | [`corners`], [`lucas_kanade`] | corners, and where they went | Shi & Tomasi 1994; Lucas & Kanade 1981 |
//! | [`jpeg`] | colour pictures as JPEG files | ITU-T T.81; Arai et al. 1988 |
//! | [`chessboard`] | a chessboard's inner corners | Bennett & Lasenby 2014; Förstner & Gülch 1987 |
//! | [`simd`] | which code path of a kernel runs | |
//!
//! "Paper 1" is the method's paper on interpretable single-camera localisation.

pub mod alignment;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod backprojection;
mod bit_plane;
mod blocks;
mod border;
pub mod canny;
pub mod chessboard;
pub mod colour;
pub mod colour_clusters;
pub mod components;
pub mod corners;
mod elementary;
pub mod error;
pub mod farneback;
pub mod filter;
pub mod frame_buffer;
pub mod fusion;
pub mod geodesic;
pub mod histogram;
pub mod hough;
pub mod jpeg;
pub mod line_gradient;
pub mod log_colour;
pub mod lucas_kanade;
pub mod moments;
pub mod morphology;
pub mod passage;
pub mod picture;
pub mod pyramid;
pub mod resampling;
pub mod road_network;
pub mod simd;
pub mod smoothing;
pub mod sobel;
pub mod span;
#[cfg(test)]
mod test_pictures;
pub mod warp;
