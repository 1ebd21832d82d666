//! Where a ray met a surface.

use crate::bsdf::{Bsdf, BsdfSample};
use crate::color::Spectrum;
use crate::light::ShadingPoint;
use rutilant_geom::{Frame, Ray, Vec3, offset_origin};

/// A surface point as the integrators see it.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceInteraction {
    /// The point, each coordinate rounded once.
    pub position: Vec3,
    /// Unit normal of the true surface, on its front.
    pub normal: Vec3,
    /// Unit direction back to where the ray came from.
    pub wo: Vec3,
    /// Where scattering is described: z is the interpolated normal, on the front, bent where
    /// needed so that `wo` and its mirror image stay on their side of the true surface.
    pub shading: Frame,
    /// The point moved onto the smooth surface that the vertex normals describe; diffusely
    /// scattered rays on the side of `wo` start here.
    smooth_position: Vec3,
    leaning: Leaning,
    /// The number of the material in the prepared scene.
    pub material: u32,
    /// The number of the emitter that this surface is, if it glows.
    pub emitter: Option<u32>,
    /// What is left of the emitter's light here: white where it is the same everywhere.
    pub(crate) glow: Spectrum,
}

/// How the shading normal lies to the true one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Leaning {
    /// It is the true one.
    None,
    /// It is interpolated.
    Interpolated,
    /// It had to be bent for `wo`.
    Bent,
}

impl SurfaceInteraction {
    /// A point on a surface that is as smooth as it looks.
    pub(crate) fn new(
        position: Vec3,
        normal: Vec3,
        wo: Vec3,
        material: u32,
        emitter: Option<u32>,
    ) -> Self {
        let shading = Frame::around(normal);
        let leaning = Leaning::None;
        Self {
            position,
            normal,
            wo,
            shading,
            smooth_position: position,
            leaning,
            material,
            emitter,
            glow: Spectrum::WHITE,
        }
    }

    /// A point on a triangle with vertex normals, interpolated to `normal` (any length).
    /// `corners` are the vertices with their unit normals and barycentric weights.
    pub(crate) fn smoothed(self, normal: Vec3, corners: [(Vec3, Vec3, f32); 3]) -> Self {
        let Some(normal) = normal.try_normalize() else { return self };
        let normal = if normal.dot(self.normal) < 0.0 { -normal } else { normal };
        let seen_side = if self.wo.dot(self.normal) < 0.0 { -1.0 } else { 1.0 };
        let bent =
            seen_side * consistent_normal(seen_side * normal, seen_side * self.normal, self.wo);

        // Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4: the point is
        // lifted out of each vertex's tangent plane that lies above it.
        let lift = corners.into_iter().fold(Vec3::ZERO, |lift, (vertex, n, weight)| {
            let n = if n.dot(self.normal) * seen_side < 0.0 { -n } else { n };
            lift - n * (weight * (self.position - vertex).dot(n).min(0.0))
        });
        let leaning = if bent == normal { Leaning::Interpolated } else { Leaning::Bent };
        let smooth_position = self.position + lift;
        Self { shading: Frame::around(bent), smooth_position, leaning, ..self }
    }

    /// The same where light that comes another way would see another normal.
    pub(crate) fn seen_by_the_camera_alone(self) -> Self {
        Self { leaning: Leaning::Bent, ..self }
    }

    /// The normal of a layer above the surface, any length, as a unit vector in the shading frame, on
    /// the front: bent where needed so that `wo` and its mirror image stay on their side of the true
    /// surface, and of the plane that the shading normal describes.
    pub(crate) fn bent(&self, normal: Vec3) -> Vec3 {
        let normal = normal.normalize_or(self.normal);
        let front = if normal.dot(self.normal) < 0.0 { -1.0 } else { 1.0 };
        let side = if self.wo.dot(self.normal) < 0.0 { -1.0 } else { 1.0 };
        let above = consistent_normal(side * front * normal, side * self.normal, self.wo);
        let above = consistent_normal(above, side * self.shading.z, self.wo);
        self.shading.to_local(side * above).normalize()
    }

    /// True where the shading normal is the true one.
    pub(crate) fn is_flat(&self) -> bool {
        self.leaning == Leaning::None
    }

    /// How much denser paths become, per projected area and solid angle, when they come from `wi`
    /// and are sent to `wo` in a single direction by a normal that is not the true one: Veach 1997,
    /// section 5.3. `None` where light that comes from `wi` would see another normal than light
    /// that comes from `wo`, so that it cannot take the same way.
    pub(crate) fn squeeze(&self, wi: Vec3) -> Option<f32> {
        let [shaded_o, true_o] = [self.shading.z.dot(self.wo), self.normal.dot(self.wo)];
        let [shaded_i, true_i] = [self.shading.z.dot(wi), self.normal.dot(wi)];
        let side = if true_i < 0.0 { -1.0 } else { 1.0 };
        let straight = match self.leaning {
            Leaning::None => return Some(1.0),
            Leaning::Bent => false,
            Leaning::Interpolated => {
                let (shading, normal) = (side * self.shading.z, side * self.normal);
                consistent_normal(shading, normal, wi) == shading
            }
        };
        let factor = (shaded_o * true_i) / (true_o * shaded_i);
        (straight && shaded_o * true_o > 0.0 && shaded_i * true_i > 0.0).then_some(factor)
    }

