//! Every mistake gets one sentence that leads to its place.

mod common;

use common::{HEAD, parse};

/// A scene's text after [`HEAD`], and what is said about it.
const MISTAKES: &[(&str, &str)] = &[
    // Syntax.
    ("[render", ""),
    ("[[material]]\nname = \"a\"\ntype = matte", ""),
    ("[[shape]]\nfile = \"meshes\\dragon.obj\"", ""),
    ("[render]\nspp = 1\nspp = 2", ""),
    ("[render]\nspp = 1\n[render]", ""),
    ("[render]\nspp = 00", ""),
    ("[render]\nsize = [1, 2", ""),
    ("\0", ""),
    // Keys.
    ("[render]\nssp = 4", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nrougness = 1", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nalbdo = 1", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nior = 1.5", ""),
    ("[[material]]\nnme = \"a\"\ntype = \"matte\"", ""),
    ("[[material]]\nname = \"a\"\n", ""),
    ("[render]\nposition = [0, 0, 1]\nspp = 2", ""),
    ("[render]\nversion = 1", ""),
    ("[sky]\ncolor = 1", ""),
    ("[environmnt]\ncolor = 1", ""),
    ("[render]\n\"a\\u0007\\nb\" = 1", ""),
    // Types.
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = true", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = \"red\"", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = [1, 1]", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = [1, \"1\", 1]", ""),
    ("[[material]]\nname = 5\ntype = \"matte\"", ""),
    ("[render]\nspp = 64.0", ""),
    ("[render]\nspp = -1", ""),
    ("[render]\nmax_depth = 5000000000", ""),
    ("[render]\nsize = 800", ""),
    ("[render]\nsize = [800, 600.5]", ""),
    ("[render]\nexposure = 1979-05-27", ""),
    ("[shape]\ntype = \"sphere\"", ""),
    ("[[render]]\nspp = 1", ""),
    ("[[environment]]\ncolor = 1", ""),
    // Names.
    ("[render]\nintegrator = \"pth\"", ""),
    ("[render]\nintegrator = \"photon mapping\"", ""),
    ("[[light]]\ntype = \"pint\"", ""),
    ("[[shape]]\ntype = \"sphere\"\nradius = 1\nmaterial = \"gray\"", ""),
    ("[[shape]]\ntype = \"sphere\"\nradius = 1", ""),
    (
        "[[material]]\nname = \"grey\"\ntype = \"black\"\n[[material]]\nname = \"grey\"\ntype = \"black\"",
        "",
    ),
    ("[[material]]\nname = \"m\"\ntype = \"mix\"\nfirst = \"m\"\nsecond = \"m\"", ""),
    ("[[material]]\nname = \"m\"\ntype = \"mix\"\nfirst = \"n\"\nsecond = \"o\"", ""),
    // Ranges.
    ("[render]\nspp = 0", ""),
    ("[render]\nsize = [0, 600]", ""),
    ("[render]\nsize = [8, 6]\ncrop = [4, 0, 5, 1]", ""),
    ("[render]\nfilter_radius = 99", ""),
    ("[render]\nroulette = \"off\"", ""),
    ("[render]\nfilter = \"box\"\nfilter_sigma = 1", ""),
    ("[render]\nexposure = inf", ""),
    ("[render]\nexposure = 1e999", ""),
    ("[render]\nexposure = 1e39", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = [0.5, 1.5, 0]", ""),
    ("[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = nan", ""),
    ("[[material]]\nname = \"a\"\ntype = \"dielectric\"\nior = 0.9", ""),
    ("[[material]]\nname = \"a\"\ntype = \"dielectric\"\nabsorption_color = 0", ""),
    ("[[material]]\nname = \"a\"\ntype = \"dielectric\"\nabsorption_distance = 1", ""),
    ("[[material]]\nname = \"a\"\ntype = \"dielectric\"\nsigma_a = 1\nabsorption_color = 1", ""),
    ("[[material]]\nname = \"a\"\ntype = \"black\"\nemission = { radiance = -1 }", ""),
    ("[[material]]\nname = \"a\"\ntype = \"emissive\"", ""),
    ("[[material]]\nname = \"a\"\ntype = \"emissive\"\npower = 1\nradiance = 1", ""),
    ("[environment]", ""),
    ("[environment]\ncolor = 1\nscale = -1", ""),
    ("[environment]\ncolor = 1\nimage = \"sky.hdr\"", ""),
    // Shapes.
    ("[[shape]]\ntype = \"sphere\"\nradius = 0\nmaterial = \"grey\"", ""),
    ("[[shape]]\ntype = \"sphere\"\nradius = 1\nscale = [1, 2, 1]\nmaterial = \"grey\"", ""),
    ("[[shape]]\ntype = \"disk\"\nradius = 1\nscale = 0\nmaterial = \"grey\"", ""),
    ("[[shape]]\ntype = \"disk\"\nradius = 1\nscale = 1\nmatrix = [1]\nmaterial = \"grey\"", ""),
    ("[[shape]]\ntype = \"disk\"\nradius = 1\nmatrix = [1]\nmaterial = \"grey\"", ""),
    ("[[shape]]\ntype = \"disk\"\nradius = 1\nmatrix = [[1, 2]]\nmaterial = \"grey\"", ""),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2]\nmaterial = \"grey\"",
        "",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nrotate = { axis = [0, 0, 0], degrees = 5 }\nmaterial = \"grey\"",
        "",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nrotate = { axs = [0, 1, 0], degrees = 5 }\nmaterial = \"grey\"",
        "",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\ncenter = [0, 0, 0]\ntranslate = [0, 0, 1]\nmaterial = \"grey\"",
        "",
    ),
    ("[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"", ""),
    ("[[shape]]\ntype = \"mesh\"\nfile = \"none.obj\"\nmaterial = \"grey\"", ""),
    ("[[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\ntriangles = []\nmaterial = \"grey\"", ""),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 1]]\nmaterial = \"grey\"",
        "",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\nnormals = []\ntriangles = [[0, 0]]\nmaterial = \"grey\"",
        "",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0]]\nnormals = [[0, 0, 1]]\ntriangles = [[0, 0, 1]]\nmaterial = \"grey\"",
        "",
    ),
    ("[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 0]]", ""),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 0]]\nsmooth_degrees = 181\nmaterial = \"grey\"",
        "",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 0]]\nfit = { size = 1 }\nmaterial = \"grey\"",
        "",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = []\ntriangles = []\nfit = { size = 1 }\nmaterial = \"grey\"",
        "",
    ),
    ("[[light]]\ntype = \"directional\"\ndirection = [0, 0, 0]\nirradiance = 1", ""),
    ("[[light]]\ntype = \"point\"\nposition = [0, 0, 0]", ""),
];

