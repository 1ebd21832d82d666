//! Compressed views: `EXT_meshopt_compression` and `KHR_meshopt_compression`.
//!
//! Attributes are stored as differences to the element before, byte by byte and
//! with few bits; triangles as edges and vertices that were used shortly
//! before; other indices as differences. Filters then make numbers of what
//! compresses well. Every stream has to be used up exactly.
//!
//! Source: Kapoulkine, Jasper St. Pierre et al., `KHR_meshopt_compression`,
//! 2025, appendices A and B, whose version 0 is that of
//! `EXT_meshopt_compression`, 2020.

use super::entry::{Entry, Result};
use crate::shown::shown;

/// Both names that the extension has.
pub(super) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// What a stream gives: `count` elements of `stride` bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) count: usize,
    pub(super) stride: usize,
    mode: Mode,
    filter: Filter,
}

impl Layout {
    /// From the extension's object.
    pub(super) fn read(entry: &Entry<'_, '_>) -> Result<Self> {
        let count = entry.need("count")?.size()?;
        let stride = entry.need("byteStride")?.whole(256)? as usize;
        let name = entry.need("mode")?;
        let mode = match name.text()? {
            "ATTRIBUTES" => Mode::Attributes,
            "TRIANGLES" => Mode::Triangles,
            "INDICES" => Mode::Indices,
            other => {
                let other = shown(other);
                return Err(name.wrong(format_args!(
                    "is \"{other}\", but must be ATTRIBUTES, TRIANGLES or INDICES"
                )));
            }
        };
        let filter = match entry.text_or_empty("filter")? {
            "" | "NONE" => Filter::None,
            "OCTAHEDRAL" => Filter::Octahedral,
            "QUATERNION" => Filter::Quaternion,
            "EXPONENTIAL" => Filter::Exponential,
            "COLOR" => Filter::Color,
            other => {
                let other = shown(other);
                return Err(entry.wrong(format_args!("has an unknown filter \"{other}\"")));
            }
        };
        let fits = match (mode, filter) {
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => matches!(stride, 4 | 8),
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            (Mode::Attributes, Filter::None | Filter::Exponential) => {
                stride > 0 && stride.is_multiple_of(4)
            }
            (Mode::Triangles, Filter::None) => matches!(stride, 2 | 4) && count.is_multiple_of(3),
            (Mode::Indices, Filter::None) => matches!(stride, 2 | 4),
            (Mode::Triangles | Mode::Indices, _) => false,
        };
        if !fits {
            return Err(entry.wrong(format_args!(
                "has a mode, a filter, a byteStride of {stride} and a count of {count} that do \
                 not go together"
            )));
        }
        Ok(Self { count, stride, mode, filter })
    }
}

type Decoded<T> = std::result::Result<T, String>;

/// The elements of a stream.
pub(super) fn decode(layout: &Layout, bytes: &[u8]) -> Decoded<Vec<u8>> {
    let mut decoded = match layout.mode {
        Mode::Attributes => attributes(layout, bytes)?,
        Mode::Triangles => triangles(layout, bytes)?,
        Mode::Indices => indices(layout, bytes)?,
    };
    filter(layout, &mut decoded);
    Ok(decoded)
}

/// Bytes that are taken one after the other.
struct Stream<'b> {
    rest: &'b [u8],
}

impl<'b> Stream<'b> {
    fn take(&mut self, count: usize) -> Decoded<&'b [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or("is cut off")?;
        self.rest = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Decoded<u8> {
        self.take(1).map(|byte| byte[0])
    }

