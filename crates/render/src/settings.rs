//! How a scene is to be rendered: everything about the picture but what is in it.

pub use crate::film::{Crop, Layer, Layers};

use crate::film::Filter;
use crate::problem::{Place, SceneProblem};

/// The settings of one rendering. Together with the scene they decide every bit of the image.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height of the whole picture in pixels.
    pub size: [u32; 2],
    /// The part to render; all of it if `None`. Pixels come out the same either way.
    pub crop: Option<Crop>,
    /// Samples per pixel.
    pub spp: u64,
    /// With how many samples per pixel the noise of neighbouring pixels shall cancel best; with
    /// `spp` of them if `None`. A rendering that is continued keeps to what it was started with.
    pub planned_spp: Option<u64>,
    /// The longest path in segments: 1 is emission seen directly, 2 direct light. Unbounded if `None`.
    pub max_depth: Option<u32>,
    /// What is computed along each path.
    pub integrator: IntegratorKind,
    /// Where random numbers come from.
    pub sampler: SamplerKind,
    /// Another seed gives another, equally good picture.
    pub seed: u64,
    /// How samples weigh around a pixel's centre.
    pub filter: Filter,
    /// Which ways of finding light are used.
    pub strategy: Strategy,
    /// How those ways share what both can find.
    pub heuristic: Heuristic,
    /// When dim paths end.
    pub roulette: Roulette,
    /// How one light is chosen from many.
    pub light_selection: LightSelection,
    /// Whether paths that start at lamps help to find the light that glass and mirrors throw on
    /// other surfaces. The picture is the same in the end, with less noise.
    pub caustics: bool,
    /// What the picture has beside its light. The light is the same, to the bit.
    pub layers: Layers,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            size: [800, 600],
            crop: None,
            spp: 64,
            planned_spp: None,
            max_depth: None,
            integrator: IntegratorKind::Path,
            sampler: SamplerKind::Sobol,
            seed: 0,
            filter: Filter::default(),
            strategy: Strategy::Both,
            heuristic: Heuristic::Power,
            roulette: Roulette::Throughput,
            light_selection: LightSelection::Auto,
            caustics: true,
            layers: Layers::NONE,
        }
    }
}

/// What is computed for each camera ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum IntegratorKind {
    /// Path tracing: all light, over any number of bounces.
    Path,
    /// Path tracing that finds light only by chance: slow, simple, for comparison.
    Naive,
    /// Emission and direct light only.
    Direct,
    /// Ambient occlusion: the part of the sky that each point sees.
    AmbientOcclusion,
    /// Shading normals, from −1..1 mapped to 0..1.
    Normals,
    /// The part of white light that surfaces send back.
    Albedo,
    /// Distance from the camera in metres; 0 where nothing is.
    Depth,
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Every number drawn on its own.
    Independent,
    /// Owen-scrambled Sobol points: less noise from the same number of samples.
    Sobol,
}

/// Which ways of finding light a path tracer uses. All give the same picture in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Strategy {
    /// Both, combined by multiple importance sampling.
    Both,
    /// Only by choosing points on lights.
    LightOnly,
    /// Only by following scattered directions.
    BsdfOnly,
}

/// How two sampling strategies share the light that both can find (Veach 1997, section 9.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Heuristic {
    /// In proportion to their densities.
    Balance,
    /// In proportion to the squares of their densities.
    Power,
    /// In proportion to their densities, and each pixel learns from its samples what cancels most
    /// of the noise that is left (Kondapaneni et al. 2019). A pixel takes 96 bytes instead of 56.
    Optimal,
}

/// When paths end at random; survivors stand in for the ended, so the mean is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Roulette {
    /// Never: needs `max_depth`.
    Off,
    /// The 2017 report's: at each diffuse bounce a path survives with probability
    /// max(R, G, B, 0.1) of the albedo.
    Albedo,
    /// By what the path can still contribute; after 128 segments also by chance alone.
    Throughput,
}

