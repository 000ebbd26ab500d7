//! A scene whose collision an artist has tagged.

use super::household::{lamp, mug, table};
use super::model::{Model, Node};
use super::nature::leaf;
use super::shape::cells;

/// What each tag below asks for is said in `docs/bevy/artists.md`.
pub fn props() -> Model {
    const TOP: f64 = 0.74;
    const HALF: [f64; 2] = [-0.5, 0.5];
    let mut scene = Model {
        name: "props",
        purpose: "a scene with an artist's tags: a suffix, convex pieces, an extra, and no tag",
        closed: false,
        materials: Vec::new(),
        meshes: Vec::new(),
        mesh_names: Vec::new(),
        nodes: Vec::new(),
    };
    let at = |translation: [f64; 3], node: Node| Node { translation, ..node };
    let mesh = scene.add_mesh(mug());
    scene.nodes.push(at([-0.25, TOP, 0.1], Node::new("mug-convdecomp", Some(mesh))));
    let mesh = scene.add_mesh(lamp());
    let extras = Some(("collider", "convex_decomposition"));
    scene.nodes.push(Node { extras, ..at([0.25, TOP, 0.0], Node::new("lamp", Some(mesh))) });
    let mesh = scene.add_mesh(leaf());
    scene.nodes.push(at([0.75, 0.0, 0.3], Node::new("leaf", Some(mesh))));

    let wood = scene.materials.len();
    let mesh = scene.add_mesh(table());
    let whole = scene.nodes.len();
    scene.nodes.push(Node::new("table", Some(mesh)));
    let mut cube = cells([&HALF, &HALF, &HALF], |_| true);
    cube.materials.fill(wood);
    scene.meshes.push(cube);
    scene.mesh_names.push("block");
    let mut piece = |number: usize, scale: [f64; 3], translation: [f64; 3]| {
        let node = Node::new(&format!("UCX_table_{number:02}"), Some(mesh + 1));
        scene.nodes.push(Node { parent: Some(whole), scale, translation, ..node });
    };
    piece(1, [1.20, 0.04, 0.80], [0.0, 0.72, 0.0]);
    for (number, (x, z)) in
        [(-0.57, -0.37), (-0.57, 0.37), (0.57, -0.37), (0.57, 0.37)].into_iter().enumerate()
    {
        piece(number + 2, [0.06, 0.70, 0.06], [x, 0.35, z]);
    }
    scene
}
