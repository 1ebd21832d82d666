//! Accessors: typed arrays in the bytes of views.
//!
//! Each array is unpacked once, whoever names it, and shared. Whole numbers
//! become the floating-point numbers that they stand for; sparse accessors have
//! their exceptions filled in; an accessor without a view is all zeros. Numbers
//! need not be aligned, because they are read byte by byte.
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, 2021, sections 3.6.2 and
//! 3.11 (normalised whole numbers); `KHR_mesh_quantization`.

use super::entry::{Entry, Result};
use super::store::Store;
use rutilant_geom::{Vec2, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// How a number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn read(entry: &Entry<'_, '_>) -> Result<Self> {
        Ok(match entry.whole(u64::from(u32::MAX))? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => {
                return Err(entry.wrong(format_args!(
                    "is {other}, but must be one of 5120, 5121, 5122, 5123, 5125 and 5126"
                )));
            }
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// A number stored so, the nearest there is.
    pub(super) fn bytes(self, number: f64) -> impl Iterator<Item = u8> {
        let bytes = match self {
            Self::I8 => (number as i8 as u32).to_le_bytes(),
            Self::U8 => u32::from(number as u8).to_le_bytes(),
            Self::I16 => (number as i16 as u32).to_le_bytes(),
            Self::U16 => u32::from(number as u16).to_le_bytes(),
            Self::U32 => (number as u32).to_le_bytes(),
            Self::F32 => (number as f32).to_le_bytes(),
        };
        bytes.into_iter().take(self.size())
    }
}

/// Numbers in an element, by the name of its type.
const WIDTHS: [(&str, usize); 7] =
    [("SCALAR", 1), ("VEC2", 2), ("VEC3", 3), ("VEC4", 4), ("MAT2", 4), ("MAT3", 9), ("MAT4", 16)];

/// Elements that differ from those below them.
#[derive(Clone, Debug)]
struct Sparse {
    count: usize,
    indices: Range,
    index: Component,
    values: Range,
}

/// Elements in a view, one every `stride` bytes.
#[derive(Clone, Debug)]
struct Range {
    view: usize,
    start: usize,
    stride: usize,
}

/// A typed array, as the document describes it.
#[derive(Debug)]
pub(super) struct Accessor {
    pub(super) count: usize,
    component: Component,
    kind: &'static str,
    width: usize,
    normalized: bool,
    range: Option<Range>,
    sparse: Option<Sparse>,
}

impl Accessor {
    fn read(entry: &Entry<'_, '_>, store: &Store<'_>) -> Result<Self> {
        let count = entry.need("count")?.size()?;
        let component = Component::read(&entry.need("componentType")?)?;
        let kind = entry.need("type")?;
        let name = kind.text()?;
        let Some(&(name, width)) = WIDTHS.iter().find(|(known, _)| *known == name) else {
            let names: Vec<_> = WIDTHS.iter().map(|(name, _)| *name).collect();
            let name = crate::shown::shown(name);
            let names = names.join(", ");
            return Err(kind.wrong(format_args!("is \"{name}\", but must be one of {names}")));
        };
        let normalized = entry.flag("normalized", false)?;
        let size = component.size() * width;
        let range = range(entry, entry, store, count, size, true)?;

        let sparse = entry.get("sparse")?.map(|entry| {
            let few = entry.need("count")?.size()?;
            if few > count {
                let what = format!("has {few} exceptions to {count} elements");
                return Err(entry.wrong(what));
            }
            let indices = entry.need("indices")?;
            let index = Component::read(&indices.need("componentType")?)?;
            let values = entry.need("values")?;
            let missing = |entry: &Entry<'_, '_>| entry.wrong("has no \"bufferView\"");
            Ok(Sparse {
                count: few,
                indices: range_in(&indices, store, few, index.size())?
                    .ok_or_else(|| missing(&indices))?,
                index,
                values: range_in(&values, store, few, size)?.ok_or_else(|| missing(&values))?,
            })
        });
        let sparse = sparse.transpose()?;
        Ok(Self { count, component, kind: name, width, normalized, range, sparse })
    }
}

fn range_in(
    entry: &Entry<'_, '_>,
    store: &Store<'_>,
    count: usize,
    size: usize,
) -> Result<Option<Range>> {
    range(entry, entry, store, count, size, false)
}

/// Where `count` elements of `size` bytes lie, by the keys of `entry`; checked against the view.
fn range(
    entry: &Entry<'_, '_>,
    at: &Entry<'_, '_>,
    store: &Store<'_>,
    count: usize,
    size: usize,
    strided: bool,
) -> Result<Option<Range>> {
    let Some(view) = entry.index_of("bufferView", "buffer view", store.views())? else {
        return Ok(None);
    };
    let start = entry.size_or_zero("byteOffset")?;
    let stride = store.stride(view).filter(|_| strided).unwrap_or(size);
    if stride < size {
        return Err(at.wrong(format_args!(
            "has elements of {size} bytes, but bufferViews[{view}] has a byteStride of {stride}"
        )));
    }
    let length = store.length(view);
    let end = match count.checked_sub(1) {
        None => Some(start),
        Some(last) => last
            .checked_mul(stride)
            .and_then(|bytes| bytes.checked_add(size))
            .and_then(|bytes| bytes.checked_add(start)),
    };
    match end {
        Some(end) if end <= length => Ok(Some(Range { view, start, stride })),
        end => {
            let end = end.map_or("too many".to_owned(), |end| end.to_string());
            Err(at.wrong(format_args!(
                "needs {end} bytes, but bufferViews[{view}] has only {length}"
            )))
        }
    }
}

/// How whole numbers are meant.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Whole {
    /// By the accessor's `normalized`.
    AsTold,
    /// As parts of the largest, whatever it says: what can be meant by nothing else.
    Parts,
}

