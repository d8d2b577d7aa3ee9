//! Connected components: pixels that are not 0 and hang together.
//!
//! Rows are cut into runs; a run joins those it touches in the row above, by union-find (B. A. Galler and M. J. Fischer,
//! "An improved equivalence algorithm", 1964). Labels, areas, places and drawings all follow from the runs, so pixels are
//! read once and written only where asked for. Components are numbered from 1 by their first pixel, row by row from the
//! top; the background is 0.

use crate::bit_plane::{BitPlane, WORD_PX};
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView, Rect};
use crate::simd::CodePath;

/// Which neighbours a pixel hangs together with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Connectivity {
    /// Those left, right, above and below.
    Four,
    /// Those across corners too.
    Eight,
}

/// A connected component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component {
    /// Its number in [`ConnectedComponents::write_labels`].
    pub label: u32,
    /// Its pixels.
    pub area_px: usize,
    /// The smallest rectangle around it.
    pub bounds: Rect,
    /// The mean place of its pixels, `[u, v]` in the image frame, pixels.
    pub centroid_px: [f64; 2],
}

/// Finds connected components, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::components::{ConnectedComponents, Connectivity};
/// use fingerpost_vision::picture::Plane;
/// let picture = Plane::from_vec(4, 2, vec![9_u8, 0, 0, 7, 0, 9, 0, 7])?;
/// let mut finder = ConnectedComponents::new(Connectivity::Eight);
/// let components = finder.find(picture.view());
/// assert_eq!(components.len(), 2);
/// assert_eq!((components[1].area_px, components[1].centroid_px), (2, [3.0, 0.5]));
/// let mut labels = Plane::new(4, 2, 0);
/// finder.write_labels(&mut labels)?;
/// assert_eq!(labels.as_slice(), &[1, 0, 0, 2, 0, 1, 0, 2]);
/// # Ok::<(), fingerpost_vision::error::PictureError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ConnectedComponents {
    connectivity: Connectivity,
    bits: BitPlane,
    size: (usize, usize),
    runs: Vec<Run>,
    /// Where each row's runs start in `runs`, and where the last row's end.
    row_starts: Vec<usize>,
    /// Of each run, another one of the same component, an earlier one unless it is the component's first; when all runs
    /// are joined, the component's index.
    parents: Vec<u32>,
    components: Vec<Component>,
    sums: Vec<[u64; 2]>,
}

/// Pixels of a row from `start` up to, not including, `end`.
#[derive(Debug, Clone, Copy)]
struct Run {
    start: u32,
    end: u32,
}