    /// A number of seven bits a byte, the lowest first.
    fn number(&mut self) -> Decoded<u32> {
        let mut number = 0;
        for i in 0..5 {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << (7 * i);
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err("holds a number of too many bytes".to_owned())
    }

    fn end(&self) -> Decoded<()> {
        match self.rest.len() {
            0 => Ok(()),
            left => Err(format!("has {left} bytes too many")),
        }
    }
}

/// The stream between a header byte, which must be one of `headers`, and `tail` bytes at the
/// end; with the header and the tail.
fn frame<'b>(bytes: &'b [u8], headers: &[u8], tail: usize) -> Decoded<(Stream<'b>, &'b [u8])> {
    let Some((&header, rest)) = bytes.split_first() else { return Err("is empty".to_owned()) };
    if !headers.contains(&header) {
        return Err(format!("begins with {header:#04x}, which is not its mode's header"));
    }
    let start = rest.len().checked_sub(tail).ok_or("is cut off")?;
    let (rest, tail) = rest.split_at(start);
    Ok((Stream { rest }, tail))
}

/// Elements are taken together in groups of so many.
const GROUP: usize = 16;
/// And blocks of at most so many, or so many bytes.
const BLOCK: usize = 256;
const BLOCK_BYTES: usize = 8192;

/// Mode 0.
fn attributes(layout: &Layout, bytes: &[u8]) -> Decoded<Vec<u8>> {
    let (count, stride) = (layout.count, layout.stride);
    let newer = bytes.first() == Some(&0xa1);
    let channels = stride / 4;
    let (baseline_at, least) = if newer { (stride + channels, 24) } else { (stride, 32) };
    let (mut stream, tail) = frame(bytes, &[0xa0, 0xa1], baseline_at.max(least))?;
    let tail = &tail[tail.len() - baseline_at..];
    let (baseline, modes) = tail.split_at(stride);
    if let Some(mode) = modes.iter().find(|&&m| m & 15 > 2 || (m & 15 < 2 && m > 15)) {
        return Err(format!("has an unknown channel mode {mode:#04x}"));
    }

    let mut elements = vec![0; count * stride];
    let mut before = baseline.to_vec();
    let most = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(BLOCK);
    let mut planes = vec![[0_u8; BLOCK]; stride];
    for block in elements.chunks_mut(most * stride) {
        // The differences of a block, for each byte of an element on its own.
        let size = block.len() / stride;
        let groups = size.div_ceil(GROUP);
        let control = stream.take(if newer { channels } else { 0 })?;
        for (k, plane) in planes.iter_mut().enumerate() {
            let widths = match control.get(k / 4).map(|byte| byte >> (2 * (k % 4)) & 3) {
                None => [0, 2, 4, 8],
                Some(0) => [0, 1, 2, 4],
                Some(1) => [1, 2, 4, 8],
                Some(2) => {
                    plane.fill(0);
                    continue;
                }
                Some(_) => {
                    plane[..size].copy_from_slice(stream.take(size)?);
                    continue;
                }
            };
            let header = stream.take(groups.div_ceil(4))?;
            for (g, group) in plane.as_chunks_mut::<GROUP>().0.iter_mut().take(groups).enumerate() {
                let width = widths[usize::from(header[g / 4] >> (2 * (g % 4)) & 3)];
                *group = deltas(&mut stream, width)?;
            }
        }

        // Each element from the one before.
        for (i, element) in block.chunks_mut(stride).enumerate() {
            let fours = element.as_chunks_mut::<4>().0.iter_mut().zip(planes.as_chunks::<4>().0);
            for (channel, (new, planes)) in fours.enumerate() {
                let old = &mut before.as_chunks_mut::<4>().0[channel];
                let mode = modes.get(channel).copied().unwrap_or(0);
                *old = add(mode, *old, planes.each_ref().map(|plane| plane[i]));
                *new = *old;
            }
        }
    }
    stream.end()?;
    Ok(elements)
}

/// The differences of a group, each of `width` bits, or a byte where all bits are set.
fn deltas(stream: &mut Stream<'_>, width: usize) -> Decoded<[u8; GROUP]> {
    let mut deltas = [0; GROUP];
    if width == 8 {
        deltas.copy_from_slice(stream.take(GROUP)?);
    } else if width > 0 {
        let packed = stream.take(2 * width)?;
        let sentinel = (1 << width) - 1;
        let each = 8 / width;
        for (i, delta) in deltas.iter_mut().enumerate() {
            let place = i % each;
            // One bit each from the lowest, all others from the highest.
            let shift = if width == 1 { place } else { 8 - width * (place + 1) };
            *delta = packed[i / each] >> shift & sentinel;
            if *delta == sentinel {
                *delta = stream.byte()?;
            }
        }
    }
    Ok(deltas)
}