/// Triangles of a list of indices, and the largest index in them.
type Triangles = (Arc<Vec<[u32; 3]>>, u32);

/// How vertices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Mode {
    List,
    Strip,
    Fan,
}

/// All accessors of a document, and what was unpacked of them.
pub(super) struct Accessors<'b> {
    pub(super) store: Store<'b>,
    all: Vec<Accessor>,
    scalars: HashMap<usize, Arc<Vec<f32>>>,
    vec2: HashMap<usize, Arc<Vec<Vec2>>>,
    vec3: HashMap<usize, Arc<Vec<Vec3>>>,
    vec4: HashMap<(usize, Whole), Arc<Vec<[f32; 4]>>>,
    joints: HashMap<usize, Arc<Vec<[u16; 4]>>>,
    triangles: HashMap<(usize, Mode), Triangles>,
}

impl<'b> Accessors<'b> {
    /// The accessors of a document.
    pub(super) fn read(root: &Entry<'_, '_>, store: Store<'b>) -> Result<Self> {
        let all = root.each("accessors", |entry| Accessor::read(entry, &store))?;
        Ok(Self {
            store,
            all,
            scalars: HashMap::new(),
            vec2: HashMap::new(),
            vec3: HashMap::new(),
            vec4: HashMap::new(),
            joints: HashMap::new(),
            triangles: HashMap::new(),
        })
    }

    /// The number of the accessor that `at` names.
    pub(super) fn index(&self, at: &Entry<'_, '_>) -> Result<usize> {
        at.index("accessor", self.all.len())
    }

    /// How many elements the accessor named at `at` has.
    pub(super) fn count(&self, at: &Entry<'_, '_>) -> Result<usize> {
        Ok(self.all[self.index(at)?].count)
    }

    /// Whether the accessor named at `at` has bytes of its own.
    pub(super) fn has_bytes(&self, at: &Entry<'_, '_>) -> Result<bool> {
        let accessor = &self.all[self.index(at)?];
        Ok(accessor.range.is_some() || accessor.sparse.is_some())
    }

    /// How many elements an accessor has.
    pub(super) fn length(&self, index: usize) -> usize {
        self.all[index].count
    }

    /// How an accessor's numbers are stored, and how many an element has.
    pub(super) fn layout(&self, index: usize) -> (Component, usize) {
        (self.all[index].component, self.all[index].width)
    }

    /// Gives bytes to an accessor that has none: all its elements, one after the other.
    pub(super) fn supply(&mut self, index: usize, bytes: Vec<u8>) {
        let accessor = &mut self.all[index];
        let stride = accessor.component.size() * accessor.width;
        debug_assert_eq!(bytes.len(), accessor.count * stride);
        accessor.range = Some(Range { view: self.store.add(bytes), start: 0, stride });
    }

    /// Whether the accessor named at `at` has elements of a type.
    pub(super) fn is(&self, at: &Entry<'_, '_>, kind: &str) -> Result<bool> {
        Ok(self.all[self.index(at)?].kind == kind)
    }

    /// Numbers, one by one, whatever the type.
    pub(super) fn scalars(&mut self, at: &Entry<'_, '_>) -> Result<Arc<Vec<f32>>> {
        let index = self.index(at)?;
        if let Some(known) = self.scalars.get(&index) {
            return Ok(known.clone());
        }
        let numbers = match self.all[index].width {
            1 => self.floats::<1>(index, Whole::AsTold, at)?.into_flattened(),
            2 => self.floats::<2>(index, Whole::AsTold, at)?.into_flattened(),
            3 => self.floats::<3>(index, Whole::AsTold, at)?.into_flattened(),
            4 => self.floats::<4>(index, Whole::AsTold, at)?.into_flattened(),
            _ => self.floats::<16>(index, Whole::AsTold, at)?.into_flattened(),
        };
        let numbers = Arc::new(numbers);
        self.scalars.insert(index, numbers.clone());
        Ok(numbers)
    }

