//! What results that can be gone on with are about: those of one setup are not mixed with those of another.

use std::path::Path;

use crate::{
    file::{FileError, read_text},
    folder_kind::SETUP_FILE,
    whole_file::write_private_file,
};

/// Writes the setup, a JSON object, into a folder that has none; of another one, the name of the first field that differs.
pub(crate) fn keep_setup(folder: &Path, setup: &serde_json::Value) -> Result<Option<String>, FileError> {
    let path = folder.join(SETUP_FILE);
    if path.exists() {
        // What is no JSON is of nothing that could be gone on with.
        let before: serde_json::Value = serde_json::from_str(&read_text(&path)?).unwrap_or_default();
        return Ok(first_difference(&before, setup));
    }
    write_private_file(&path, format!("{setup:#}\n"))?;
    Ok(None)
}

/// The first field in which two objects differ, by name.
fn first_difference(one: &serde_json::Value, two: &serde_json::Value) -> Option<String> {
    let fields = |value: &serde_json::Value| value.as_object().cloned().unwrap_or_default();
    let (one, two) = (fields(one), fields(two));
    one.keys().chain(two.keys()).find(|key| one.get(*key) != two.get(*key)).cloned()
}