/// Four bytes from those before and their difference, which a channel mode tells how to add.
fn add(mode: u8, old: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
    match mode & 15 {
        0 => std::array::from_fn(|i| {
            let v = delta[i];
            let change = if v & 1 == 1 { !(v >> 1) } else { v >> 1 };
            old[i].wrapping_add(change)
        }),
        1 => {
            let half = |i: usize| {
                let v = u16::from_le_bytes([delta[i], delta[i + 1]]);
                let change = if v & 1 == 1 { !(v >> 1) } else { v >> 1 };
                u16::from_le_bytes([old[i], old[i + 1]]).wrapping_add(change).to_le_bytes()
            };
            let ([a, b], [c, d]) = (half(0), half(2));
            [a, b, c, d]
        }
        _ => {
            let change = u32::from_le_bytes(delta).rotate_left(u32::from(mode >> 4));
            (u32::from_le_bytes(old) ^ change).to_le_bytes()
        }
    }
}

/// What was added last, up to 16 things of it.
struct Fifo<T> {
    items: [T; 16],
    count: usize,
}

impl<T: Copy> Fifo<T> {
    fn new(nothing: T) -> Self {
        Self { items: [nothing; 16], count: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.count % 16] = item;
        self.count += 1;
    }

    /// The one added `back` before the last.
    fn get(&self, back: u8) -> Decoded<T> {
        let at = self.count.checked_sub(usize::from(back) + 1);
        let at = at.ok_or("refers to what was not there yet")?;
        Ok(self.items[at % 16])
    }
}

/// How indices are told: as the next new one, or by their difference to the last told.
#[derive(Default)]
struct Counter {
    next: u32,
    last: u32,
}

