//! Small documents, put together in memory.

use rutilant_formats::ReadOptions;
use rutilant_formats::scene::gltf::{Document, read_bytes};
use serde_json::{Value, json};
use std::path::Path;

/// A document and the bytes of its first buffer.
pub(crate) struct Builder {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl Builder {
    /// Nothing but a version.
    pub(crate) fn new() -> Self {
        Self { json: json!({"asset": {"version": "2.0"}}), bytes: Vec::new() }
    }

    /// One triangle in one mesh at one node of one scene; its positions are accessor 0.
    pub(crate) fn triangle() -> Self {
        let mut builder = Self::new();
        builder.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        builder.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": 0}}]}]);
        builder.json["nodes"] = json!([{"mesh": 0}]);
        builder.json["scenes"] = json!([{"nodes": [0]}]);
        builder
    }

    /// Appends to a list of the document; the number of what was appended.
    pub(crate) fn push(&mut self, list: &str, item: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(item);
        list.len() - 1
    }

    /// A view of bytes that are appended to the buffer.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()});
        self.push("bufferViews", view)
    }

    /// An accessor of bytes that are appended to the buffer.
    pub(crate) fn array(
        &mut self,
        kind: &str,
        component: u32,
        count: usize,
        bytes: &[u8],
    ) -> usize {
        let view = self.view(bytes);
        let accessor =
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        self.push("accessors", accessor)
    }

    /// An accessor of floating-point numbers.
    pub(crate) fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        self.array(kind, 5126, numbers.len() / width, &bytes)
    }

    /// An accessor of 16-bit whole numbers.
    pub(crate) fn shorts(&mut self, kind: &str, count: usize, numbers: &[u16]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        self.array(kind, 5123, count, &bytes)
    }

    /// As text, the buffer in it.
    pub(crate) fn text(&self) -> String {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
            json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        }
        json.to_string()
    }

    /// As one binary file.
    pub(crate) fn binary(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.bytes.is_empty() {
            json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        }
        glb(json.to_string().as_bytes(), &self.bytes)
    }

    /// Read, as text.
    pub(crate) fn read(&self) -> Document {
        read(self.text().as_bytes()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// What is wrong with it, without the file's name.
    pub(crate) fn error(&self) -> String {
        read(self.text().as_bytes()).expect_err("a mistake")
    }
}

/// A document, or what is wrong with it, without the file's name.
pub(crate) fn read(bytes: &[u8]) -> Result<Document, String> {
    let path = Path::new("nowhere/a.gltf");
    read_bytes(bytes, path, &ReadOptions::default()).map_err(|error| {
        let text = error.to_string();
        let text = text.strip_prefix("nowhere/a.gltf:").expect("the file's name");
        text.trim_start().to_owned()
    })
}

/// A binary file of a text and bytes.
pub(crate) fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, chunk, fill) in [(b"JSON", json, b' '), (b"BIN\0", binary, 0)] {
        let length = chunk.len().next_multiple_of(4);
        if length == 0 {
            continue;
        }
        file.extend((length as u32).to_le_bytes());
        file.extend(kind);
        file.extend(chunk);
        file.resize(file.len() + length - chunk.len(), fill);
    }
    let length = (file.len() as u32).to_le_bytes();
    file[8..12].copy_from_slice(&length);
    file
}

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let three = [chunk[0], *chunk.get(1).unwrap_or(&0), *chunk.get(2).unwrap_or(&0)];
        let bits = u32::from_be_bytes([0, three[0], three[1], three[2]]);
        for i in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= chunk.len() { char::from(letter) } else { '=' });
        }
    }
    text
}
