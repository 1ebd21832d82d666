//! Every mistake gets one sentence that leads to its place.

use crate::{HEAD, parse};

/// A scene's text after [`HEAD`], and what is said about it.
const MISTAKES: &[(&str, &str)] = &[
    // Syntax.
    ("[render", "8:8: unclosed table, expected `]`"),
    (
        "[[material]]\nname = \"a\"\ntype = matte",
        "10:8: string values must be quoted, expected literal string",
    ),
    (
        "[[shape]]\nfile = \"meshes\\dragon.obj\"",
        r#"9:16: missing escaped value, expected `b`, `e`, `f`, `n`, `r`, `\`, `"`, `x`, `u`, `U`; in paths write / instead of \"#,
    ),
    ("[render]\nspp = 1\nspp = 2", "10:1: duplicate key"),
    ("[render]\nspp = 1\n[render]", "10:2: duplicate key"),
    ("[render]\nspp = 00", "9:7: unexpected leading zero"),
    ("[render]\nsize = [1, 2", "9:13: unclosed array, expected `]`"),
    ("\0", "8:2: key with no value, expected `=`; the line holds bytes that are no text"),
    // Instances.
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\n\
         instances = { translate = [1, 0, 0] }",
        "12:13: there can be several: write [[shape.instances]] with double brackets",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\n\
         instances = [{ translate = [1, 0, 0] }, { move = [1, 0, 0] }]",
        r#"12:43: no key "move" in [[shape.instances]]; there are translate, rotate_degrees, rotate, scale, matrix"#,
    ),
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 1\nmaterial = \"grey\"\n\
         [[shape.instances]]\nscale = 2\n[[shape.instances]]\nscale = [1, 2, 1]",
        "15:9: a sphere needs the same scale in all directions; use a mesh for an ellipsoid",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\ninstances = \"none.txt\"",
        r#"12:13: there is no file "none.txt" beside the scene"#,
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\ninstances = 3",
        "12:13: instances must be tables like [[shape.instances]], not the number 3",
    ),
    // Keys.
    ("[render]\nssp = 4", r#"9:1: no key "ssp"; did you mean "spp"?"#),
    ("[render]\nlayers = [\"albdo\"]", r#"9:11: no layer "albdo"; did you mean "albedo"?"#),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nrougness = 1",
        r#"11:1: no key "rougness"; did you mean "roughness"?"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nalbdo = 1",
        r#"11:1: no key "albdo"; did you mean "albedo"?"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nior = 1.5",
        r#"11:1: no key "ior" in a matte material, only in a dielectric or a thin dielectric or a principled material"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\npriority = 1",
        r#"11:1: no key "priority" in a matte material, only in a dielectric or a principled material"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\npriority = -1",
        "11:12: priority must be a whole number, 0 or more, not the number -1",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\npriority = 1.5",
        "11:12: priority must be a whole number, 0 or more, not the number 1.5",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\npriority = 4294967296",
        "11:12: priority is too large",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\npriority = 1\nemission = { radiance = 1 }",
        "12:12: a dielectric with a priority cannot glow: where it lies within another, its \
         surface is not there",
    ),
    ("[[material]]\nnme = \"a\"\ntype = \"matte\"", r#"9:1: no key "nme"; did you mean "name"?"#),
    ("[[material]]\nname = \"a\"\n", r#"8:1: [[material]] needs "type""#),
    (
        "[render]\nposition = [0, 0, 1]\nspp = 2",
        r#"9:1: no key "position" in [render], only in [camera] or a point light or a spot"#,
    ),
    (
        "[render]\nversion = 1",
        r#"9:1: no key "version" in [render], only in the scene itself, above all tables"#,
    ),
    (
        "[sky]\ncolor = 1",
        r#"8:2: no key "sky" in the scene; there are version, render, camera, environment, texture, material, shape, light"#,
    ),
    ("[environmnt]\ncolor = 1", r#"8:2: no key "environmnt"; did you mean "environment"?"#),
    (
        "[render]\n\"a\\u0007\\nb\" = 1",
        r#"9:1: no key "a\u{7}\nb" in [render]; there are size, crop, spp, max_depth, integrator, sampler, seed, filter, filter_radius, filter_sigma, filter_bc, strategy, heuristic, roulette, light_selection, caustics, layers, exposure, curve"#,
    ),
    // Light groups.
    (
        "[[light]]\ntype = \"point\"\nposition = [0, 1, 0]\nintensity = 1\ngroup = \"a.b\"",
        "12:9: the name of a light group has a '.', but takes letters and digits of ASCII, _ and - \
         only: channels of files are called by it",
    ),
    ("[environment]\ncolor = 1\ngroup = \"\"", "10:9: the name of a light group is empty"),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmaterial = \"grey\"\ngroup = \"rest\"",
        "12:9: no light group can be called \"rest\": that is what the lights without a group are \
         called",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"emissive\"\nradiance = 1\n\
         group = \"123456789012345678901\"",
        "12:9: the name of a light group has 21 characters, but must have at most 20: channels of \
         files are called by it",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nemission = { radiance = 1, group = 3 }",
        "11:36: group must be a text in quotes, not the number 3",
    ),
    // Types.
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = true",
        r##"11:10: albedo must be a color ([r, g, b], a number for grey, or "#rrggbb" in sRGB), not a boolean"##,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = \"red\"",
        r##"11:10: albedo must be a color ([r, g, b], a number for grey, or "#rrggbb" in sRGB), not the text "red""##,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = [1, 1]",
        r##"11:10: albedo must be a color ([r, g, b], a number for grey, or "#rrggbb" in sRGB), not an array with 2 entries"##,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = [1, \"1\", 1]",
        r##"11:14: albedo must be a color ([r, g, b], a number for grey, or "#rrggbb" in sRGB), not the text "1""##,
    ),
    (
        "[[material]]\nname = 5\ntype = \"matte\"",
        "9:8: name must be a text in quotes, not the number 5",
    ),
    ("[render]\nspp = 64.0", "9:7: spp must be a whole number, 0 or more, not the number 64.0"),
    ("[render]\nspp = -1", "9:7: spp must be a whole number, 0 or more, not the number -1"),
    ("[render]\nmax_depth = 5000000000", "9:13: max_depth is too large"),
    (
        "[render]\nsize = 800",
        "9:8: size must be two whole numbers [width, height], not the number 800",
    ),
    (
        "[render]\nsize = [800, 600.5]",
        "9:14: size must be two whole numbers [width, height], not the number 600.5",
    ),
    ("[render]\nexposure = 1979-05-27", "9:12: exposure must be a number, not a date"),
    (
        "[shape]\ntype = \"sphere\"",
        "8:1: there can be several: write [[shape]] with double brackets",
    ),
    ("[[render]]\nspp = 1", "8:1: there is only one [render]: write it with single brackets"),
    (
        "[[environment]]\ncolor = 1",
        "8:1: there is only one [environment]: write it with single brackets",
    ),
    // Names.
    ("[render]\nintegrator = \"pth\"", r#"9:14: no integrator "pth"; did you mean "path"?"#),
    (
        "[render]\nintegrator = \"photon mapping\"",
        r#"9:14: no integrator "photon mapping"; there are path, naive, direct, ao, normals, albedo, depth"#,
    ),
    ("[render]\ncurve = \"agxx\"", r#"9:9: no curve "agxx"; did you mean "agx"?"#),
    ("[[light]]\ntype = \"pint\"", r#"9:8: no light type "pint"; did you mean "point"?"#),
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 1\nmaterial = \"gray\"",
        r#"11:12: no material "gray"; did you mean "grey"?"#,
    ),
    ("[[shape]]\ntype = \"sphere\"\nradius = 1", r#"8:1: a sphere needs "material""#),
    (
        "[[material]]\nname = \"grey\"\ntype = \"black\"\n[[material]]\nname = \"grey\"\ntype = \"black\"",
        r#"9:8: there is another material "grey"; names must differ"#,
    ),
    (
        "[[material]]\nname = \"m\"\ntype = \"mix\"\nfirst = \"m\"\nsecond = \"m\"",
        "11:9: first is itself a mix; mix plain materials instead",
    ),
    (
        "[[material]]\nname = \"m\"\ntype = \"mix\"\nfirst = \"n\"\nsecond = \"o\"",
        r#"11:9: no material "n"; there are grey, m"#,
    ),
    // What other programs call it.
    (
        "[[material]]\nname = \"a\"\ntype = \"glass\"",
        r#"10:8: no material type "glass"; did you mean "dielectric"?"#,
    ),
    (
        "[[shape]]\ntype = \"sun\"",
        r#"9:8: no shape type "sun"; there are mesh, sphere, rectangle, disk, box"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nsigma_a = 1\nabsorption_distance = 5",
        "12:23: absorption_distance needs an absorption_color",
    ),
    // Roughness, metals, panes.
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nroughness = 1.5",
        "11:13: roughness is 1.5, but must lie between 0 and 1",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"conductor\"\nmetal = \"gold\"\nroughness = -0.1",
        "12:13: roughness is -0.1, but must lie between 0 and 1",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nroughness = \"rough\"",
        "11:13: roughness must be a number, not the text \"rough\"",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nior = 3\nroughness = 0.3",
        "12:13: roughness is 0.3, but where indices of refraction differ by a factor of 3 it must \
         be 0: up to 2.5 glass may be rough",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nroughness = 0.3\nfresnel = \"schlick\"",
        "12:11: fresnel \"schlick\" is for smooth glass; rough glass takes \"exact\"",
    ),
    (
        "[render]\nheuristic = \"cutoff\"",
        r#"9:13: no heuristic "cutoff"; there are power, balance, optimal"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nsampling = \"unifrom\"",
        r#"11:12: no sampling "unifrom"; did you mean "uniform"?"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nroughness = 0.3\nsampling = \"uniform\"",
        "12:12: sampling \"uniform\" is for smooth surfaces; rough ones take \"cosine\"",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"mirror\"\nroughness = 0.3",
        r#"11:1: no key "roughness" in a mirror, only in a matte material or a conductor or a dielectric or a principled material"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"conductor\"\nmetal = \"glod\"",
        r#"11:9: no metal "glod"; did you mean "gold"?"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"conductor\"\nmetal = \"platinum\"",
        r#"11:9: no metal "platinum"; there are gold, copper, silver, aluminium"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"conductor\"\nmetal = \"gold\"\neta = 1",
        "12:7: give metal or eta, not both",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"conductor\"\nmetal = \"gold\"\nk = 1",
        "12:5: give metal, or eta and k, not both",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"conductor\"",
        r#"8:1: a conductor needs "metal" or "eta""#,
    ),
    ("[[material]]\nname = \"a\"\ntype = \"conductor\"\neta = 1", r#"8:1: a conductor needs "k""#),
    (
        "[[material]]\nname = \"a\"\ntype = \"thin-dielectric\"\nior = 0.5",
        "11:7: ior is 0.5, but must lie between 1 and 10",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"thin-dielectric\"\ncolor = [1, 1, 2]",
        "11:9: color is 2, but must lie between 0 and 1",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"thin-dielectric\"\nsigma_a = 1",
        r#"11:1: no key "sigma_a" in a thin dielectric, only in a dielectric or a principled material"#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"principled\"\ncoat_roughness = 2",
        "11:18: coat_roughness is 2, but must lie between 0 and 1",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"principled\"\ntransmission = 1\nior = 3",
        "8:1: material \"a\": roughness is 0.3, but where light goes through a body of ior 3 it must be 0, and so \
         must anisotropy: up to 2.5 glass may be rough",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"principled\"\npriority = 1",
        "11:12: a priority is for bodies that light goes through: transmission must be more than \
         0, metallic less than 1, and thin_walled false",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"null\"\nalbedo = 1",
        r#"11:1: no key "albedo" in a null material, only in a matte material"#,
    ),
    // Ranges.
    ("[render]\nspp = 0", "9:7: spp is 0, but must be 1 or more"),
    ("[render]\nsize = [0, 600]", "9:8: size is 0x600, but each side must lie between 1 and 65536"),
    (
        "[render]\nsize = [8, 6]\ncrop = [4, 0, 5, 1]",
        "10:8: crop 4,0,5,1 must hold pixels and stay inside the 8x6 picture",
    ),
    ("[render]\nfilter_radius = 99", "9:17: filter_radius is 99, but must lie between 0.01 and 16"),
    (
        "[render]\nroulette = \"off\"",
        r#"9:12: roulette "off" needs a max_depth, or paths would never end"#,
    ),
    (
        "[render]\nfilter = \"box\"\nfilter_sigma = 1",
        r#"10:16: filter_sigma is for filter = "gaussian" only"#,
    ),
    (
        "[render]\nexposure = inf",
        "9:12: exposure holds the number inf, but must be finite, at most 3.4028235e38",
    ),
    (
        "[render]\nexposure = 1e999",
        "9:12: exposure holds the number 1e999, but must be finite, at most 3.4028235e38",
    ),
    (
        "[render]\nexposure = 1e39",
        "9:12: exposure holds the number 1e39, but must be finite, at most 3.4028235e38",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = [0.5, 1.5, 0]",
        "11:10: albedo is 1.5, but must lie between 0 and 1",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"matte\"\nalbedo = nan",
        "11:10: albedo holds the number nan, but must be finite, at most 3.4028235e38",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nior = 0.9",
        "11:7: ior is 0.9, but must lie between 1 and 10",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nabsorption_color = 0",
        "11:20: absorption_color is 0, but must be more than 0, up to 1",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nabsorption_distance = 1",
        "11:23: absorption_distance needs an absorption_color",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"dielectric\"\nsigma_a = 1\nabsorption_color = 1",
        "12:20: give sigma_a or absorption_color, not both",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"black\"\nemission = { radiance = -1 }",
        "11:25: radiance is -1, but must lie between 0 and 1e18",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"black\"\n\
         emission = { radiance = 1e18, strength = 1e30 }",
        "11:42: strength is 1e30, but must be 0 or more, and the radiance with it at most 1e18",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"black\"\nemission = { power = 1, strength = -1 }",
        "11:36: strength is -1, but must be 0 or more, and the power with it at most 1e18",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"emissive\"",
        r#"8:1: an emissive material needs "radiance" or "power""#,
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"emissive\"\npower = 1\nradiance = 1",
        "12:12: give power or radiance, not both",
    ),
    ("[environment]", r#"8:1: [environment] needs "image" or "color""#),
    ("[environment]\ncolor = 1\nscale = -1", "10:9: scale is -1, but must be 0 or more"),
    ("[environment]\ncolor = 1\nimage = \"sky.hdr\"", "10:9: give color or image, not both"),
    ("[environment]\ncolor = 1\nprojection = \"cube\"", "10:14: projection needs an image"),
    // Shapes.
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 0\nmaterial = \"grey\"",
        "10:10: radius is 0, but must be more than 0",
    ),
    // What the number becomes is not what is written.
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 1e-46\nmaterial = \"grey\"",
        "10:10: radius is 0, but must be more than 0 (1e-46 is 0 in single precision)",
    ),
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 1e-400\nmaterial = \"grey\"",
        "10:10: radius is 0, but must be more than 0 (1e-400 is 0 in single precision)",
    ),
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 1e-40\nmaterial = \"grey\"",
        "10:10: radius is 1e-40, but must be at least 1.1754944e-38",
    ),
    (
        "[[shape]]\ntype = \"sphere\"\nradius = 1\nscale = [1, 2, 1]\nmaterial = \"grey\"",
        "11:9: a sphere needs the same scale in all directions; use a mesh for an ellipsoid",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nscale = 0\nmaterial = \"grey\"",
        "11:9: transform flattens the shape: a scale is 0, or too close to it",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nscale = 1e30\nrotate_degrees = [10, 20, 30]\nmaterial = \"grey\"",
        "11:9: transform makes the shape too large: a scale is beyond some 1e12",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nscale = 1e-30\nrotate_degrees = [10, 20, 30]\nmaterial = \"grey\"",
        "11:9: transform flattens the shape: a scale is 0, or too close to it",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nscale = 1\nmatrix = [1]\nmaterial = \"grey\"",
        "12:10: give scale or matrix, not both",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmatrix = [1]\nmaterial = \"grey\"",
        "11:10: matrix must be 3 or 4 rows of 4 numbers, or those 12 or 16 numbers in one array, not an array with 1 entry",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmatrix = [[1, 2]]\nmaterial = \"grey\"",
        "11:11: matrix must be rows of 4 numbers, not an array with 2 entries",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nmatrix = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,2]\nmaterial = \"grey\"",
        "11:10: the last row of matrix must be 0, 0, 0, 1",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nrotate = { axis = [0, 0, 0], degrees = 5 }\nmaterial = \"grey\"",
        "11:19: it points nowhere: all three numbers are 0",
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\nrotate = { axs = [0, 1, 0], degrees = 5 }\nmaterial = \"grey\"",
        r#"11:12: no key "axs"; did you mean "axis"?"#,
    ),
    (
        "[[shape]]\ntype = \"disk\"\nradius = 1\ncenter = [0, 0, 0]\ntranslate = [0, 0, 1]\nmaterial = \"grey\"",
        "12:13: give center or translate, not both",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\nmaterial = \"grey\"",
        r#"8:1: a mesh needs "file" or "positions""#,
    ),
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"none.obj\"\nmaterial = \"grey\"",
        r#"10:8: there is no file "none.obj" beside the scene"#,
    ),
    (
        "[[shape]]\ntype = \"mesh\"\nfile = \"a.obj\"\ntriangles = []\nmaterial = \"grey\"",
        "11:13: give file or triangles, not both",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 1]]\nmaterial = \"grey\"",
        "11:14: the triangle names vertex 1, but there are only 1 (numbered from 0)",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\nnormals = []\ntriangles = [[0, 0]]\nmaterial = \"grey\"",
        "12:14: triangles must be three vertex numbers each [[a, b, c], ..], not an array with 2 entries",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0], [1, 0, 0]]\nnormals = [[0, 0, 1]]\ntriangles = [[0, 0, 1]]\nmaterial = \"grey\"",
        "11:11: 1 normals for 2 positions; give one each, or none",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 0]]",
        r#"8:1: a mesh needs "material""#,
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 0]]\nsmooth_degrees = 181\nmaterial = \"grey\"",
        "12:18: smooth_degrees is 181, but must lie between 0 and 180",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = [[0, 0, 0]]\ntriangles = [[0, 0, 0]]\nfit = { size = 1 }\nmaterial = \"grey\"",
        "12:7: the mesh is flat along that axis; name another",
    ),
    (
        "[[shape]]\ntype = \"mesh\"\npositions = []\ntriangles = []\nfit = { size = 1 }\nmaterial = \"grey\"",
        "12:7: the mesh has no point that could be fitted",
    ),
    (
        "[[light]]\ntype = \"directional\"\ndirection = [0, 0, 0]\nirradiance = 1",
        "10:13: direction has no length",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\n",
        r#"8:1: a spot needs "direction" or "look_at""#,
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n",
        r#"8:1: a spot needs "intensity" or "power""#,
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 1]\nintensity = 1",
        "11:11: look_at is where the light itself is",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\ndirection = [0, 0, 0]\nintensity = 1",
        "11:13: direction has no length",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nintensity = 1\npower = 1",
        "13:9: give intensity or power, not both",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\npower = -1",
        "12:9: power is -1, but must lie between 0 and 1e18",
    ),
    // Light beyond all numbers would be lost.
    ("[environment]\ncolor = [1, 1e19, 1]", "9:9: color is 1e19, but must lie between 0 and 1e18"),
    (
        "[environment]\ncolor = [0, 1e10, 0]\nscale = 1e30",
        "10:9: scale is 1e30, but times color, 1e10, must be at most 1e18",
    ),
    (
        "[[material]]\nname = \"a\"\ntype = \"emissive\"\npower = 1e30",
        "11:9: power is 1e30, but must lie between 0 and 1e18",
    ),
    (
        "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nintensity = 1e38",
        "11:13: intensity is 1e38, but must lie between 0 and 1e18",
    ),
    (
        "[[light]]\ntype = \"directional\"\ndirection = [0, 0, 1]\nirradiance = 1e38",
        "11:14: irradiance is 1e38, but must lie between 0 and 1e18",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\npower = 1\nouter_degrees = 0",
        "13:17: outer_degrees is 0, but must lie between 0.01 and 180",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\npower = 1\nouter_degrees = 30\ninner_degrees = 40",
        "14:17: inner_degrees is 40, but must lie between 0 and outer_degrees, 30",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\npower = 1\ninner_degrees = -1",
        "13:17: inner_degrees is -1, but must lie between 0 and outer_degrees, 45",
    ),
    (
        "[[light]]\ntype = \"spot\"\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\npower = 1\nradius = 1",
        r#"13:1: no key "radius" in a spot, only in a sphere or disk"#,
    ),
    (
        "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]",
        r#"8:1: a point light needs "intensity""#,
    ),
];