/// The camera is in [`HEAD`]; these are scenes of their own.
const WHOLE_SCENES: &[(&str, &str)] = &[
    ("", ""),
    ("version = 1\nmaterial = 5", ""),
    ("version = 1\nmaterial = [5]", ""),
    ("version = 1\n[[material]]\nname = \"a\"\ntype = \"black\"\nemission = 5", ""),
    ("verson = 1", ""),
    ("version = 2\nwhatever = 5", ""),
    ("version = \"1\"", ""),
    ("version = 1", ""),
    ("version = 1\n[camera]\nlook_at = [0, 0, 0]", ""),
    ("version = 1\n[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 0]", ""),
    ("version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nup = [0, 0, 0]", ""),
    ("version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfov_degrees = 180", ""),
    ("version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nf_number = 0", ""),
    ("version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_at = [0, 0, 2]", ""),
    ("version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_distance = -1", ""),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_distance = 1\nfocus_at = [0, 0, 0]",
        "",
    ),
    ("version = 1\n[camera]\nposition = [0, 0, 1e38]\nlook_at = [0, 0, -3e38]", ""),
];

#[test]
fn mistakes_are_explained() {
    for (text, _) in MISTAKES {
        println!(
            "\x01{text}\n=> {}\n",
            parse(&format!("{HEAD}{text}"))
                .map(|_| ())
                .map_or_else(|e| e.to_string(), |()| "\x02FINE".into())
        );
    }
    for (text, _) in WHOLE_SCENES {
        println!(
            "\x01{text}\n=> {}\n",
            parse(text).map(|_| ()).map_or_else(|e| e.to_string(), |()| "\x02FINE".into())
        );
    }
}
