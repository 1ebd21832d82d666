//! What the fuzz targets do: hold a reader to its promises, which are those of the tests.

#[path = "../../crates/formats/tests/common/readers.rs"]
mod readers;

/// Reads `bytes` with the reader of this name. Panics where a promise is broken.
pub fn hold(name: &str, bytes: &[u8]) {
    let reader = readers::READERS.iter().find(|reader| reader.name == name);
    let reader = reader.expect("a reader of that name");
    (reader.check)(bytes);
}