impl ConnectedComponents {
    /// A finder that has not seen a picture yet.
    #[must_use]
    pub fn new(connectivity: Connectivity) -> Self {
        Self {
            connectivity,
            bits: BitPlane::default(),
            size: (0, 0),
            runs: Vec::new(),
            row_starts: Vec::new(),
            parents: Vec::new(),
            components: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// Finds the components of `source`, in the order of their labels.
    pub fn find(&mut self, source: PlaneView<'_, u8>) -> &[Component] {
        self.find_on(CodePath::fastest(), source)
    }

    fn find_on(&mut self, path: CodePath, source: PlaneView<'_, u8>) -> &[Component] {
        self.size = source.size();
        self.bits.fill_from(path, source);
        self.collect_runs();
        self.join_runs();
        self.measure();
        &self.components
    }

    /// The components of the last picture, in the order of their labels.
    #[must_use]
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Writes each pixel's label, 0 for background.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when `labels` has not the size of the last picture.
    pub fn write_labels(&self, labels: &mut Plane<u32>) -> Result<(), PictureError> {
        self.draw("label picture", labels, |component| component.label)
    }

    /// Sets the pixels of those components that `keep` accepts to 255 and all others to 0.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when `mask` has not the size of the last picture.
    pub fn write_mask(
        &self,
        mask: &mut Plane<u8>,
        keep: impl Fn(&Component) -> bool,
    ) -> Result<(), PictureError> {
        self.draw("component mask", mask, |component| if keep(component) { 255 } else { 0 })
    }

    fn draw<T: Copy + Default>(
        &self,
        what: &'static str,
        target: &mut Plane<T>,
        value: impl Fn(&Component) -> T,
    ) -> Result<(), PictureError> {
        check_size(what, self.size, target.size())?;
        for (y, starts) in self.row_starts.windows(2).enumerate() {
            let row = target.row_mut(y);
            row.fill(T::default());
            let indices = &self.parents[starts[0]..starts[1]];
            for (run, &index) in self.runs[starts[0]..starts[1]].iter().zip(indices) {
                row[run.start as usize..run.end as usize].fill(value(&self.components[index as usize]));
            }
        }
        Ok(())
    }

    fn collect_runs(&mut self) {
        self.runs.clear();
        self.row_starts.clear();
        self.row_starts.push(0);
        for words in self.bits.rows() {
            let mut open = None;
            let mut last_bit = 0;
            for (index, &word) in words.iter().enumerate() {
                let mut changes = word ^ (word << 1 | last_bit);
                last_bit = word >> (WORD_PX - 1);
                while changes != 0 {
                    let x = (index * WORD_PX) as u32 + changes.trailing_zeros();
                    match open.take() {
                        Some(start) => self.runs.push(Run { start, end: x }),
                        None => open = Some(x),
                    }
                    changes &= changes - 1;
                }
            }
            self.runs.extend(open.map(|start| Run { start, end: self.size.0 as u32 }));
            self.row_starts.push(self.runs.len());
        }
    }

    fn join_runs(&mut self) {
        let across_corners = match self.connectivity {
            Connectivity::Four => 0,
            Connectivity::Eight => 1,
        };
        self.parents.clear();
        self.parents.extend(0..self.runs.len() as u32);
        for rows in self.row_starts.windows(3) {
            let mut above = rows[0];
            for here in rows[1]..rows[2] {
                let Run { start, end } = self.runs[here];
                while above < rows[1] && self.runs[above].end + across_corners <= start {
                    above += 1;
                }
                let mut touching = above;
                while touching < rows[1] && self.runs[touching].start < end + across_corners {
                    join(&mut self.parents, touching as u32, here as u32);
                    touching += 1;
                }
                // The last one may reach the next run too.
                above = touching.saturating_sub(1).max(above);
            }
        }
    }

    /// Numbers the components and sums up their runs.
    fn measure(&mut self) {
        self.components.clear();
        self.sums.clear();
        for (y, starts) in self.row_starts.windows(2).enumerate() {
            for index in starts[0]..starts[1] {
                // A parent comes before its children, so it has its component already.
                let parent = self.parents[index] as usize;
                let Run { start, end } = self.runs[index];
                let (x, width) = (start as usize, (end - start) as usize);
                if parent == index {
                    self.parents[index] = self.components.len() as u32;
                    self.components.push(Component {
                        label: self.components.len() as u32 + 1,
                        area_px: 0,
                        bounds: Rect { x, y, width, height: 1 },
                        centroid_px: [0.0; 2],
                    });
                    self.sums.push([0; 2]);
                } else {
                    self.parents[index] = self.parents[parent];
                }
                let number = self.parents[index] as usize;
                let component = &mut self.components[number];
                component.area_px += width;
                let bounds = &mut component.bounds;
                let right = (bounds.x + bounds.width).max(x + width);
                bounds.x = bounds.x.min(x);
                bounds.width = right - bounds.x;
                bounds.height = y + 1 - bounds.y;
                let [sum_u, sum_v] = &mut self.sums[number];
                *sum_u += u64::from(start + end - 1) * width as u64;
                *sum_v += (y * width) as u64;
            }
        }
        for (component, [sum_u, sum_v]) in self.components.iter_mut().zip(&self.sums) {
            let area = component.area_px as f64;
            component.centroid_px = [*sum_u as f64 / (2.0 * area), *sum_v as f64 / area];
        }
    }
}

/// Makes two runs one component; the earlier of their first runs stays the first.
fn join(parents: &mut [u32], one: u32, other: u32) {
    let [one, other] = [one, other].map(|run| first_of(parents, run));
    parents[one.max(other) as usize] = one.min(other);
}

/// The first run of a component; paths to it are halved on the way.
fn first_of(parents: &mut [u32], mut run: u32) -> u32 {
    while parents[run as usize] != run {
        let parent = parents[run as usize];
        parents[run as usize] = parents[parent as usize];
        run = parents[run as usize];
    }
    run
}

#[cfg(test)]
mod tests;
