//! Textures as they are looked up.

use super::prepared::{Prepared, PreparedObject, Vertex};
use crate::bsdf::PrincipledParameters;
use crate::camera::PreparedCamera;
use crate::color::{Rgb, Spectrum};
use crate::material::Principled;
use crate::problem::{MOST_LIGHT, Note, Place};
use crate::scene::{Scene, TextureId};
use crate::texture::{
    Bitmap, Bricks, Channel, Checker, ColorInput, Encoding, Footprint, ImageTexture, Noise,
    PreparedMapping, Pyramid, ScalarInput, Texels, Texture,
};
use rayon::prelude::*;
use rutilant_geom::{Hit, Ray, Vec2, Vec3};
use std::collections::{HashMap, HashSet};
use std::f32::consts::PI;
use std::sync::Arc;

/// A texture to be looked at.
#[derive(Clone, Debug)]
pub(super) enum PreparedTexture {
    Image {
        pyramid: Arc<Pyramid>,
        image: ImageTexture,
        mapping: PreparedMapping,
    },
    /// Two colours, and what says how much of the second there is.
    Pattern {
        colors: [Rgb; 2],
        pattern: Pattern,
        mapping: PreparedMapping,
    },
}

/// What mixes two colours.
#[derive(Clone, Copy, Debug)]
pub(super) enum Pattern {
    Checker(Checker),
    Bricks(Bricks),
    Noise(Noise),
}

/// All textures of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct PreparedTextures {
    textures: Vec<PreparedTexture>,
    /// The pictures that they show, for the next time the scene is prepared.
    pyramids: Vec<Shown>,
}

/// A bitmap of the scene as a texture shows it.
#[derive(Clone, Debug)]
struct Shown {
    bitmap: Arc<Bitmap>,
    encoding: Encoding,
    pyramid: Arc<Pyramid>,
    /// Floating-point values that were no numbers, or too large.
    mended: usize,
}

impl PreparedTextures {
    /// Makes the smaller versions of all pictures, but for those that there were `before`.
    pub(super) fn new(scene: &Scene, before: Option<&Self>, notes: &mut Vec<Note>) -> Self {
        let mut wanted: Vec<(usize, Encoding)> = Vec::new();
        let mut places: HashMap<(usize, Encoding), usize> = HashMap::new();
        for texture in &scene.textures {
            match texture {
                Texture::Image(image) => {
                    let one = (image.bitmap.0 as usize, image.encoding);
                    places.entry(one).or_insert_with(|| {
                        wanted.push(one);
                        wanted.len() - 1
                    });
                }
                Texture::Checker(_) | Texture::Bricks(_) | Texture::Noise(_) => {}
            }
        }
        // As long as both are there, no two bitmaps stand at one address.
        let key = |bitmap: &Arc<Bitmap>, encoding| (Arc::as_ptr(bitmap).addr(), encoding);
        let known = before.map_or(&[][..], |before| &before.pyramids);
        let known: HashMap<_, &Shown> =
            known.iter().map(|shown| (key(&shown.bitmap, shown.encoding), shown)).collect();
        let show = |&(bitmap, encoding): &(usize, Encoding)| {
            let bitmap = &scene.bitmaps[bitmap];
            let same = known.get(&key(bitmap, encoding)).copied().cloned();
            same.unwrap_or_else(|| Shown::new(bitmap, encoding))
        };
        let pyramids: Vec<Shown> = wanted.par_iter().map(show).collect();
        // Of a picture that several textures show, the first tells.
        let mut told: HashSet<u32> = HashSet::new();
        let prepare = |(i, texture): (usize, &Texture)| match texture {
            Texture::Image(image) => {
                let one = (image.bitmap.0 as usize, image.encoding);
                let Shown { pyramid, mended, .. } = &pyramids[places[&one]];
                if *mended > 0 && told.insert(image.bitmap.0) {
                    notes.push(Place::Texture(i).note(format!(
                        "{mended} of its values, above 1e18 or no numbers, count as 0"
                    )));
                }
                PreparedTexture::Image {
                    pyramid: Arc::clone(pyramid),
                    image: *image,
                    mapping: image.mapping.prepare(),
                }
            }
            Texture::Checker(checker) => PreparedTexture::Pattern {
                colors: [checker.first, checker.second],
                pattern: Pattern::Checker(*checker),
                mapping: checker.mapping.prepare(),
            },
            Texture::Bricks(bricks) => PreparedTexture::Pattern {
                colors: [bricks.first, bricks.second],
                pattern: Pattern::Bricks(*bricks),
                mapping: bricks.mapping.prepare(),
            },
            Texture::Noise(noise) => PreparedTexture::Pattern {
                colors: [noise.first, noise.second],
                pattern: Pattern::Noise(*noise),
                mapping: noise.mapping.prepare(),
            },
        };
        let textures = scene.textures.iter().enumerate().map(prepare).collect();
        Self { textures, pyramids }
    }

