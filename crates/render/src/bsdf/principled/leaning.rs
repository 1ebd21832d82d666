//! Layers whose normals part.

use rutilant_geom::{Frame, Vec3};

/// How layers lean to one another, in the frame of all but the coat.
#[derive(Clone, Copy)]
pub(super) struct Leaning {
    /// The frame of the coat, where that is one of its own.
    pub(super) coat: Option<Frame>,
    /// The normal of the surface on the side of `wo`, where layers have others.
    pub(super) up: Option<Vec3>,
    /// In front of all layers.
    pub(super) outside: bool,
}

impl Leaning {
    /// Whether light between these directions goes through the surface.
    pub(super) fn crosses(&self, wo: Vec3, wi: Vec3) -> bool {
        self.up.map_or(wo.z * wi.z, |up| up.dot(wi)) < 0.0
    }

    /// Whether the surface is seen along `wo`, but all layers below the coat turn away.
    pub(super) fn turns_away(&self, wo: Vec3) -> bool {
        self.outside != (wo.z > 0.0)
    }

    /// The mirror image of a direction in the surface, where layers lean: what they send to the wrong
    /// side of it meets other bumps, and comes back.
    pub(super) fn folded(&self, w: Vec3) -> Option<Vec3> {
        self.up.map(|up| w - 2.0 * up.dot(w) * up)
    }

    /// A direction into which layers send what leaves along `wo`, `through` the surface or not, if
    /// need be folded onto that side.
    pub(super) fn onto_side(&self, wo: Vec3, wi: Vec3, through: bool) -> Vec3 {
        self.folded(wi).filter(|_| self.crosses(wo, wi) != through).unwrap_or(wi)
    }

    /// The cosine under which the coat sees `w`.
    pub(super) fn cos_of_coat(&self, w: Vec3) -> f32 {
        self.coat.map_or(w.z.abs(), |frame| frame.z.dot(w).abs().min(1.0))
    }
}
