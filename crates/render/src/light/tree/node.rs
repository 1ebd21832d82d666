//! A node of the light tree: eight groups of emitters, and how much light each may bring.
//!
//! What a group may bring to a point is estimated from its bounds alone: intensity over squared
//! distance, times the cosine of the least angle at which it may shine there and of the least at
//! which the surface may see it. Where a cosine is 0 the group surely brings nothing.
//!
//! Source: Conty Estevez, Kulla, "Importance Sampling of Many Lights with Adaptive Tree
//! Splitting", HPG 2018, section 4.2; Pharr, Jakob, Humphreys, *Physically Based Rendering*,
//! 4th ed., section 12.6.3.

use rutilant_geom::Vec3;

/// Groups in a node. Eight are told apart with one look: a tree of pairs would look three times,
/// each time at coarser bounds.
pub(super) const WIDTH: usize = 8;

/// What stands behind a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// Nothing.
    None,
    /// The node of this number.
    Node(u32),
    /// The emitter of this number, alone.
    Emitter(u32),
}

impl Child {
    /// The highest bit tells emitters from nodes; all bits are set where there is nothing.
    const EMITTER: u32 = 1 << 31;

    fn packed(self) -> u32 {
        match self {
            Self::None => u32::MAX,
            Self::Node(number) => number,
            Self::Emitter(number) => number | Self::EMITTER,
        }
    }

    fn unpacked(word: u32) -> Self {
        match word {
            u32::MAX => Self::None,
            node if node & Self::EMITTER == 0 => Self::Node(node),
            emitter => Self::Emitter(emitter & !Self::EMITTER),
        }
    }
}

/// Bounds of a group, in the coordinates of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// The middle of its box.
    pub(super) center: Vec3,
    /// The square of half the box's diagonal.
    pub(super) radius2: f32,
    /// As in `EmitterBounds`, of all its emitters.
    pub(super) axis: Vec3,
    pub(super) cos_normals: f32,
    pub(super) cos_shines: f32,
    pub(super) two_sided: bool,
    /// The sum of their intensities, relative to the node's largest.
    pub(super) intensity: f32,
}

/// A point to be lit, in the coordinates of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seer {
    /// Where.
    pub(super) position: Vec3,
    /// The unit normal on the side that is lit; zero where light counts from everywhere.
    pub(super) normal: Vec3,
}

/// Eight groups. Arrays are by group, so that all are looked at together.
#[derive(Clone, Debug)]
pub(super) struct Node {
    center: [[f32; WIDTH]; 3],
    radius2: [f32; WIDTH],
    axis: [[f32; WIDTH]; 3],
    cos_normals: [f32; WIDTH],
    cos_shines: [f32; WIDTH],
    /// −1 where it shines along both directions of its axis, else 1.
    sides: [f32; WIDTH],
    intensity: [f32; WIDTH],
    children: [u32; WIDTH],
}

/// How much each group of a node may bring, and all of them together.
pub(super) struct Shares {
    pub(super) each: [f32; WIDTH],
    pub(super) total: f32,
}

impl Node {
    /// A node without groups.
    pub(super) const EMPTY: Self = Self {
        center: [[0.0; WIDTH]; 3],
        radius2: [0.0; WIDTH],
        axis: [[0.0; WIDTH], [0.0; WIDTH], [1.0; WIDTH]],
        cos_normals: [1.0; WIDTH],
        cos_shines: [0.0; WIDTH],
        sides: [1.0; WIDTH],
        intensity: [0.0; WIDTH],
        children: [u32::MAX; WIDTH],
    };

    pub(super) fn set(&mut self, i: usize, group: &Group) {
        for axis in 0..3 {
            self.center[axis][i] = group.center[axis];
            self.axis[axis][i] = group.axis[axis];
        }
        self.radius2[i] = group.radius2;
        self.cos_normals[i] = group.cos_normals;
        self.cos_shines[i] = group.cos_shines;
        self.sides[i] = if group.two_sided { -1.0 } else { 1.0 };
        self.intensity[i] = group.intensity;
    }