    /// Bytes that pictures take, with all their smaller versions.
    pub(super) fn bytes(&self) -> u64 {
        self.pyramids.iter().map(|shown| shown.pyramid.bytes()).sum()
    }

    /// A colour as it is in the mean, 0 to 1: for decisions that are made once.
    pub(super) fn mean_reflectance(&self, input: &ColorInput) -> Spectrum {
        reflectance(self.mean_color(input))
    }

    /// A colour as it is in the mean.
    fn mean_color(&self, input: &ColorInput) -> Spectrum {
        let mean = input.texture.map_or([1.0; 4], |id| self.textures[id.0 as usize].mean());
        Spectrum::from(input.factor) * opaque(mean)
    }

    /// A principled surface as it is in the mean.
    pub(super) fn mean_principled(&self, principled: &Principled) -> PrincipledParameters {
        let color = |factor, texture, vertex_colors| {
            self.mean_color(&ColorInput { factor, texture, vertex_colors })
        };
        let scalar = |factor: f32, texture: Option<(TextureId, Channel)>| {
            let mean = |(id, channel): (TextureId, Channel)| {
                channel.of(self.textures[id.0 as usize].mean())
            };
            factor * texture.map_or(1.0, mean)
        };
        principled.varied(color, scalar)
    }

    /// How much the red of a texture grows at a place for each unit of the surface's texture
    /// coordinates, over as much as a pixel shows.
    pub(super) fn slope(&self, id: TextureId, at: &TexturePlace<'_>) -> Vec2 {
        let texture = &self.textures[id.0 as usize];
        let (_, width) = at.uv(texture.mapping().set);
        let half = 0.5 * width.max(texture.finest());
        let red = |x: f32, y: f32| {
            let moved = TexturePlace { moved: half * Vec2::new(x, y), ..*at };
            texture.rgba(&moved)[0]
        };
        let slope = Vec2::new(red(1.0, 0.0) - red(-1.0, 0.0), red(0.0, 1.0) - red(0.0, -1.0));
        let slope = slope / (2.0 * half);
        if slope.is_finite() { slope } else { Vec2::ZERO }
    }

    /// The set of texture coordinates that a texture lies on.
    pub(super) fn set(&self, id: TextureId) -> u32 {
        self.textures[id.0 as usize].mapping().set
    }

    /// Red, green, blue and opacity of a texture at a place.
    pub(super) fn rgba(&self, id: TextureId, at: &TexturePlace<'_>) -> [f32; 4] {
        self.textures[id.0 as usize].rgba(at)
    }

    /// What a colour at a place is made of.
    #[inline]
    pub(super) fn seek(&self, input: &ColorInput, at: &TexturePlace<'_>) -> SoughtColor<'_> {
        let factor = Spectrum::from(input.factor);
        let white = Sought::Known([1.0; 4]);
        SoughtColor {
            factor: match input.vertex_colors {
                true => factor * opaque(at.vertex_color()),
                false => factor,
            },
            texture: input.texture.map_or(white, |id| self.textures[id.0 as usize].seek(at)),
        }
    }

    /// The part of the light that is sent back at a place, 0 to 1, whatever the pictures hold.
    #[inline]
    pub(super) fn reflectance(&self, input: &ColorInput, at: &TexturePlace<'_>) -> Spectrum {
        self.seek(input, at).reflectance()
    }

    /// A colour at a place.
    #[inline]
    pub(super) fn color(&self, input: &ColorInput, at: &TexturePlace<'_>) -> Spectrum {
        self.seek(input, at).color()
    }

    /// A number at a place.
    pub(super) fn scalar(&self, input: &ScalarInput, at: &TexturePlace<'_>) -> f32 {
        let varied = input
            .texture
            .map_or(1.0, |(id, channel)| channel.of(self.textures[id.0 as usize].rgba(at)));
        input.factor * varied
    }
}

/// What a texture shows at a place: found, but not read yet if it is a picture.
#[derive(Clone, Copy, Debug)]
enum Sought<'p> {
    Texels(Footprint<'p>),
    Known([f32; 4]),
}

/// A colour at a place, whose texels are found and not read yet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoughtColor<'p> {
    factor: Spectrum,
    texture: Sought<'p>,
}