    /// Pairs, texture coordinates for example.
    pub(super) fn vec2(&mut self, at: &Entry<'_, '_>) -> Result<Arc<Vec<Vec2>>> {
        let index = self.index(at)?;
        if let Some(known) = self.vec2.get(&index) {
            return Ok(known.clone());
        }
        let floats = self.floats(index, Whole::AsTold, at)?;
        let array = Arc::new(floats.into_iter().map(Vec2::from_array).collect::<Vec<_>>());
        self.vec2.insert(index, array.clone());
        Ok(array)
    }

    /// Triples: points and directions.
    pub(super) fn vec3(&mut self, at: &Entry<'_, '_>) -> Result<Arc<Vec<Vec3>>> {
        let index = self.index(at)?;
        if let Some(known) = self.vec3.get(&index) {
            return Ok(known.clone());
        }
        let floats = self.floats(index, Whole::AsTold, at)?;
        let array = Arc::new(floats.into_iter().map(Vec3::from_array).collect::<Vec<_>>());
        self.vec3.insert(index, array.clone());
        Ok(array)
    }

    /// Fours: tangents, weights, quaternions. Three become four with a 1: colours without alpha.
    pub(super) fn vec4(&mut self, at: &Entry<'_, '_>, whole: Whole) -> Result<Arc<Vec<[f32; 4]>>> {
        let index = self.index(at)?;
        if let Some(known) = self.vec4.get(&(index, whole)) {
            return Ok(known.clone());
        }
        let array = match self.all[index].width {
            3 => {
                self.store.budget.take(self.all[index].count, 16, at)?;
                let floats = self.floats::<3>(index, whole, at)?;
                floats.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
            }
            _ => self.floats(index, whole, at)?,
        };
        let array = Arc::new(array);
        self.vec4.insert((index, whole), array.clone());
        Ok(array)
    }

    /// Four joints for each vertex.
    pub(super) fn joints(&mut self, at: &Entry<'_, '_>) -> Result<Arc<Vec<[u16; 4]>>> {
        let index = self.index(at)?;
        if let Some(known) = self.joints.get(&index) {
            return Ok(known.clone());
        }
        let wide = self.wholes::<4>(index, at)?;
        let array: Vec<[u16; 4]> = wide
            .into_iter()
            .map(|four| four.map(|joint| u16::try_from(joint).unwrap_or(u16::MAX)))
            .collect();
        let array = Arc::new(array);
        self.joints.insert(index, array.clone());
        Ok(array)
    }

    /// Triangles of a list of indices.
    pub(super) fn triangles(&mut self, at: &Entry<'_, '_>, mode: Mode) -> Result<Triangles> {
        let index = self.index(at)?;
        if let Some(known) = self.triangles.get(&(index, mode)) {
            return Ok(known.clone());
        }
        let indices = self.wholes::<1>(index, at)?;
        if mode != Mode::List {
            self.store.budget.take(indices.len(), 12, at)?;
        }
        let largest = indices.iter().map(|[i]| *i).max().unwrap_or(0);
        let indices = indices.into_flattened();
        let triangles = match mode {
            Mode::List => indices.as_chunks::<3>().0.to_vec(),
            Mode::Strip | Mode::Fan => cut(mode, indices.len(), |i| indices[i]),
        };
        let triangles = (Arc::new(triangles), largest);
        self.triangles.insert((index, mode), triangles.clone());
        Ok(triangles)
    }

