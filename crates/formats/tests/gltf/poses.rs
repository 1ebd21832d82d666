//! Where things stand, and how meshes are bent: against numbers worked out by hand.

use crate::builder::{Builder, read};
use rutilant_formats::scene::gltf::{Document, Moment, Pose};
use rutilant_geom::Vec3;
use serde_json::json;

const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;

fn at(document: &Document, seconds: f32) -> Pose {
    document.pose(Some(Moment { animation: 0, seconds }))
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

/// Parents move their children, mirrors and scales among them: 1 x, turned to y, doubled,
/// mirrored, moved.
#[test]
fn hierarchies_multiply() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([
        {"mesh": 0, "rotation": [0, 0, HALF, HALF]},
        {"children": [0], "scale": [2, -2, 2]},
        {"children": [1], "translation": [10, 0, 0]},
        {"mesh": 0, "translation": [5, 0, 0]},
    ]);
    builder.json["scenes"] = json!([{"nodes": [2]}, {"nodes": [3]}]);
    builder.json["scene"] = json!(0);
    let document = builder.read();
    let placed = document.placed(None, &document.pose(None)).expect("finite");
    assert_eq!(placed.len(), 1);
    assert!(near(placed[0].world_from_node.point(Vec3::X), Vec3::new(10.0, -2.0, 0.0)));
    assert!(placed[0].world_from_node.mirrors());
    let other = document.placed(Some(1), &document.pose(None)).expect("finite");
    assert_eq!((other.len(), other[0].node), (1, 3));
    // Without scenes all roots are seen.
    builder.json["scenes"] = json!([]);
    builder.json.as_object_mut().expect("an object").remove("scene");
    let document = builder.read();
    assert_eq!(document.placed(None, &document.pose(None)).expect("finite").len(), 2);
}

/// A hundred thousand nodes, one below the other: each moves by one.
#[test]
fn deep_hierarchies_end() {
    let count = 100_000;
    let node = |i| format!("{{\"translation\":[1,0,0],\"children\":[{i}]}},");
    let above: String = (1..count).map(node).collect();
    let text = Builder::triangle().text();
    let deep = text.replace("\"nodes\":[{\"mesh\"", &format!("\"nodes\":[{above}{{\"mesh\""));
    assert!(deep.len() > text.len());
    let document = read(deep.as_bytes()).expect("read");
    let placed = document.placed(None, &document.pose(None)).expect("finite");
    assert_eq!(placed[0].world_from_node.translation(), Vec3::new(99_999.0, 0.0, 0.0));
}

/// What is hidden hides what is below it.
#[test]
fn hidden_nodes_are_not_placed() {
    let mut builder = Builder::triangle();
    builder.json["nodes"] = json!([
        {"mesh": 0, "children": [1], "extensions": {"KHR_node_visibility": {"visible": false}}},
        {"mesh": 0}, {"mesh": 0}]);
    builder.json["scenes"] = json!([{"nodes": [0, 2]}]);
    let document = builder.read();
    let placed = document.placed(None, &document.pose(None)).expect("finite");
    assert_eq!(placed.iter().map(|placed| placed.node).collect::<Vec<_>>(), [2]);
}

/// Instances stand in the node's space: turned by whole numbers, scaled, moved.
#[test]
fn instances_stand_in_their_node() {
    let mut builder = Builder::triangle();
    let translation = builder.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let turn = [0_i16, 0, 0, 32767, 0, 0, 23170, 23170];
    let turn: Vec<u8> = turn.iter().flat_map(|n| n.to_le_bytes()).collect();
    let rotation = builder.array("VEC4", 5122, 2, &turn);
    builder.json["accessors"][rotation]["normalized"] = json!(true);
    let scale = builder.floats("VEC3", &[1.0, 1.0, 1.0, 3.0, 3.0, 3.0]);
    builder.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {
        "TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale, "_ID": 0}}});
    builder.json["nodes"][0]["translation"] = json!([0, 0, 5]);
    let document = builder.read();
    let placed = document.placed(None, &document.pose(None)).expect("finite");
    let copies = placed[0].copies.as_ref().expect("copies");
    let to = |i: usize| {
        let copy = copies[i].to_transform().expect("finite");
        (placed[0].world_from_node * copy).point(Vec3::X)
    };
    assert!(near(to(0), Vec3::new(1.0, 0.0, 5.0)));
    assert!(near(to(1), Vec3::new(1.0, 3.0, 5.0)));
}

/// A document whose only node is animated; `path` and the sampler's parts are given.
fn animated(
    path: &str,
    kind: &str,
    interpolation: &str,
    times: &[f32],
    values: &[f32],
) -> Document {
    let mut builder = Builder::triangle();
    let input = builder.floats("SCALAR", times);
    let output = builder.floats(kind, values);
    builder.json["animations"] = json!([{
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}]}]);
    builder.read()
}

