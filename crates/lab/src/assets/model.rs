//! A model: shapes with materials, placed by nodes.

use super::shape::{Point, Shape};

#[derive(Debug, Clone, Copy)]
pub struct Material {
    pub name: &'static str,
    /// sRGB.
    pub colour: [u8; 3],
    pub metallic: f64,
    pub roughness: f64,
}

impl Material {
    pub const fn new(name: &'static str, colour: [u8; 3]) -> Self {
        Self { name, colour, metallic: 0.0, roughness: 0.8 }
    }

    pub const fn metal(name: &'static str, colour: [u8; 3]) -> Self {
        Self { name, colour, metallic: 0.9, roughness: 0.35 }
    }
}

/// A node of the scene: first scaled, then turned about x, then moved.
#[derive(Debug, Clone)]
pub struct Node {
    pub name: String,
    pub mesh: Option<usize>,
    pub parent: Option<usize>,
    pub scale: [f64; 3],
    /// Degrees about the x axis.
    pub tilt: f64,
    pub translation: [f64; 3],
    /// A custom property, as Blender calls it.
    pub extras: Option<(&'static str, &'static str)>,
}

impl Node {
    pub fn new(name: &str, mesh: Option<usize>) -> Self {
        Self {
            name: name.into(),
            mesh,
            parent: None,
            scale: [1.0; 3],
            tilt: 0.0,
            translation: [0.0; 3],
            extras: None,
        }
    }

    fn apply(&self, point: Point) -> Point {
        let Point { x, y, z } = point * Point::from(self.scale);
        let (sine, cosine) = self.tilt.to_radians().sin_cos();
        let turned = Point::new(x, y * cosine - z * sine, y * sine + z * cosine);
        turned + Point::from(self.translation)
    }
}

#[derive(Debug, Clone)]
pub struct Model {
    /// The file's name without `.glb`.
    pub name: &'static str,
    pub purpose: &'static str,
    /// Whether each component is a closed surface.
    pub closed: bool,
    pub materials: Vec<Material>,
    pub meshes: Vec<Shape>,
    /// One for each mesh.
    pub mesh_names: Vec<&'static str>,
    pub nodes: Vec<Node>,
}

impl Model {
    /// A model of one mesh and one node.
    pub fn single(
        name: &'static str,
        purpose: &'static str,
        materials: Vec<Material>,
        shape: Shape,
    ) -> Self {
        Self {
            name,
            purpose,
            closed: true,
            materials,
            meshes: vec![shape],
            mesh_names: vec![name],
            nodes: vec![Node::new(name, Some(0))],
        }
    }

    /// Takes over the mesh of a model of one mesh, and its materials. Returns the mesh's number.
    pub fn add_mesh(&mut self, model: Self) -> usize {
        let first = self.materials.len();
        self.materials.extend(model.materials);
        for mut shape in model.meshes {
            shape.materials.iter_mut().for_each(|material| *material += first);
            self.meshes.push(shape);
        }
        self.mesh_names.extend(model.mesh_names);
        self.meshes.len() - 1
    }

    /// All meshes of the scene, node transforms applied.
    pub fn flattened(&self) -> Shape {
        let mut all = Shape::default();
        for (index, node) in self.nodes.iter().enumerate() {
            let Some(mesh) = node.mesh else { continue };
            let place = |point| {
                let (mut point, mut at) = (point, Some(index));
                while let Some(index) = at {
                    point = self.nodes[index].apply(point);
                    at = self.nodes[index].parent;
                }
                point
            };
            all = all.with(self.meshes[mesh].clone().map(place));
        }
        all
    }
}