impl Sought<'_> {
    #[inline]
    fn read(&self) -> [f32; 4] {
        match self {
            Self::Texels(footprint) => footprint.read(),
            Self::Known(rgba) => *rgba,
        }
    }
}

impl SoughtColor<'_> {
    /// The part of the light that is sent back, 0 to 1, whatever the pictures hold.
    #[inline]
    pub(crate) fn reflectance(&self) -> Spectrum {
        reflectance(self.color())
    }

    #[inline]
    fn color(&self) -> Spectrum {
        self.factor * opaque(self.texture.read())
    }
}

/// Without its opacity.
fn opaque([r, g, b, _]: [f32; 4]) -> Spectrum {
    [r, g, b].into()
}

fn reflectance(color: Spectrum) -> Spectrum {
    color.map(|c| c.clamp(0.0, 1.0))
}

impl Shown {
    fn new(bitmap: &Arc<Bitmap>, encoding: Encoding) -> Self {
        let (mended, base) = mended(bitmap);
        let pyramid = Arc::new(Pyramid::new(base, encoding));
        Self { bitmap: Arc::clone(bitmap), encoding, pyramid, mended }
    }
}

/// The bitmap with 0 for what is no number, or one beyond all light, and how often that was.
fn mended(bitmap: &Arc<Bitmap>) -> (usize, Arc<Bitmap>) {
    let Texels::Float(values) = bitmap.texels() else { return (0, Arc::clone(bitmap)) };
    // Between values that are larger, a mean would be none any more.
    let sound = |v: &&f32| v.abs() <= MOST_LIGHT;
    let broken = values.len() - values.iter().filter(sound).count();
    if broken == 0 {
        return (0, Arc::clone(bitmap));
    }
    let whole = values.iter().map(|v| if sound(&v) { *v } else { 0.0 }).collect();
    let [width, height] = [bitmap.width(), bitmap.height()];
    let mended = Bitmap::new(width, height, bitmap.channels(), Texels::Float(whole));
    (broken, mended.map_or_else(|| Arc::clone(bitmap), Arc::new))
}

impl PreparedTexture {
    fn mapping(&self) -> &PreparedMapping {
        match self {
            Self::Image { mapping, .. } | Self::Pattern { mapping, .. } => mapping,
        }
    }

    /// The smallest step of a surface's texture coordinates over which it is worth looking at.
    fn finest(&self) -> f32 {
        /// Of a unit of a pattern: single precision still tells its heights apart.
        const PATTERN: f32 = 1.0 / 256.0;
        let step = match self {
            Self::Image { pyramid, .. } => pyramid.texel(),
            Self::Pattern { .. } => PATTERN,
        };
        step / self.mapping().scale
    }

    /// Red, green, blue and opacity at a place.
    #[inline]
    fn rgba(&self, at: &TexturePlace<'_>) -> [f32; 4] {
        self.seek(at).read()
    }

    #[inline]
    fn seek(&self, at: &TexturePlace<'_>) -> Sought<'_> {
        let mapping = self.mapping();
        let (uv, width) = at.uv(mapping.set);
        let (uv, width) = (mapping.apply(uv), width * mapping.scale);
        match self {
            Self::Image { pyramid, image, .. } => {
                Sought::Texels(pyramid.find(uv, width, image.wrap, image.interpolation))
            }
            Self::Pattern { colors, pattern, .. } => Sought::Known(mixed(
                colors,
                match pattern {
                    Pattern::Checker(checker) => checker.amount(uv),
                    Pattern::Bricks(bricks) => bricks.amount(uv),
                    Pattern::Noise(noise) => noise.amount(uv, width),
                },
            )),
        }
    }

    fn mean(&self) -> [f32; 4] {
        match self {
            Self::Image { pyramid, .. } => pyramid.mean(),
            Self::Pattern { colors, pattern, .. } => mixed(
                colors,
                match pattern {
                    Pattern::Checker(_) | Pattern::Noise(_) => 0.5,
                    Pattern::Bricks(bricks) => bricks.mean_amount(),
                },
            ),
        }
    }
}

/// Opaque, with so much of the second colour.
fn mixed([first, second]: &[Rgb; 2], amount: f32) -> [f32; 4] {
    let [r, g, b] = std::array::from_fn(|i| first.0[i] * (1.0 - amount) + second.0[i] * amount);
    [r, g, b, 1.0]
}

/// How much of the scene a pixel shows, as far as textures need to know.
///
/// It is a cone around the straight line from the eye to a point, however a path came there: what a
/// texture shows at a point then is the same for every path, in whichever direction it runs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Eye {
    position: Vec3,
    /// The width in metres at the eye, and what is added for every metre.
    width: [f32; 2],
}