/// How one light is chosen from many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightSelection {
    /// By a tree where there are more than a handful within the scene, else by power.
    Auto,
    /// Every light equally often, as in the 2017 report.
    Uniform,
    /// In proportion to the emitted power.
    Power,
    /// By what each may bring to the point that is lit: its power, its distance, and which way it
    /// and the surface face.
    Tree,
}

impl Settings {
    /// The largest picture side, in pixels.
    pub const MAX_SIDE: u32 = 65_536;

    /// The most pixels that are rendered at once: their sums take 7 GB, 5 GB more with optimal
    /// weights, and 6 GB more where light paths find caustics. Larger pictures are rendered in
    /// crops.
    pub const MAX_PIXELS: u64 = 1 << 27;

    /// The window that is rendered: the crop, or the whole picture.
    pub fn window(&self) -> Crop {
        let [width, height] = self.size;
        self.crop.unwrap_or(Crop { x: 0, y: 0, width, height })
    }

    /// True when samples come with a control for their noise, which pixels learn to use.
    pub(crate) fn learns(&self) -> bool {
        self.integrator == IntegratorKind::Path
            && self.strategy == Strategy::Both
            && self.heuristic == Heuristic::Optimal
    }

    /// The layers that can be kept: parts of light and its groups are known to the path tracer alone,
    /// and not where pixels learn to correct its samples.
    pub(crate) fn kept_layers(&self) -> Layers {
        if self.integrator == IntegratorKind::Path && !self.learns() {
            self.layers
        } else {
            self.layers.without(Layer::Light).without(Layer::Groups)
        }
    }

    /// True when light paths are to be traced wherever they find something.
    pub(crate) fn traces_light(&self) -> bool {
        self.caustics
            && self.integrator == IntegratorKind::Path
            && self.strategy == Strategy::Both
            && self.max_depth.is_none_or(|depth| depth > 2)
    }

    /// The first setting that cannot be used, if there is one.
    ///
    /// # Errors
    /// An empty or oversized picture, a crop that leaves it, no samples, a
    /// filter without width, or paths that would never end.
    pub fn validate(&self) -> Result<(), SceneProblem> {
        let place = Place::Settings;
        let [width, height] = self.size;
        if !(1..=Self::MAX_SIDE).contains(&width) || !(1..=Self::MAX_SIDE).contains(&height) {
            let most = Self::MAX_SIDE;
            return Err(place.problem(
                "size",
                format!("size is {width}x{height}, but each side must lie between 1 and {most}"),
            ));
        }
        if let Some(c) = self.crop {
            let inside = |first: u32, count: u32, all: u32| {
                count > 0 && u64::from(first) + u64::from(count) <= u64::from(all)
            };
            if !inside(c.x, c.width, width) || !inside(c.y, c.height, height) {
                let Crop { x, y, width: w, height: h } = c;
                return Err(place.problem(
                    "crop",
                    format!("crop {x},{y},{w},{h} must hold pixels and stay inside the {width}x{height} picture"),
                ));
            }
        }
        let window = self.window();
        let pixels = u64::from(window.width) * u64::from(window.height);
        if pixels > Self::MAX_PIXELS {
            let (key, most) = (if self.crop.is_some() { "crop" } else { "size" }, Self::MAX_PIXELS);
            return Err(place.problem(
                key,
                format!(
                    "{pixels} pixels are too many to render at once; at most {most} are, use crops"
                ),
            ));
        }
        if self.spp == 0 {
            return Err(place.problem("spp", "spp is 0, but must be 1 or more"));
        }
        if self.max_depth == Some(0) {
            return Err(place.problem("max_depth", "max_depth is 0, but must be 1 or more"));
        }
        if self.roulette == Roulette::Off && self.max_depth.is_none() {
            return Err(place.problem(
                "roulette",
                "roulette \"off\" needs a max_depth, or paths would never end",
            ));
        }
        self.filter.validate()
    }
}
