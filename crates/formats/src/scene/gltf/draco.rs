//! Meshes that are compressed by Draco: `KHR_draco_mesh_compression`.
//!
//! What the decoder gives becomes the bytes of those accessors that have none
//! of their own; from there on such a mesh is read as any other. Accessors that
//! do have bytes are for readers without Draco, and are taken as they are.
//!
//! Source: Khronos Group, `KHR_draco_mesh_compression`, 2018; the decoder is
//! the crate `draco-core`.

use super::accessor::{Accessors, Component};
use super::entry::{Entry, Result};
use super::store::unsupported;
use draco_core::decode_limits::DecodeLimits;
use draco_core::decoder_buffer::DecoderBuffer;
use draco_core::draco_types::DataType;
use draco_core::geometry_attribute::PointAttribute;
use draco_core::geometry_indices::PointIndex;
use draco_core::mesh::Mesh;
use draco_core::mesh_decoder::MeshDecoder;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The name of the extension.
pub(super) const NAME: &str = "KHR_draco_mesh_compression";

/// Gives bytes to those accessors of a primitive that have none.
pub(super) fn unpack(
    primitive: &Entry<'_, '_>,
    extension: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
) -> Result<()> {
    // What is wanted: accessors by the numbers that Draco gives their attributes.
    let attributes = primitive.need("attributes")?;
    let compressed = extension.need("attributes")?;
    let mut wanted = Vec::new();
    let (by_name, ids) = (attributes.by_key()?, compressed.by_key()?);
    for (name, _) in compressed.object()? {
        let (Some(at), Some(id)) = (by_name.get(&**name), ids.get(&**name)) else { continue };
        let id = id.whole(u64::from(u32::MAX))? as u32;
        let index = accessors.index(at)?;
        if !accessors.has_bytes(at)? {
            wanted.push((id, index));
        }
    }
    let indices = match primitive.get("indices")? {
        Some(at) if !accessors.has_bytes(&at)? => Some(accessors.index(&at)?),
        Some(_) | None => None,
    };
    if wanted.is_empty() && indices.is_none() {
        return Ok(());
    }
    if primitive.get("mode")?.map_or(Ok(4), |mode| mode.whole(6))? != 4 {
        return Err(unsupported(primitive, "has strips compressed by Draco, which are not read"));
    }

    // As much as the document says, no more is decoded.
    let points = accessors.count(&attributes.need("POSITION")?)?;
    for &index in wanted.iter().map(|(_, index)| index).chain(&indices) {
        let (_, width) = accessors.layout(index);
        accessors.store.budget.take(accessors.length(index), 4 * width, extension)?;
    }
    let corners = indices.map(|index| accessors.length(index));
    let view = extension.need("bufferView")?;
    let number = view.index("buffer view", accessors.store.views())?;
    let limits = DecodeLimits::default()
        .with_max_points(points as u64)
        .with_max_faces(corners.map_or(u64::MAX, |corners| corners as u64 / 3))
        .with_max_decoded_bytes(accessors.store.budget.left());
    let bytes = accessors.store.bytes(number, &view)?;
    let mesh = decode(bytes, limits).map_err(|what| {
        let what: String = what.chars().take(200).flat_map(char::escape_debug).collect();
        extension.trouble(format_args!("Draco cannot decode it: {what}"))
    })?;
    if mesh.num_points() != points {
        let what = format!("has {} points, but POSITION has {points}", mesh.num_points());
        return Err(extension.wrong(what));
    }
    if let Some(corners) = corners.filter(|&corners| corners != 3 * mesh.num_faces()) {
        let what = format!("has {} triangles for {corners} indices", mesh.num_faces());
        return Err(extension.wrong(what));
    }

    // In the types that the accessors tell.
    for (id, index) in wanted {
        let (component, width) = accessors.layout(index);
        let attribute = mesh.attribute_by_unique_id(id).filter(|attribute| {
            usize::from(attribute.num_components()) == width && accessors.length(index) == points
        });
        let Some(attribute) = attribute else {
            let what = format!("has no attribute {id} that fits accessors[{index}]");
            return Err(extension.wrong(what));
        };
        let bytes = values(attribute, points, component, width).ok_or_else(|| {
            extension.wrong(format_args!("has an attribute {id} without values for all points"))
        })?;
        accessors.supply(index, bytes);
    }
    if let Some(index) = indices {
        let (component, _) = accessors.layout(index);
        let corners = mesh.faces().iter().flatten();
        let bytes = corners.flat_map(|corner| component.bytes(corner.0 as f64)).collect();
        accessors.supply(index, bytes);
    }
    Ok(())
}

/// A mesh, or what the decoder says. Of the decoder no panic is known; but it is large, and reads
/// what strangers wrote.
fn decode(bytes: &[u8], limits: DecodeLimits) -> std::result::Result<Mesh, String> {
    let work = || {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
    };
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(decoded) => decoded.map_err(|error| error.to_string()),
        Err(_) => Err("it stumbled; please report it as a bug".to_owned()),
    }
}

/// The values of an attribute for each point. `None` where some points have none.
fn values(
    attribute: &PointAttribute,
    points: usize,
    component: Component,
    width: usize,
) -> Option<Vec<u8>> {
    let is_same = match attribute.data_type() {
        DataType::Int8 => component == Component::I8,
        DataType::Uint8 => component == Component::U8,
        DataType::Int16 => component == Component::I16,
        DataType::Uint16 => component == Component::U16,
        DataType::Uint32 => component == Component::U32,
        DataType::Float32 => component == Component::F32,
        _ => false,
    };
    if !is_same {
        let numbers = attribute.read_f32s(points, width);
        return Some(numbers.iter().flat_map(|&number| component.bytes(number.into())).collect());
    }
    let size = component.size() * width;
    let stride = usize::try_from(attribute.byte_stride()).ok()?;
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(points * size);
    for point in 0..points {
        let start =
            (attribute.mapped_index(PointIndex(point as u32)).0 as usize).checked_mul(stride)?;
        bytes.extend_from_slice(data.get(start..start.checked_add(size)?)?);
    }
    Some(bytes)
}
