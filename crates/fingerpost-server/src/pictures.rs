//! Pictures that a page shows.

use std::error::Error;

/// Whatever keeps a picture from being shown or an edit from being kept, said to the person at the page.
pub type Cause = Box<dyn Error + Send + Sync>;

/// A picture as browsers show it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    /// `image/jpeg` or `image/png`.
    pub content_type: &'static str,
    /// The file.
    pub bytes: Vec<u8>,
}

/// Where pictures come from.
pub trait Pictures: Send + Sync {
    /// The picture of a frame.
    ///
    /// # Errors
    /// Why there is none.
    fn picture(&self, frame: u64) -> Result<Picture, Cause>;
}
