//! Eight numbers at once, and points and directions made of them.
//!
//! Every operation is that of one number, eight times, rounded the same way: a
//! lane holds the bits that it would hold alone, whatever the processor has.
//!
//! Everything here is inlined into the function that chose the instructions;
//! what is not would be called, number by number. Closures are not, unless they
//! say so, and are rare for that.

use crate::Vec3;
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

/// Colours, points, directions of eight things in single precision.
pub type Xyz8<S> = Xyz<f32x8<S>>;

impl<S: Simd> Xyz8<S> {
    /// The same in each lane.
    #[inline(always)]
    pub fn splat(simd: S, v: [f32; 3]) -> Self {
        Self {
            x: f32x8::splat(simd, v[0]),
            y: f32x8::splat(simd, v[1]),
            z: f32x8::splat(simd, v[2]),
        }
    }

    /// From (coordinate, lane).
    #[inline(always)]
    pub fn load(simd: S, v: &[[f32; LANES]; 3]) -> Self {
        Self { x: v[0].simd_into(simd), y: v[1].simd_into(simd), z: v[2].simd_into(simd) }
    }

    /// As (coordinate, lane).
    #[inline(always)]
    pub fn store(self) -> [[f32; LANES]; 3] {
        [self.x.into(), self.y.into(), self.z.into()]
    }

    /// One lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// `self` where the mask is true.
    #[inline(always)]
    pub fn or(self, mask: mask32x8<S>, other: Self) -> Self {
        Self {
            x: mask.select(self.x, other.x),
            y: mask.select(self.y, other.y),
            z: mask.select(self.z, other.z),
        }
    }

    /// Coordinate by coordinate.
    #[inline(always)]
    pub fn times(self, o: Self) -> Self {
        Self { x: self.x * o.x, y: self.y * o.y, z: self.z * o.z }
    }

    /// The other way.
    #[inline(always)]
    pub fn negated(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }

    /// Of length one; as `glam` does it.
    #[inline(always)]
    pub fn normalized(self) -> Self {
        let one = f32x8::splat(self.x.token(), 1.0);
        self.scaled(one / self.dot(self).sqrt())
    }

    /// The largest coordinate.
    #[inline(always)]
    pub fn largest(self) -> f32x8<S> {
        self.x.max(self.y).max(self.z)
    }

    /// Where all coordinates are zero.
    #[inline(always)]
    pub fn is_zero(self) -> mask32x8<S> {
        let zero = f32x8::splat(self.x.token(), 0.0);
        self.x.simd_eq(zero) & self.y.simd_eq(zero) & self.z.simd_eq(zero)
    }
}

/// One of eight vectors, which are stored as (coordinate, lane).
#[inline(always)]
pub fn at(v: &[[f32; LANES]; 3], lane: usize) -> Vec3 {
    Vec3::new(v[0][lane], v[1][lane], v[2][lane])
}

/// The lanes of a set that has a bit for each.
#[inline(always)]
pub fn each_lane(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits.wrapping_sub(1);
            (lane < LANES).then_some(lane)
        },
    )
}