impl Eye {
    /// Of a camera along `axis`.
    pub(super) fn new(camera: &PreparedCamera, axis: &Ray) -> Self {
        /// Textures are looked at over so many pixels. Less than one, as samples do the rest:
        /// what is averaged beforehand is a square, and would blur what is seen at a slant.
        const SHARPNESS: f32 = 0.5;
        // What a pixel is wide at a distance of one and of two metres.
        let [one, two] = [1.0, 2.0].map(|distance| {
            let pixels = camera.pixels_per_area(axis.direction, distance);
            if pixels > 0.0 { SHARPNESS / pixels.sqrt() } else { 0.0 }
        });
        Self { position: axis.origin, width: [2.0 * one - two, two - one] }
    }

    /// The width of what a pixel shows at a point, in metres.
    fn width_at(&self, point: Vec3) -> f32 {
        let [start, growth] = self.width;
        start + growth * self.position.distance(point)
    }
}

/// A place on a surface where textures are looked at.
#[derive(Clone, Copy)]
pub(super) struct TexturePlace<'p> {
    scene: &'p Prepared,
    object: &'p PreparedObject,
    hit: &'p Hit,
    /// The width of what a pixel shows, in metres.
    width: f32,
    /// How far from there in texture coordinates.
    moved: Vec2,
}

impl<'p> TexturePlace<'p> {
    #[inline]
    pub(super) fn new(scene: &'p Prepared, object: &'p PreparedObject, hit: &'p Hit) -> Self {
        let width = scene.eye.width_at(hit.position);
        Self { scene, object, hit, width, moved: Vec2::ZERO }
    }

    /// Texture coordinates of a set, and how wide in them what a pixel shows is.
    #[inline]
    fn uv(&self, set: u32) -> (Vec2, f32) {
        let Self { scene, object, hit, width, moved } = self;
        let Some(vertices) = scene.vertices(hit, object) else {
            let per_metre = scene.uvs_per_metre(hit.primitive);
            return (scene.uv(hit) + *moved, width * per_metre);
        };
        let [a, b, c] = scene.uvs_of(object, &vertices, set);
        let [r, s, t] = hit.weights();
        let uv = a * r + b * s + c * t + *moved;
        let [p, q, r] = vertices.map(|vertex| vertex.position);
        let areas = ((b - a).perp_dot(c - a).abs(), (q - p).cross(r - p).length());
        (uv, width * (areas.0 / areas.1).sqrt())
    }

    /// The colour and opacity of the mesh's vertices, white where they have none.
    pub(super) fn vertex_color(&self) -> [f32; 4] {
        let Self { scene, object, hit, .. } = self;
        let (Some(first), Some(vertices)) = (object.first_color, scene.vertices(hit, object))
        else {
            return [1.0; 4];
        };
        let [a, b, c] = vertices.map(|vertex| scene.colors[(first + vertex.number) as usize]);
        let [r, s, t] = hit.weights();
        std::array::from_fn(|i| a[i] * r + b[i] * s + c[i] * t)
    }
}

impl Prepared {
    /// The texture coordinates of a triangle's vertices: those of the mesh, or, where it has none,
    /// so that they are barycentric weights.
    #[inline]
    pub(super) fn uvs_of(
        &self,
        object: &PreparedObject,
        vertices: &[Vertex; 3],
        set: u32,
    ) -> [Vec2; 3] {
        let Some(first) = object.first_uv else { return [Vec2::ZERO, Vec2::X, Vec2::Y] };
        let set = if set < object.uv_sets { set } else { 0 };
        let first = first + set * object.vertices;
        [0, 1, 2].map(|i| self.uvs[(first + vertices[i].number) as usize])
    }

    /// How much texture coordinates change over a metre, on what is no triangle.
    fn uvs_per_metre(&self, primitive: u32) -> f32 {
        let surfaces = &self.surfaces;
        let number = primitive as usize - surfaces.triangles().len();
        if let Some(sphere) = surfaces.spheres().get(number) {
            // At its equator; it is more at its poles.
            return 1.0 / (std::f32::consts::SQRT_2 * PI * sphere.radius);
        }
        let number = number - surfaces.spheres().len();
        match surfaces.disks().get(number) {
            Some(disk) => 0.5 / disk.u.cross(disk.v).length().sqrt(),
            // What others make is looked at as closely as can be.
            None => 0.0,
        }
    }
}
