//! The body of a PLY file as what it is: numbers, one after the other, as text or as bytes.

use super::header::Scalar;
use crate::error::Source;
use crate::scene::text::{self, Cursor, place};
use std::path::Path;

/// Why a number could not be read.
pub(super) enum Trouble {
    /// The bytes are used up.
    End,
    /// What stands there is not a number of the declared type.
    NotANumber,
}

/// The body of a file: numbers, one after the other.
pub(super) trait Body {
    /// Where the next number begins, more or less: for messages and for coming back.
    fn at(&self) -> usize;
    /// Goes to where [`at`](Self::at) once was.
    fn go_to(&mut self, at: usize);
    /// Bytes from here to the end of the file.
    fn left(&self) -> usize;
    /// The fewest bytes that a number takes.
    fn least_size(scalar: Scalar) -> usize;
    /// The next number, rounded to f32 if need be.
    fn float(&mut self, scalar: Scalar) -> Result<f32, Trouble>;
    /// The next number, of an integer type.
    fn integer(&mut self, scalar: Scalar) -> Result<i64, Trouble>;
    /// Steps over `count` numbers.
    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), Trouble>;
    /// The position of the next number in the lines of the file; `None` if it has no lines.
    fn place(&self, path: &Path, bytes: &[u8]) -> Option<Source>;
    /// Whether nothing but blanks is left.
    fn is_done(&self) -> bool;
}

/// Numbers as text. Line ends are blanks like any other.
pub(super) struct Ascii<'a>(pub(super) Cursor<'a>);

impl Ascii<'_> {
    fn trouble(&self) -> Trouble {
        if self.0.peek().is_none() { Trouble::End } else { Trouble::NotANumber }
    }
}

impl Body for Ascii<'_> {
    fn at(&self) -> usize {
        self.0.at
    }

    fn go_to(&mut self, at: usize) {
        self.0.at = at;
    }

    fn left(&self) -> usize {
        self.0.rest().len()
    }

    fn least_size(_: Scalar) -> usize {
        2
    }

    #[inline]
    fn float(&mut self, _: Scalar) -> Result<f32, Trouble> {
        self.0.skip_space();
        self.0.number().ok_or_else(|| self.trouble())
    }

    #[inline]
    fn integer(&mut self, _: Scalar) -> Result<i64, Trouble> {
        self.0.skip_space();
        let start = self.0.at;
        match self.0.whole_number() {
            Some(value) if self.0.peek().is_none_or(text::is_space) => Ok(value),
            _ => {
                self.0.at = start;
                Err(self.trouble())
            }
        }
    }

    fn skip(&mut self, _: Scalar, count: usize) -> Result<(), Trouble> {
        for _ in 0..count {
            self.0.skip_space();
            if self.0.word().is_empty() {
                return Err(Trouble::End);
            }
        }
        Ok(())
    }

    fn place(&self, path: &Path, bytes: &[u8]) -> Option<Source> {
        let mut here = self.0;
        here.skip_space();
        Some(place(path, bytes, here.at))
    }

    fn is_done(&self) -> bool {
        self.0.rest().iter().all(|&byte| text::is_space(byte))
    }
}

/// Numbers as bytes, the lowest first if `LITTLE`.
pub(super) struct Binary<'a, const LITTLE: bool> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl<const LITTLE: bool> Binary<'_, LITTLE> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Trouble> {
        let bytes = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>());
        let mut bytes = *bytes.ok_or(Trouble::End)?;
        self.at += N;
        if !LITTLE {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const LITTLE: bool> Body for Binary<'_, LITTLE> {
    fn at(&self) -> usize {
        self.at
    }

    fn go_to(&mut self, at: usize) {
        self.at = at;
    }

    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn least_size(scalar: Scalar) -> usize {
        scalar.size()
    }

    #[inline]
    fn float(&mut self, scalar: Scalar) -> Result<f32, Trouble> {
        match scalar {
            Scalar::F32 => Ok(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => Ok(f64::from_le_bytes(self.take()?) as f32),
            _ => Ok(self.integer(scalar)? as f32),
        }
    }

    #[inline]
    fn integer(&mut self, scalar: Scalar) -> Result<i64, Trouble> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::F32 | Scalar::F64 => return Err(Trouble::NotANumber),
        })
    }

    fn skip(&mut self, scalar: Scalar, count: usize) -> Result<(), Trouble> {
        match scalar.size().checked_mul(count) {
            Some(size) if size <= self.left() => {
                self.at += size;
                Ok(())
            }
            _ => Err(Trouble::End),
        }
    }

    fn place(&self, _: &Path, _: &[u8]) -> Option<Source> {
        None
    }

    fn is_done(&self) -> bool {
        self.left() == 0
    }
}
