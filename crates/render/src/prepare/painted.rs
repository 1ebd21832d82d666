//! Surfaces whose normals a picture tells, or whose light pictures and vertices do.

use super::prepared::{Prepared, PreparedObject, Vertex, interpolated};
use super::texture::TexturePlace;
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::{Bumps, NormalMap};
use rutilant_geom::{Hit, Vec3};

impl Prepared {
    /// A point of a surface that is painted: `flat` is it without the paint.
    #[inline(never)]
    pub(super) fn painted(
        &self,
        hit: &Hit,
        object: &PreparedObject,
        mut flat: SurfaceInteraction,
    ) -> SurfaceInteraction {
        flat.glow = self.glow_at(hit).unwrap_or(Spectrum::WHITE);
        let material = &self.materials[object.material as usize];
        let Some(vertices) = self.vertices(hit, object) else { return flat };
        if material.normal_map.is_none() && object.first_normal.is_none() {
            return flat;
        }
        let corners = self.corners(hit, object, &vertices);
        let normal = interpolated(&corners);
        // Where the coat has another normal than what is below it, both lean to the interpolated one.
        match material.normal_map.filter(|_| !material.own_coat) {
            None => flat.smoothed(normal, corners),
            Some(map) => flat.smoothed(self.bumped(hit, object, &vertices, normal, map), corners),
        }
    }

    /// The interpolated `normal`, of any length, turned as a picture says: on the front of the surface,
    /// of any length.
    fn bumped(
        &self,
        hit: &Hit,
        object: &PreparedObject,
        vertices: &[Vertex; 3],
        normal: Vec3,
        map: NormalMap,
    ) -> Vec3 {
        let normal = normal.normalize_or(hit.normal);
        let normal = if normal.dot(hit.normal) < 0.0 { -normal } else { normal };
        let mapped = match map.shows {
            Bumps::Normals => self.mapped(hit, object, vertices, normal, map),
            Bumps::Heights => self.raised(hit, object, vertices, normal, map),
        };
        // One that points into the surface is none.
        if mapped.dot(hit.normal) > 0.0 { mapped } else { normal }
    }

    /// The normal of a layer in the shading frame of `at`, on the front: the interpolated one, turned
    /// as the layer's own picture says, if it has one.
    pub(super) fn layer_normal(
        &self,
        map: Option<NormalMap>,
        hit: &Hit,
        at: &SurfaceInteraction,
    ) -> Vec3 {
        let object = self.object(hit);
        let (Some(map), Some(vertices)) = (map, self.vertices(hit, object)) else {
            return Vec3::Z;
        };
        let normal = match object.first_normal {
            None => hit.normal,
            Some(_) => interpolated(&self.corners(hit, object, &vertices)),
        };
        at.bent(self.bumped(hit, object, &vertices, normal, map))
    }

    /// What pictures and the colours of vertices make of the light that a surface gives at a place, if
    /// they do that.
    pub(crate) fn glow_at(&self, hit: &Hit) -> Option<Spectrum> {
        let object = self.object(hit);
        let by = self.materials[object.material as usize].glow?;
        let place = TexturePlace::new(self, object, hit);
        Some(self.textures.color(&by, &place).map(|c| c.max(0.0)))
    }

    /// The unit vector `normal`, turned as the picture says; of any length.
    fn mapped(
        &self,
        hit: &Hit,
        object: &PreparedObject,
        vertices: &[Vertex; 3],
        normal: Vec3,
        NormalMap { texture, scale, shows: _ }: NormalMap,
    ) -> Vec3 {
        let set = self.textures.set(texture);
        let directions = self.tangents(hit, object, vertices, normal, set);
        let Some((u, v)) = directions else { return normal };
        let place = TexturePlace::new(self, object, hit);
        let [x, y, z] = {
            let [r, g, b, _] = self.textures.rgba(texture, &place);
            [r, g, b].map(|c| 2.0 * c - 1.0)
        };
        u * (x * scale) + v * (y * scale) + normal * z
    }