    /// `wo` in the shading frame. Its z is positive exactly on the front.
    #[inline]
    pub fn wo_local(&self) -> Vec3 {
        self.shading.to_local(self.wo)
    }

    /// Where diffusely scattered rays start, before they are moved off.
    pub(crate) fn smooth_position(&self) -> Vec3 {
        self.smooth_position
    }

    /// True where those start elsewhere than on the true surface.
    pub(crate) fn is_lifted(&self) -> bool {
        self.smooth_position != self.position
    }

    /// The way from the true surface to where they start.
    pub(crate) fn lift(&self) -> Ray {
        Ray::between(self.surface_origin(false), self.reflected_origin())
    }

    /// The same where they start on the true surface.
    pub(crate) fn unlifted(self) -> Self {
        Self { smooth_position: self.position, ..self }
    }

    /// The origin of a ray that was scattered diffusely to the side that `wo` is on.
    pub fn reflected_origin(&self) -> Vec3 {
        offset_origin(self.smooth_position, self.normal, self.wo)
    }

    /// The origin of a ray that starts on the true surface, on the side of `wo` or beyond it.
    pub fn surface_origin(&self, beyond: bool) -> Vec3 {
        offset_origin(self.position, self.normal, if beyond { -self.wo } else { self.wo })
    }

    /// What lights shine on here: the side of `wo`. On a clear surface light may arrive on either
    /// side: it is seen from the surface itself.
    pub(crate) fn shading_point(&self, bsdf: &Bsdf) -> ShadingPoint {
        if bsdf.is_translucent() || bsdf.is_delta() {
            return ShadingPoint::open(self.position);
        }
        let normal = self.shading.z;
        let normal = if self.wo_local().z > 0.0 { normal } else { -normal };
        ShadingPoint { position: self.reflected_origin(), normal }
    }

    /// The ray that leaves along a direction that `bsdf` sampled. `crossed` tells whether it goes
    /// on beyond the surface. Mirror images, and whatever clear surfaces scatter, start on the true
    /// surface: lifted off it, the inside of glass would be lost where normals lean much.
    pub fn scattered_ray(&self, bsdf: &Bsdf, sample: &BsdfSample, crossed: bool) -> Ray {
        let origin = if crossed || sample.delta || bsdf.is_translucent() {
            self.surface_origin(crossed)
        } else {
            self.reflected_origin()
        };
        Ray::new(origin, self.shading.to_world(sample.wi).normalize())
    }
}

/// The shading normal, bent no more than needed for the mirror image of `wo` to stay above the
/// true surface. Both normals point to the side of `wo`.
///
/// Source: Keller et al., "The Iray Light Transport Simulation and Rendering System", 2017,
/// section A.3.
fn consistent_normal(shading: Vec3, normal: Vec3, wo: Vec3) -> Vec3 {
    /// How far above the surface a bent mirror image stays, as a sine.
    const ABOVE: f32 = 1e-3;
    let mirrored = 2.0 * shading.dot(wo) * shading - wo;
    let height = mirrored.dot(normal);
    if height >= ABOVE && shading.dot(wo) > 0.0 {
        return shading;
    }
    let raised = (mirrored + (ABOVE - height).max(0.0) * normal).normalize_or(normal);
    let bent = (wo + raised).normalize_or(normal);
    if bent.dot(wo) > 0.0 && bent.dot(normal) > 0.0 { bent } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// However far an interpolated normal leans, the surface is seen from its front and mirrors
    /// light from above itself: no black rims, no light through the back.
    #[test]
    fn bent_normals_keep_both_directions_above_the_surface() {
        for i in 0..10_000 {
            let turn = |k: u32| {
                let word = (i as u32 + 1)
                    .wrapping_mul(0x9e37_79b9)
                    .rotate_left(k)
                    .wrapping_mul(0x85eb_ca6b);
                (word >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
            };
            let normal = Vec3::Z;
            let wo = Vec3::new(turn(1), turn(5), turn(9).abs() + 1e-4).normalize();
            let shading = Vec3::new(turn(13), turn(17), turn(21).abs()).normalize();
            let bent = consistent_normal(shading, normal, wo);
            assert!((bent.length() - 1.0).abs() < 1e-5);
            assert!(bent.dot(wo) > 0.0, "{wo} {shading} {bent}");
            let mirrored = 2.0 * bent.dot(wo) * bent - wo;
            assert!(mirrored.z > -1e-6, "{wo} {shading} {bent} {mirrored}");
        }
    }
}
