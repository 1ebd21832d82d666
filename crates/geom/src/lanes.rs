//! Eight numbers at once, and points and directions made of them.
//!
//! Every operation is that of one number, eight times, rounded the same way: a
//! lane holds the bits that it would hold alone, whatever the processor has.
//!
//! Everything here is inlined into the function that chose the instructions;
//! what is not would be called, number by number. Closures are not, unless they
//! say so, which is why there are none.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8};
use std::ops::{Add, Mul, Sub};

/// How many.
pub const LANES: usize = 8;

/// A point or a direction for each lane.
#[derive(Clone, Copy, Debug)]
pub struct Xyz<T> {
    /// The first coordinate.
    pub x: T,
    /// The second.
    pub y: T,
    /// The third.
    pub z: T,
}

/// The same for each coordinate.
#[macro_export]
macro_rules! each {
    ($v:expr, $x:ident => $e:expr) => {{
        let v = $v;
        $crate::lanes::Xyz {
            x: {
                let $x = v.x;
                $e
            },
            y: {
                let $x = v.y;
                $e
            },
            z: {
                let $x = v.z;
                $e
            },
        }
    }};
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>> Xyz<T> {
    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, o: Self) -> T {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    /// The vector product.
    #[inline(always)]
    pub fn cross(self, o: Self) -> Self {
        Self {
            x: self.y * o.z - o.y * self.z,
            y: self.z * o.x - o.z * self.x,
            z: self.x * o.y - o.x * self.y,
        }
    }

    /// Times a number.
    #[inline(always)]
    pub fn scaled(self, s: T) -> Self {
        Self { x: self.x * s, y: self.y * s, z: self.z * s }
    }
}

impl<T: Add<Output = T>> Add for Xyz<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<T: Sub<Output = T>> Sub for Xyz<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

/// In double precision.
#[inline(always)]
pub fn widen<S: Simd>(v: f32x8<S>) -> f64x8<S> {
    let simd = v.token();
    let (low, high) = simd.widen_f32x8(v);
    simd.combine_f64x4(low, high)
}

/// Rounded to single precision.
#[inline(always)]
pub fn narrow<S: Simd>(v: f64x8<S>) -> f32x8<S> {
    let simd = v.token();
    let (low, high) = simd.split_f64x8(v);
    simd.narrow_f64x4(low, high)
}

/// A mask for double precision.
#[inline(always)]
pub fn widen_mask<S: Simd>(m: mask32x8<S>) -> mask64x8<S> {
    let simd = m.token();
    let (low, high) = simd.widen_mask32x8(m);
    simd.combine_mask64x4(low, high)
}

/// A mask for single precision.
#[inline(always)]
pub fn narrow_mask<S: Simd>(m: mask64x8<S>) -> mask32x8<S> {
    let simd = m.token();
    let (low, high) = simd.split_mask64x8(m);
    simd.narrow_mask64x4(low, high)
}