    /// The unit vector `normal` of a surface that is raised by the heights of a picture; of any length.
    ///
    /// Source: Mikkelsen, *Bump Mapping Unparametrized Surfaces on the GPU*, Journal of Graphics, GPU
    /// and Game Tools 15 (2010), equation 4: the normal less the slope along the surface.
    fn raised(
        &self,
        hit: &Hit,
        object: &PreparedObject,
        vertices: &[Vertex; 3],
        normal: Vec3,
        NormalMap { texture, scale, shows: _ }: NormalMap,
    ) -> Vec3 {
        let place = TexturePlace::new(self, object, hit);
        let slope = scale * self.textures.slope(texture, &place);
        // Where u and v grow, in metres for each unit: u runs along the edges p and q of the triangle
        // as its texture coordinates say.
        let [s, t, r] = self.uvs_of(object, vertices, self.textures.set(texture));
        let [a, b, c] = vertices.map(|vertex| vertex.position);
        let (p, q) = (t - s, r - s);
        let area = p.perp_dot(q);
        let along_u = ((b - a) * q.y - (c - a) * p.y) / area;
        let along_v = ((c - a) * p.x - (b - a) * q.x) / area;
        // Its length is the area of a unit of u times v, seen along the normal.
        let facing = along_u.cross(along_v).dot(normal);
        let across = along_v.cross(normal) * slope.x + normal.cross(along_u) * slope.y;
        let raised = normal * facing.abs() - across * facing.signum();
        if raised.is_finite() { raised } else { normal }
    }

    /// Where u and v grow, as unit vectors at right angles to the normal and each other; `None` where
    /// the surface has no texture coordinates, or they are the same everywhere.
    pub(super) fn directions(
        &self,
        hit: &Hit,
        object: &PreparedObject,
        normal: Vec3,
    ) -> Option<(Vec3, Vec3)> {
        if let Some(vertices) = self.vertices(hit, object) {
            let told = object.first_uv.is_some() || object.first_tangent.is_some();
            return self.tangents(hit, object, &vertices, normal, 0).filter(|_| told);
        }
        let number = hit.primitive as usize - self.surfaces.triangles().len();
        let spheres = self.surfaces.spheres().len();
        let along = match self.surfaces.disks().get(number.wrapping_sub(spheres)) {
            Some(disk) => disk.u,
            // East of a sphere.
            None if number < spheres => {
                object.axes.as_ref().map_or(Vec3::Y, |axes| axes[1]).cross(normal)
            }
            None => return None,
        };
        let u = (along - normal * normal.dot(along)).try_normalize()?;
        Some((u, normal.cross(u)))
    }

    /// Where u and v grow on a triangle, as unit vectors at right angles to the normal and each other:
    /// by its tangents, or else by this `set` of its texture coordinates. `None` where that is nowhere.
    fn tangents(
        &self,
        hit: &Hit,
        object: &PreparedObject,
        vertices: &[Vertex; 3],
        normal: Vec3,
        set: u32,
    ) -> Option<(Vec3, Vec3)> {
        let weights = hit.weights();
        let (along, hand) = match object.first_tangent {
            Some(first) => {
                let all = [0, 1, 2].map(|i| self.tangent_at(hit, first + vertices[i].number));
                let sum = (0..3).fold(Vec3::ZERO, |sum, i| sum + all[i].0 * weights[i]);
                (sum, all[0].1)
            }
            None => {
                let [s, t, r] = self.uvs_of(object, vertices, set);
                let [a, b, c] = vertices.map(|vertex| vertex.position);
                let (p, q) = (t - s, r - s);
                let area = p.perp_dot(q);
                let along = ((b - a) * q.y - (c - a) * p.y) * area.signum();
                // The triangle's own front is where its picture runs counter-clockwise, or not.
                let front = (b - a).cross(c - a).dot(normal);
                (along, area.signum() * front.signum())
            }
        };
        let u = (along - normal * normal.dot(along)).try_normalize()?;
        Some((u, normal.cross(u) * hand))
    }

    /// Tangent number `i` in the world, and its hand, of the object that was hit.
    fn tangent_at(&self, hit: &Hit, i: u32) -> (Vec3, f32) {
        let [x, y, z, hand] = self.tangents[i as usize];
        let tangent = Vec3::new(x, y, z);
        match hit.instance {
            None => (tangent, hand),
            Some(instance) => {
                let placed = &self.surfaces.instances()[instance as usize].world_from_mesh;
                let hand = if placed.mirrors() { -hand } else { hand };
                (placed.vector(tangent).normalize_or_zero(), hand)
            }
        }
    }
}