/// The camera is in [`HEAD`]; these are scenes of their own.
const WHOLE_SCENES: &[(&str, &str)] = &[
    ("", r#"1:1: the scene needs "version": begin it with "version = 1""#),
    (
        "version = 1\nmaterial = 5",
        "2:12: material must be tables like [[material]], not the number 5",
    ),
    ("version = 1\nmaterial = [5]", "2:13: material must be a table, not the number 5"),
    (
        "version = 1\n[[material]]\nname = \"a\"\ntype = \"black\"\nemission = 5",
        "5:12: emission must be a table, not the number 5",
    ),
    ("verson = 1", r#"1:1: no key "verson"; did you mean "version"?"#),
    ("version = 2\nwhatever = 5", "1:11: version 2 of the scene format is not known; 1 is"),
    ("version = \"1\"", r#"1:11: version must be a whole number, 0 or more, not the text "1""#),
    ("version = 1", "1:1: there is no [camera], and no shape that one could be turned to"),
    (
        "version = 1\n[[material]]\nname = \"a\"\ntype = \"black\"\n[[shape]]\ntype = \"sphere\"\nmaterial = \"a\"\nradius = 3e38",
        "1:1: there is no [camera], and what is there cannot have one: it is too large: a camera \
         that sees all of it would be farther away than single precision reaches",
    ),
    (
        "version = 1\r[render]\rspp = 1\r",
        "1:13: carriage return must be followed by newline, expected newline; the line ends are CR \
         alone: save the file with LF or CR LF",
    ),
    ("version = 1\n[camera]\nlook_at = [0, 0, 0]", r#"2:1: [camera] needs "position""#),
    (
        "version = 1\n[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, 0]",
        "2:1: the camera has no direction: position and look_at are the same point, or too far apart",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nup = [0, 0, 0]",
        "5:6: it points nowhere: all three numbers are 0",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfov_degrees = 180",
        "5:15: fov_degrees is 180, but must be more than 0 and less than 180",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfov_degrees = 179.9999999",
        "5:15: fov_degrees is 180, but must be more than 0 and less than 180 \
         (179.9999999 is 180 in single precision)",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_distance = 1e-38",
        "5:18: focus_distance is 1e-38, but must be at least 1.1754944e-38",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nf_number = 1e-50",
        "5:12: f_number is 0, but must be more than 0 (1e-50 is 0 in single precision)",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nf_number = 0",
        "5:12: f_number is 0, but must be more than 0",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nf_number = 1e-42",
        "5:12: f_number is 1e-42, too little for any lens",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nf_number = 2\nfov_degrees = 0",
        "6:15: fov_degrees is 0, but must be more than 0 and less than 180",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nf_number = 1e-9",
        "5:12: the lens has a radius of 1.4485281e7, but that must be at most 1000000 times the focus distance of 1",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_at = [0, 0, 2]",
        "5:12: focus_at lies behind the camera, or beside it",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_distance = -1",
        "5:18: focus_distance is -1, but must be more than 0",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_distance = 1\nfocus_at = [0, 0, 0]",
        "6:12: give focus_distance or focus_at, not both",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\ntype = \"fisheye\"",
        r#"5:8: no camera type "fisheye"; there are perspective, orthographic, equirectangular"#,
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\ntype = \"orthographic\"",
        r#"2:1: an orthographic [camera] needs "height""#,
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\ntype = \"orthographic\"\nheight = 0",
        "6:10: height is 0, but must be more than 0",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\ntype = \"orthographic\"\nheight = 1\nf_number = 2",
        r#"7:1: no key "f_number" in an orthographic [camera], only in a perspective [camera]"#,
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\ntype = \"equirectangular\"\nblades = 6",
        r#"6:1: no key "blades" in an equirectangular [camera], only in a perspective or orthographic [camera]"#,
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nheight = 2",
        r#"5:1: no key "height" in [camera], only in an orthographic [camera]"#,
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocal_length_mm = 0",
        "5:19: focal_length_mm is 0, but must be more than 0",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocal_length_mm = 50\nfov_degrees = 40",
        "6:15: give focal_length_mm or fov_degrees, not both",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nsensor_height_mm = 24",
        "5:20: sensor_height_mm needs a focal_length_mm or an f_number",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nf_number = 2\nsensor_height_mm = -24",
        "6:20: sensor_height_mm is -24, but must be more than 0",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nblades = 6",
        "5:10: blades needs an aperture_radius or an f_number",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\naperture_radius = 1\nblades = 2",
        "6:10: blades is 2, but must be 0 for a round lens, or lie between 3 and 100",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\naperture_radius = 1\nblades = 5.5",
        "6:10: blades must be a whole number, 0 or more, not the number 5.5",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\naperture_radius = 1\nblade_rotation_degrees = 9",
        "6:26: blade_rotation_degrees needs blades: a round lens has no corners",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\naperture_radius = 1\naperture_ratio = 0",
        "6:18: aperture_ratio is 0, but must lie between 0.01 and 100",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_on = [800, 20]",
        "5:12: focus_on is 800,20, but the picture has 800x600 pixels, from 0,0 on",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_on = [4.5, 20]",
        "5:13: focus_on must be two whole numbers [x, y], not the number 4.5",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfocus_on = [4, 20]\nfocus_at = [0, 0, 0]",
        "6:12: give focus_on or focus_at, not both",
    ),
    (
        "version = 1\n[camera]\nposition = [0, 0, 1e38]\nlook_at = [0, 0, -3e38]",
        "2:1: the camera has no direction: position and look_at are the same point, or too far apart",
    ),
];

/// A light group too many is told at the first light that names it.
#[test]
fn a_light_group_too_many_is_told_at_its_light() {
    let light = |i: usize| {
        format!(
            "[[light]]\ntype = \"point\"\nposition = [0, 1, 0]\nintensity = 1\ngroup = \"g{i}\"\n"
        )
    };
    let text = |count: usize| HEAD.to_owned() + &(0..count).map(light).collect::<String>();
    assert!(parse(&text(64)).is_ok());
    let error = parse(&(text(65) + &light(2))).expect_err("65 groups").to_string();
    let line = HEAD.lines().count() + 65 * 5;
    let said = "the light group \"g64\" is one too many: a scene has 64 at most";
    assert_eq!(error, format!("scene.toml:{line}:9: {said}"));
}

#[test]
fn mistakes_are_explained() {
    let after_head = MISTAKES.iter().map(|(text, said)| (format!("{HEAD}{text}"), *said));
    let whole = WHOLE_SCENES.iter().map(|(text, said)| ((*text).to_owned(), *said));
    for (text, said) in after_head.chain(whole) {
        let error = parse(&text).expect_err(&text).to_string();
        assert_eq!(error, format!("scene.toml:{said}"), "{text}");
    }
}