    pub(super) fn set_child(&mut self, i: usize, child: Child) {
        self.children[i] = child.packed();
    }

    #[inline]
    pub(super) fn child(&self, i: usize) -> Child {
        Child::unpacked(self.children[i])
    }

    /// How much of its light each group may bring to a point. All are 0 where none brings any.
    #[inline(always)]
    pub(super) fn shares(&self, seer: &Seer) -> Shares {
        let mut each = [0.0; WIDTH];
        for (i, share) in each.iter_mut().enumerate() {
            *share = self.share(i, seer);
        }
        let total = each.iter().sum::<f32>();
        if total < f32::INFINITY {
            return Shares { each, total };
        }
        // Where numbers end, all are as good as each other.
        let each = self.intensity.map(|intensity| if intensity > 0.0 { 1.0 } else { 0.0 });
        Shares { each, total: each.iter().sum() }
    }

    /// Of one group. Without branches, so that the compiler makes one look at all eight of it.
    #[inline(always)]
    fn share(&self, i: usize, seer: &Seer) -> f32 {
        let [px, py, pz] = seer.position.to_array();
        let [nx, ny, nz] = seer.normal.to_array();
        let (x, y, z) = (px - self.center[0][i], py - self.center[1][i], pz - self.center[2][i]);
        let distance2 = x * x + y * y + z * z;
        let radius2 = self.radius2[i];
        let per_length = 1.0 / distance2.max(SMALLEST).sqrt();

        // The angle that the ball around its box is seen under; all around from inside.
        let sin2_ball = radius2 / distance2.max(SMALLEST);
        let inside = sin2_ball >= 1.0;
        let sin_ball = sin2_ball.sqrt();
        let cos_ball = (1.0 - sin2_ball).max(0.0).sqrt();

        // The least angle at which it shines here, from a normal.
        let along = (self.axis[0][i] * x + self.axis[1][i] * y + self.axis[2][i] * z) * per_length;
        let cos_axis = along.max(along * self.sides[i]);
        let sin_axis = sine(cos_axis);
        let (cos_normals, sin_normals) = (self.cos_normals[i], sine(self.cos_normals[i]));
        let around = cos_axis >= cos_normals;
        let cos_off = cos_axis * cos_normals + sin_axis * sin_normals;
        let sin_off = sin_axis * cos_normals - cos_axis * sin_normals;
        let straight = around | inside | (cos_off >= cos_ball);
        let cos_leaves = if straight { 1.0 } else { cos_off * cos_ball + sin_off * sin_ball };
        let shines = cos_leaves > self.cos_shines[i];

        // The least angle at which the surface sees it.
        let cos_normal = -(nx * x + ny * y + nz * z) * per_length;
        let sin_normal = sine(cos_normal);
        let anywhere = nx == 0.0 && ny == 0.0 && nz == 0.0;
        let facing = anywhere | inside | (cos_normal >= cos_ball);
        let cos_arrives =
            if facing { 1.0 } else { (cos_normal * cos_ball + sin_normal * sin_ball).max(0.0) };

        // Nearer than its own size it does not get brighter.
        let distance2 = distance2.max(radius2 * NEAREST).max(SMALLEST);
        let light = self.intensity[i] / distance2 * cos_arrives;
        if shines { light * cos_leaves } else { 0.0 }
    }
}

/// Keeps divisions finite.
const SMALLEST: f32 = 1e-30;

/// The least squared distance that counts, in squared radii of a group's ball.
const NEAREST: f32 = 0.25;

/// The sine of an angle of 0 to π, of which this is the cosine.
#[inline(always)]
fn sine(cosine: f32) -> f32 {
    (1.0 - cosine * cosine).max(0.0).sqrt()
}