fn moved(document: &Document, seconds: f32, point: Vec3) -> Vec3 {
    let placed = document.placed(None, &at(document, seconds)).expect("finite");
    placed[0].world_from_node.point(point)
}

/// Straight lines and steps; before and after, time stands still; without a moment the node is
/// where it is without animations.
#[test]
fn values_go_straight_or_in_steps() {
    let values = [0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 4.0, 8.0, 0.0];
    for (interpolation, expected) in [
        ("LINEAR", [[0.0, 0.0], [1.0, 0.0], [4.0, 0.0], [4.0, 4.0], [4.0, 8.0]]),
        ("STEP", [[0.0, 0.0], [0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [4.0, 8.0]]),
    ] {
        let document = animated("translation", "VEC3", interpolation, &[1.0, 2.0, 4.0], &values);
        for (seconds, [x, y]) in [-3.0, 1.25, 2.0, 3.0, 9.0].into_iter().zip(expected) {
            let there = moved(&document, seconds, Vec3::ZERO);
            assert!(near(there, Vec3::new(x, y, 0.0)), "{interpolation} {seconds}: {there}");
        }
        let placed = document.placed(None, &document.pose(None)).expect("finite");
        assert_eq!(placed[0].world_from_node.translation(), Vec3::ZERO);
        assert_eq!(document.animations[0].span(), Some([1.0, 4.0]));
    }
}

/// A Hermite spline through two keyframes is the cubic that it was made of: t³ - 2t² over two
/// seconds from 1 s on, with slopes 3t² - 4t. A cubic is told by four numbers, so it must be met
/// everywhere; slopes not scaled by the time between the keyframes would miss it.
#[test]
fn splines_are_cubics() {
    let value = |t: f32| t * t * t - 2.0 * t * t;
    let slope = |t: f32| 3.0 * t * t - 4.0 * t;
    let mut values = Vec::new();
    for t in [0.0, 2.0] {
        values.extend([slope(t), 0.0, 0.0, value(t), 0.0, 0.0, slope(t), 0.0, 0.0]);
    }
    let document = animated("translation", "VEC3", "CUBICSPLINE", &[1.0, 3.0], &values);
    for i in 0..=8 {
        let t = i as f32 * 0.25;
        let x = moved(&document, 1.0 + t, Vec3::ZERO).x;
        assert!((x - value(t)).abs() < 1e-5, "{t}: {x}");
    }
}

/// From nothing to half a turn around z at equal speed, whichever sign the second quaternion
/// has: after a third of the time a third of the angle.
#[test]
fn rotations_take_the_shortest_way() {
    // A quarter turn, and the same with the other sign.
    for sign in [1.0, -1.0] {
        let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, sign * HALF, sign * HALF];
        let document = animated("rotation", "VEC4", "LINEAR", &[0.0, 3.0], &values);
        for (seconds, degrees) in [(0.0, 0.0_f32), (1.0, 30.0), (2.0, 60.0), (3.0, 90.0)] {
            let there = moved(&document, seconds, Vec3::X);
            let (sine, cosine) = degrees.to_radians().sin_cos();
            assert!(near(there, Vec3::new(cosine, sine, 0.0)), "{seconds}: {there}");
        }
    }
    // Nearly the same rotation: nothing is divided by nothing.
    let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1e-6, 1.0];
    let document = animated("rotation", "VEC4", "LINEAR", &[0.0, 1.0], &values);
    assert!(near(moved(&document, 0.5, Vec3::X), Vec3::X));
}