impl Counter {
    fn new_one(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn told(&mut self, data: &mut Stream<'_>) -> Decoded<u32> {
        self.last = self.last.wrapping_add(unfolded(data.number()?));
        Ok(self.last)
    }
}

/// A difference with its sign from a number with the sign in its lowest bit.
fn unfolded(v: u32) -> u32 {
    if v & 1 == 1 { !(v >> 1) } else { v >> 1 }
}

/// Mode 1.
fn triangles(layout: &Layout, bytes: &[u8]) -> Decoded<Vec<u8>> {
    let (mut data, table) = frame(bytes, &[0xe1], 16)?;
    if table[14..] != [0, 0] || table.iter().any(|b| b & 15 == 15 || b >> 4 == 15) {
        return Err("has a table that breaks its rules".to_owned());
    }
    let codes = data.take(layout.count / 3)?;
    let mut edges = Fifo::new([0_u32; 2]);
    let mut vertices = Fifo::new(0_u32);
    let mut counter = Counter::default();
    let mut out = Vec::with_capacity(layout.count * layout.stride);
    for &code in codes {
        let (x, y) = (code >> 4, code & 15);
        let triangle = if x < 15 {
            // An edge that was used before, and a third vertex.
            let [a, b] = edges.get(x)?;
            let c = match y {
                0 => counter.new_one(),
                1..=12 => vertices.get(y)?,
                13 | 14 => {
                    let step = if y == 13 { u32::MAX } else { 1 };
                    counter.last = counter.last.wrapping_add(step);
                    counter.last
                }
                _ => counter.told(&mut data)?,
            };
            edges.push([c, b]);
            edges.push([a, c]);
            if y == 0 || y > 12 {
                vertices.push(c);
            }
            [a, b, c]
        } else {
            // Three vertices, each new, used before, or told.
            let is_short = y < 14;
            let more = if is_short { table[usize::from(y)] } else { data.byte()? };
            if !is_short && more == 0 {
                counter.next = 0;
            }
            let a = if y == 15 { counter.told(&mut data)? } else { counter.new_one() };
            let mut vertex = |how: u8| match how {
                0 => Ok(counter.new_one()),
                15 => counter.told(&mut data),
                _ => vertices.get(how - 1),
            };
            let (z, w) = (more >> 4, more & 15);
            let b = vertex(z)?;
            let c = vertex(w)?;
            edges.push([b, a]);
            edges.push([c, b]);
            edges.push([a, c]);
            vertices.push(a);
            for (how, index) in [(z, b), (w, c)] {
                if how == 0 || how == 15 {
                    vertices.push(index);
                }
            }
            [a, b, c]
        };
        for index in triangle {
            write_index(&mut out, index, layout.stride);
        }
    }
    data.end()?;
    Ok(out)
}

/// Mode 2.
fn indices(layout: &Layout, bytes: &[u8]) -> Decoded<Vec<u8>> {
    let (mut data, _) = frame(bytes, &[0xd1], 4)?;
    // An index takes a byte at least.
    if layout.count > data.rest.len() {
        return Err("is cut off".to_owned());
    }
    let mut last = [0_u32; 2];
    let mut out = Vec::with_capacity(layout.count * layout.stride);
    for _ in 0..layout.count {
        let v = data.number()?;
        let base = &mut last[(v & 1) as usize];
        *base = base.wrapping_add(unfolded(v >> 1));
        write_index(&mut out, *base, layout.stride);
    }
    data.end()?;
    Ok(out)
}

fn write_index(out: &mut Vec<u8>, index: u32, stride: usize) {
    out.extend_from_slice(&index.to_le_bytes()[..stride]);
}

/// Makes numbers of what was easy to compress. The names are those of appendix B.
fn filter(layout: &Layout, bytes: &mut [u8]) {
    let is_small = layout.stride == 4;
    match layout.filter {
        Filter::None => {}
        Filter::Octahedral if is_small => {
            for four in bytes.as_chunks_mut::<4>().0 {
                let input = four.map(|byte| f32::from(byte.cast_signed()));
                let [x, y, z] = octahedral(input, 127.0);
                *four = [x as i8 as u8, y as i8 as u8, z as i8 as u8, four[3]];
            }
        }
        Filter::Octahedral => {
            each_i16(bytes, |four| {
                let [x, y, z] = octahedral(four.map(f32::from), 32767.0);
                [x as i16, y as i16, z as i16, four[3]]
            });
        }
        Filter::Quaternion => each_i16(bytes, quaternion),
        Filter::Exponential => {
            for four in bytes.as_chunks_mut::<4>().0 {
                let input = i32::from_le_bytes(*four);
                // 2^e in double precision has e + 1023 in its exponent; all products are exact
                // there.
                let power = f64::from_bits((((input >> 24) + 1023) as u64) << 52);
                *four = ((f64::from((input << 8) >> 8) * power) as f32).to_le_bytes();
            }
        }
        Filter::Color if is_small => {
            for four in bytes.as_chunks_mut::<4>().0 {
                let [y, co, cg, alpha] = *four;
                let chroma = [co, cg].map(|byte| i32::from(byte.cast_signed()));
                *four = color(y.into(), chroma, alpha.into(), 255.0).map(|c| c as u8);
            }
        }
        Filter::Color => {
            each_i16(bytes, |[y, co, cg, alpha]| {
                let chroma = [co, cg].map(i32::from);
                let [y, alpha] = [y, alpha].map(|v| u32::from(v.cast_unsigned()));
                color(y, chroma, alpha, 65535.0).map(|c| (c as u16).cast_signed())
            });
        }
    }
}

fn each_i16(bytes: &mut [u8], change: impl Fn([i16; 4]) -> [i16; 4]) {
    for [a, b, c, d, e, f, g, h] in bytes.as_chunks_mut::<8>().0 {
        let four = [[*a, *b], [*c, *d], [*e, *f], [*g, *h]].map(i16::from_le_bytes);
        [[*a, *b], [*c, *d], [*e, *f], [*g, *h]] = change(four).map(i16::to_le_bytes);
    }
}

/// Filter 1: a unit vector in steps of 1 / `most`.
fn octahedral([x, y, one, _]: [f32; 4], most: f32) -> [f32; 3] {
    let (x, y) = (x / one, y / one);
    let z = 1.0 - x.abs() - y.abs();
    let t = z.min(0.0);
    let (x, y) = (x - t.copysign(x), y - t.copysign(y));
    let scale = most / (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|v| (v * scale).round())
}

/// Filter 2: the three smaller parts of a quaternion, and which is the largest.
fn quaternion([x, y, z, told]: [i16; 4]) -> [i16; 4] {
    let one = f32::from(told | 3);
    let small = [x, y, z].map(|v| f32::from(v) / one * std::f32::consts::FRAC_1_SQRT_2);
    let squares: f32 = small.iter().map(|v| v * v).sum();
    let largest = (told & 3) as usize;
    let mut out = [0; 4];
    out[largest] = ((1.0 - squares).max(0.0).sqrt() * 32767.0).round() as i16;
    for (i, v) in small.into_iter().enumerate() {
        out[(largest + 1 + i) % 4] = (v * 32767.0).round() as i16;
    }
    out
}

/// Filter 4: red, green, blue and alpha in steps of 1 / `most`.
fn color(y: u32, [co, cg]: [i32; 2], alpha: u32, most: f32) -> [f32; 4] {
    let y = y as i32;
    let bits = 32 - alpha.leading_zeros();
    let all = (1_i32 << bits) - 1;
    let a = alpha as i32 & (all >> 1);
    let scale = most / all as f32;
    [y + co - cg, y + cg, y - co - cg, a << 1 | (a & 1)].map(|c| (c as f32 * scale).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(count: usize, stride: usize, mode: Mode, filter: Filter) -> Layout {
        Layout { count, stride, mode, filter }
    }

    /// The worked example of the specification's appendix A: 4-bit differences with sentinels.
    #[test]
    fn deltas_are_those_of_the_specification() {
        let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut stream = Stream { rest: &packed };
        let codes = deltas(&mut stream, 4).expect("complete");
        stream.end().expect("used up");
        let signed = codes.map(|code| add(0, [0; 4], [code, 0, 0, 0])[0].cast_signed());
        assert_eq!(signed, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0]);
    }

    /// The first two numbers of the specification's appendix A (its third has its bytes the other
    /// way round, against the LEB128 that it names), one of DWARF 5, section 7.6, and one too long.
    #[test]
    fn numbers_have_seven_bits_a_byte() {
        let number = |rest: &[u8]| Stream { rest }.number();
        assert_eq!(number(&[0x7f]), Ok(0x7f));
        assert_eq!(number(&[0x81, 0x04]), Ok(0x201));
        assert_eq!(number(&[0xb9, 0x64]), Ok(12857));
        assert!(number(&[0x80; 6]).is_err());
        assert!(number(&[0x80; 4]).is_err());
    }

    /// A stream of 17 elements of 4 bytes, written by hand for each version: the first byte
    /// counts up by one, the others stay at the baseline.
    #[test]
    fn attributes_count_up() {
        let expected: Vec<u8> = (1..=17).flat_map(|i| [i, 7, 8, 9]).collect();
        // Version 0: groups of 8-bit and 2-bit differences, then three planes of nothing. A
        // difference of 1 is 2 with its sign folded in.
        let mut old = vec![0xa0, 0b0111];
        old.extend([2; 16]);
        old.extend([0b10_00_00_00, 0, 0, 0]);
        old.extend([0, 0, 0]);
        old.extend([0; 28]);
        old.extend([0, 7, 8, 9]);
        let decoded = decode(&layout(17, 4, Mode::Attributes, Filter::None), &old);
        assert_eq!(decoded.as_ref(), Ok(&expected));
        // Version 1: literal differences of two bytes (mode 1), or XOR.
        let mut new = vec![0xa1, 0b10_10_10_11];
        new.extend([2; 17]);
        new.extend([0; 19]);
        new.extend([0, 7, 8, 9, 1]);
        assert_eq!(decode(&layout(17, 4, Mode::Attributes, Filter::None), &new), Ok(expected));
        let tail = new.len() - 1;
        new[tail] = 2;
        let xor: Vec<u8> =
            (0..17).flat_map(|i| [if i % 2 == 0 { 2 } else { 0 }, 7, 8, 9]).collect();
        assert_eq!(decode(&layout(17, 4, Mode::Attributes, Filter::None), &new), Ok(xor));
        // What is missing or too much is noticed, wherever.
        for end in 0..old.len() {
            let cut = decode(&layout(17, 4, Mode::Attributes, Filter::None), &old[..end]);
            assert!(cut.is_err(), "cut at {end}");
        }
    }

    /// Two triangles that share an edge, told as new vertices and then as an edge with one more.
    #[test]
    fn triangles_share_edges() {
        let mut stream = vec![0xe1, 0xf0, 0x10];
        stream.extend([0; 16]);
        let decoded = decode(&layout(6, 2, Mode::Triangles, Filter::None), &stream);
        let indices = |bytes: Vec<u8>| bytes.chunks(2).map(|b| b[0]).collect::<Vec<_>>();
        // The first triangle is 0 1 2; the last edges are those from 1 to 0, 2 to 1 and 0 to 2.
        assert_eq!(decoded.map(indices), Ok(vec![0, 1, 2, 2, 1, 3]));
        // An edge before there is any.
        stream.splice(1..3, [0x00, 0x00]);
        assert!(decode(&layout(6, 2, Mode::Triangles, Filter::None), &stream).is_err());
    }

    /// Steps of +1 on the first base line, then -1 on the second.
    #[test]
    fn indices_have_two_base_lines() {
        let stream = [0xd1, 0b0100, 0b0100, 0b0011, 0, 0, 0, 0];
        let decoded = decode(&layout(3, 4, Mode::Indices, Filter::None), &stream);
        let expected = [1, 2, u32::MAX].iter().flat_map(|i| i.to_le_bytes()).collect();
        assert_eq!(decoded, Ok(expected));
    }

    /// Filters against their definitions in numbers one can see through.
    #[test]
    fn filters_give_what_they_stand_for() {
        // One half of the way from +x to -z, on the lower side of the octahedron.
        let [x, y, z] = octahedral([127.0, 127.0, 127.0, 0.0], 127.0);
        assert_eq!([x, y, z], [0.0, 0.0, -127.0]);
        assert_eq!(octahedral([127.0, 0.0, 127.0, 0.0], 32767.0), [32767.0, 0.0, 0.0]);
        // No rotation: w is the largest, all others are nought.
        assert_eq!(quaternion([0, 0, 0, 0x7ff]), [0, 0, 0, 32767]);
        // A quarter turn around x: two parts of 1 / sqrt(2), the first of them the largest.
        let half = (32767.0 * std::f32::consts::FRAC_1_SQRT_2).round() as i16;
        let [x, y, z, w] = quaternion([0, 0, 0x7ff, 0x7fc]);
        assert!((x - half).abs() <= 1 && (w - half).abs() <= 1 && y == 0 && z == 0, "{x} {w}");
        for (e, m, value) in [(0, 1, 1.0), (-1, 3, 1.5), (4, -2, -32.0), (-100, 1, 7.888_609e-31)] {
            let mut bytes = (e << 24 | (m & 0xff_ffff_i32)).to_le_bytes();
            filter(&layout(1, 4, Mode::Attributes, Filter::Exponential), &mut bytes);
            assert_eq!(f32::from_le_bytes(bytes), value);
        }
        // Grey of full brightness, opaque: Y is 255, the alpha's seven bits are all set.
        assert_eq!(color(255, [0, 0], 255, 255.0), [255.0; 4]);
        // Red: Y a quarter, Co a half, Cg minus a quarter of 255, in integers.
        assert_eq!(color(64, [127, -64], 255, 255.0), [255.0, 0.0, 1.0, 255.0]);
    }
}