    /// Triangles of vertices in their own order.
    pub(super) fn unindexed(
        &mut self,
        count: usize,
        mode: Mode,
        at: &Entry<'_, '_>,
    ) -> Result<Arc<Vec<[u32; 3]>>> {
        let triangles = if mode == Mode::List { count / 3 } else { count };
        self.store.budget.take(triangles, 12, at)?;
        Ok(Arc::new(match mode {
            Mode::List => (0..count as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            Mode::Strip | Mode::Fan => cut(mode, count, |i| i as u32),
        }))
    }

    /// The elements of an accessor as floating-point numbers.
    fn floats<const N: usize>(
        &mut self,
        index: usize,
        whole: Whole,
        at: &Entry<'_, '_>,
    ) -> Result<Vec<[f32; N]>> {
        let accessor = &self.all[index];
        let parts = accessor.normalized || whole == Whole::Parts;
        // Section 3.11: the largest whole number stands for 1, and for signed ones its negative
        // for -1.
        let part = |x: f32, most: f32| if parts { (x / most).max(-1.0) } else { x };
        match accessor.component {
            Component::F32 => self.elements(index, at, f32::from_le_bytes),
            Component::I8 => {
                self.elements(index, at, |b: [u8; 1]| part(i8::from_le_bytes(b).into(), 127.0))
            }
            Component::U8 => self.elements(index, at, |[b]: [u8; 1]| part(b.into(), 255.0)),
            Component::I16 => {
                self.elements(index, at, |b: [u8; 2]| part(i16::from_le_bytes(b).into(), 32767.0))
            }
            Component::U16 => {
                self.elements(index, at, |b: [u8; 2]| part(u16::from_le_bytes(b).into(), 65535.0))
            }
            Component::U32 => self.elements(index, at, |b: [u8; 4]| u32::from_le_bytes(b) as f32),
        }
    }

    /// The elements of an accessor as whole numbers.
    fn wholes<const N: usize>(
        &mut self,
        index: usize,
        at: &Entry<'_, '_>,
    ) -> Result<Vec<[u32; N]>> {
        match self.all[index].component {
            Component::U8 => self.elements(index, at, |[b]: [u8; 1]| u32::from(b)),
            Component::U16 => self.elements(index, at, |b| u16::from_le_bytes(b).into()),
            Component::U32 => self.elements(index, at, u32::from_le_bytes),
            Component::I8 | Component::I16 | Component::F32 => {
                let what =
                    format!("names accessor {index}, which must hold whole numbers without a sign");
                Err(at.wrong(what))
            }
        }
    }

    /// The elements of an accessor, each number of `B` bytes understood by `number`.
    fn elements<const N: usize, const B: usize, T: Copy + Default>(
        &mut self,
        index: usize,
        at: &Entry<'_, '_>,
        number: impl Fn([u8; B]) -> T,
    ) -> Result<Vec<[T; N]>> {
        let accessor = &self.all[index];
        // Columns of small matrices are padded, and nothing needs them.
        if accessor.width != N || accessor.kind == "MAT2" {
            let (kind, _) = WIDTHS.iter().find(|(_, width)| *width == N).unwrap_or(&WIDTHS[0]);
            return Err(at.wrong(format_args!(
                "names accessor {index} of type {}, but must be {kind}",
                accessor.kind
            )));
        }
        self.store.budget.take(accessor.count, size_of::<[T; N]>(), at)?;
        let element = |bytes: &[u8]| {
            let mut element = [T::default(); N];
            for (number_of, bytes) in element.iter_mut().zip(bytes.as_chunks::<B>().0) {
                *number_of = number(*bytes);
            }
            element
        };
        let chunks = |range: &Range, count: usize| -> Result<_> {
            let bytes = self.store.bytes(range.view, at)?;
            Ok(bytes.get(range.start..).unwrap_or_default().chunks(range.stride.max(1)).take(count))
        };

        let mut elements: Vec<[T; N]> = match &accessor.range {
            Some(range) => chunks(range, accessor.count)?.map(element).collect(),
            None => vec![[T::default(); N]; accessor.count],
        };
        if let Some(sparse) = &accessor.sparse {
            let indices = chunks(&sparse.indices, sparse.count)?;
            let mut least = 0;
            for (bytes, value) in indices.zip(chunks(&sparse.values, sparse.count)?) {
                let index = match (sparse.index, bytes) {
                    (Component::U8, [a, ..]) => usize::from(*a),
                    (Component::U16, [a, b, ..]) => usize::from(u16::from_le_bytes([*a, *b])),
                    (Component::U32, [a, b, c, d, ..]) => {
                        u32::from_le_bytes([*a, *b, *c, *d]) as usize
                    }
                    _ => {
                        return Err(at.wrong(format_args!(
                            "names accessor {index}, whose sparse indices are no whole numbers"
                        )));
                    }
                };
                match elements.get_mut(index) {
                    Some(place) if index >= least => *place = element(value),
                    Some(_) | None => {
                        return Err(at.wrong(format_args!(
                            "names an accessor whose sparse index {index} is out of order or not \
                             below {}",
                            accessor.count
                        )));
                    }
                }
                least = index + 1;
            }
        }
        Ok(elements)
    }
}

/// Cuts a strip or a fan of `count` vertices into triangles. Those with a corner twice, by which
/// strips jump, are no triangles.
fn cut(mode: Mode, count: usize, vertex: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
    let triangle = |i: usize| {
        // The formulas of section 3.7.2.1.
        let corners = match mode {
            Mode::List => [3 * i, 3 * i + 1, 3 * i + 2],
            Mode::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Mode::Fan => [i + 1, i + 2, 0],
        };
        corners.map(&vertex)
    };
    let is_one = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    (0..count.saturating_sub(2)).map(triangle).filter(is_one).collect()
}
