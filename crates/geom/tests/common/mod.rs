//! What the proofs of this crate share: random numbers, meshes, scenes, and an
//! independent way to find hits.

#![allow(dead_code, reason = "no test uses everything")]

pub(crate) mod brute;
pub(crate) mod meshes;

use rutilant_geom::{Ray, Surfaces, Vec3};
use std::f32::consts::LOG2_10;

/// Random numbers that are the same everywhere: a hash of a counter.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn bits(&mut self) -> u64 {
        // Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators", 2014.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// In the cube from -1 to 1.
    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let p = self.point();
            if p.length_squared() <= 1.0 && p.length_squared() > 1e-4 {
                return p.normalize();
            }
        }
    }

    /// 10 to the power of something between the two, roughly evenly: powers of two times 1 to 2.
    pub(crate) fn size(&mut self, low: i32, high: i32) -> f32 {
        let exponent = (self.between(low as f32, high as f32) * LOG2_10).round();
        self.between(1.0, 2.0) * f32::from_bits(((127 + exponent as i32) as u32) << 23)
    }
}

/// A ray for a scene: from around it, half of the time aimed at the exact vertex,
/// edge or inside of a primitive, else at any place.
pub(crate) fn aimed_ray(scene: &Surfaces, random: &mut Random) -> Ray {
    let bounds = scene.bounds();
    let (center, half) = (bounds.center(), bounds.extent() * 0.5);
    let origin = center + random.point() * half * 1.5;
    let primitive = random.below(scene.triangles().len().max(1));
    let target = if random.unit() < 0.5 || scene.triangles().is_empty() {
        center + random.point() * half
    } else {
        let [a, b, c] = scene.triangle(primitive as u32);
        match random.below(4) {
            0 => a,
            1 => (a + b) * 0.5,
            2 => a + (c - a) * random.unit(),
            _ => (a + b + c) / 3.0,
        }
    };
    let mut ray = Ray::new(origin, target - origin);
    if random.unit() < 0.25 {
        ray.t_min = random.unit();
        ray.t_max = ray.t_min + random.unit();
    }
    ray
}