/// Morph targets: the mesh's weights, the node's in their place, and those of an animation in
/// place of both. Values of 16-bit parts, and normals and tangents that follow.
#[test]
fn targets_are_added() {
    let mut builder = Builder::triangle();
    let normal = builder.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangent = builder.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let up = builder.floats("VEC3", &[0.0, 0.0, 8.0].repeat(3));
    let side = builder.floats("VEC3", &[0.0, 4.0, 0.0].repeat(3));
    let primitive = &mut builder.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["NORMAL"] = json!(normal);
    primitive["attributes"]["TANGENT"] = json!(tangent);
    primitive["targets"] =
        json!([{"POSITION": up, "NORMAL": side}, {"POSITION": side, "TANGENT": up}]);
    let bent = |builder: &Builder, moment| {
        let document = builder.read();
        let pose = document.pose(moment);
        let bent = document.bent(&pose, 0, &document.meshes[0].primitives[0]);
        (bent.positions[1], bent.normals.expect("there")[1], bent.tangents.expect("there")[1])
    };
    assert_eq!(bent(&builder, None), (Vec3::X, Vec3::Z, [1.0, 0.0, 0.0, -1.0]));
    builder.json["meshes"][0]["weights"] = json!([0.5, 0]);
    assert_eq!(
        bent(&builder, None),
        (Vec3::new(1.0, 0.0, 4.0), Vec3::new(0.0, 2.0, 1.0), [1.0, 0.0, 0.0, -1.0])
    );
    builder.json["nodes"][0]["weights"] = json!([0, 0.25]);
    assert_eq!(bent(&builder, None), (Vec3::new(1.0, 1.0, 0.0), Vec3::Z, [1.0, 0.0, 2.0, -1.0]));
    let input = builder.floats("SCALAR", &[0.0, 1.0]);
    let output = builder.shorts("SCALAR", 4, &[0, 0, 65535, 65535]);
    builder.json["accessors"][output]["normalized"] = json!(true);
    builder.json["animations"] = json!([{"samplers": [{"input": input, "output": output}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}]}]);
    let moment = Some(Moment { animation: 0, seconds: 0.5 });
    assert_eq!(bent(&builder, moment).0, Vec3::new(1.0, 2.0, 4.0));
}

/// Two joints, one of which turns: vertices follow the first, the second, and half of each. The
/// node's own place does not count, weights are divided by their sum, and what no joint holds
/// follows the first.
#[test]
fn skins_bend_meshes() {
    let mut builder = Builder::triangle();
    builder.floats("VEC3", &[1.0, 0.0, 0.0].repeat(4));
    let normal = builder.floats("VEC3", &[1.0, 0.0, 0.0].repeat(4));
    let joints = builder.array("VEC4", 5121, 4, &[0, 1, 9, 0].repeat(4));
    let weights = builder.floats(
        "VEC4",
        &[1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.25, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    builder.json["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": 1, "NORMAL": normal, "JOINTS_0": joints, "WEIGHTS_0": weights});
    // At rest the second joint stands at (1, 0, 0), so its inverse moves back from there.
    let mut matrices = [0.0; 32];
    for i in [0, 5, 10, 15] {
        matrices[i] = 1.0;
        matrices[16 + i] = 1.0;
    }
    matrices[16 + 12] = -1.0;
    let inverse = builder.floats("MAT4", &matrices);
    builder.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": inverse}]);
    // The second is moved to (1, 2, 0), and turned by a quarter around y.
    builder.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"children": [2]},
        {"translation": [1, 2, 0], "rotation": [0, HALF, 0, HALF]}]);
    builder.json["scenes"] = json!([{"nodes": [0, 1]}]);
    let document = builder.read();
    let pose = document.pose(None);
    let placed = document.placed(None, &pose).expect("finite");
    assert_eq!(placed[0].world_from_mesh.point(Vec3::X), Vec3::X);
    let bent = document.bent(&pose, 0, &document.meshes[0].primitives[0]);
    let normals = bent.normals.expect("there");
    // At rest the vertex is at the second joint itself, so it goes where the joint does.
    let (rest, gone) = (Vec3::X, Vec3::new(1.0, 2.0, 0.0));
    let between = Vec3::new(1.0, 1.0, 0.0);
    for (i, expected) in [rest, gone, between, rest].into_iter().enumerate() {
        assert!(near(bent.positions[i], expected), "{i}: {}", bent.positions[i]);
    }
    // A quarter turn around y takes +x to -z.
    let between = (Vec3::X - Vec3::Z).normalize();
    for (i, expected) in [Vec3::X, -Vec3::Z, between, Vec3::X].into_iter().enumerate() {
        assert!(near(normals[i], expected), "{i}: {}", normals[i]);
    }
}
