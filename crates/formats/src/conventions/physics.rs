//! Rigid bodies, colliders, materials and filters as glTF's physics extensions say them:
//! `KHR_physics_rigid_bodies` with `KHR_implicit_shapes`, and `OMI_physics_body` with
//! `OMI_physics_shape`. Joints are left out.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::extras::Body;
use super::surface::{SurfaceProperties, coefficient, combine_rule};

const KHR_BODIES: &str = "KHR_physics_rigid_bodies";
const KHR_SHAPES: &str = "KHR_implicit_shapes";
const OMI_BODIES: &str = "OMI_physics_body";
const OMI_SHAPES: &str = "OMI_physics_shape";
const OMI_JOINTS: &str = "OMI_physics_joint";

/// The extensions that are read, of documents and of nodes.
pub const PHYSICS_EXTENSIONS: [&str; 5] =
    [KHR_BODIES, KHR_SHAPES, OMI_BODIES, OMI_SHAPES, OMI_JOINTS];

/// Why something that a physics extension says is left out.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PhysicsError {
    /// A number names nothing.
    #[error("{what} {index} does not exist: there are {count}")]
    NotThere {
        /// What is named.
        what: &'static str,
        /// The number, as it is written.
        index: String,
        /// How many there are.
        count: usize,
    },
    /// A property has a value that means nothing.
    #[error("\"{key}\" is {value}, and should be {expected}")]
    WrongValue {
        /// The property.
        key: &'static str,
        /// The value, as it is written.
        value: String,
        /// What it takes.
        expected: &'static str,
    },
    /// A collider has no shape, or several.
    #[error("a collider needs either a shape or a node, and has {0}")]
    Geometry(&'static str),
    /// A filter names the systems that it collides with, and those that it does not.
    #[error(
        "a collision filter has either \"collideWithSystems\" or \"notCollideWithSystems\", not both"
    )]
    BothFilters,
}

/// What a physics extension says of a node. Lengths are in the node's units, the rest in SI units.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct NodePhysics {
    /// The body that the node is; without one it belongs to the body above it, or stands still.
    pub motion: Option<BodyMotion>,
    /// A collider of that body.
    pub collider: Option<DeclaredCollider>,
    /// A sensor of that body.
    pub trigger: Option<DeclaredCollider>,
    /// Whether it has a joint, which is left out.
    pub has_joint: bool,
}

/// How a body moves. Vectors are in the space of its node.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyMotion {
    /// What moves it.
    pub body: Body,
    /// The mass, 0 for one without limit; `None` for that of the colliders.
    pub mass: Option<f32>,
    /// The centre of mass; `None` for that of the colliders.
    pub centre: Option<[f32; 3]>,
    /// The principal moments of inertia, 0 for one without limit; `None` for those of the
    /// colliders.
    pub inertia: Option<[f32; 3]>,
    /// The rotation of the principal axes, a unit quaternion (x, y, z, w).
    pub inertia_rotation: [f32; 4],
    /// The velocity that it begins with.
    pub linear_velocity: [f32; 3],
    /// The angular velocity that it begins with.
    pub angular_velocity: [f32; 3],
    /// A factor of gravity.
    pub gravity_factor: f32,
}

/// A collider that the file itself has.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeclaredCollider {
    /// Its shape.
    pub geometry: Geometry,
    /// Its material.
    pub surface: SurfaceProperties,
    /// What it collides with; `None` for everything.
    pub filter: Option<CollisionFilter>,
}

/// The shape of a collider.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Geometry {
    /// A shape by its measures.
    Shape(ImplicitShape),
    /// The meshes of a node and of all below it, in the node's space.
    Node {
        /// The node's index, which exists.
        node: usize,
        /// Whether the shape is the convex hull of the meshes.
        is_convex: bool,
    },
    /// A mesh.
    Mesh {
        /// The mesh's index, which exists.
        mesh: usize,
        /// Whether the shape is the convex hull of the mesh.
        is_convex: bool,
    },
}

/// A shape by its measures, around the origin and along the y axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ImplicitShape {
    /// A box.
    Cuboid {
        /// Its whole sizes; positive.
        size: [f32; 3],
    },
    /// A ball.
    Ball {
        /// Positive.
        radius: f32,
    },
    /// The hull of two balls.
    Capsule {
        /// From centre to centre; positive.
        height: f32,
        /// Of the upper ball.
        radius_top: f32,
        /// Of the lower ball.
        radius_bottom: f32,
    },
    /// The hull of two discs: a cylinder, a cone, or what is between them.
    Cylinder {
        /// From disc to disc; positive.
        height: f32,
        /// Of the upper disc.
        radius_top: f32,
        /// Of the lower disc.
        radius_bottom: f32,
    },
    /// A plane that faces up.
    Plane {
        /// Its whole size along x; `None` if it never ends.
        size_x: Option<f32>,
        /// Its whole size along z; `None` if it never ends.
        size_z: Option<f32>,
        /// Whether it also faces down.
        is_double_sided: bool,
    },
}

/// Which colliders meet, by the names of systems that they belong to.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct CollisionFilter {
    /// The systems that it belongs to.
    pub systems: Vec<String>,
    /// The systems that it collides with, whatever else there is; `None` for all but the next.
    pub collide_with: Option<Vec<String>>,
    /// The systems that it does not collide with.
    pub not_collide_with: Vec<String>,
}

/// The physics extensions of a document, from which those of its nodes are read.
///
/// ```
/// use hullwright_formats::conventions::{Geometry, ImplicitShape, PhysicsExtensions};
/// use serde_json::json;
///
/// let document = json!({"KHR_implicit_shapes": {"shapes": [
///     {"type": "sphere", "sphere": {"radius": 0.1}}
/// ]}});
/// let node = json!({"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}});
/// let (Some(document), Some(node)) = (document.as_object(), node.as_object()) else { return };
/// let (physics, errors) = PhysicsExtensions::new(document, 1, 0).of_node(node);
/// assert!(errors.is_empty());
/// let collider = physics.and_then(|physics| physics.collider);
/// let ball = Geometry::Shape(ImplicitShape::Ball { radius: 0.1 });
/// assert_eq!(collider.map(|collider| collider.geometry), Some(ball));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct PhysicsExtensions<'a> {
    khr: Lists<'a>,
    omi: Lists<'a>,
    nodes: usize,
    meshes: usize,
}

/// What nodes name by number.
#[derive(Debug, Clone, Copy)]
struct Lists<'a> {
    shapes: &'a [Value],
    materials: &'a [Value],
    filters: &'a [Value],
    defaults: Defaults,
}

/// Where the two extensions leave a measure out.
#[derive(Debug, Clone, Copy)]
struct Defaults {
    capsule_height: f32,
    cylinder_height: f32,
    radius: f32,
}

const KHR_DEFAULTS: Defaults = Defaults { capsule_height: 0.5, cylinder_height: 0.5, radius: 0.25 };

const OMI_DEFAULTS: Defaults = Defaults { capsule_height: 1.0, cylinder_height: 2.0, radius: 0.5 };

type Read<T> = Result<T, PhysicsError>;

impl<'a> PhysicsExtensions<'a> {
    /// Of the extensions of a document with these numbers of nodes and meshes. O(1).
    pub fn new(extensions: &'a Map<String, Value>, nodes: usize, meshes: usize) -> Self {
        let list = |extension: &str, key: &str| -> &[Value] {
            let list = extensions.get(extension).and_then(|of| of.get(key)?.as_array());
            list.map_or(&[], Vec::as_slice)
        };
        let lists = |shapes, bodies, defaults| Lists {
            shapes: list(shapes, "shapes"),
            materials: list(bodies, "physicsMaterials"),
            filters: list(bodies, "collisionFilters"),
            defaults,
        };
        Self {
            khr: lists(KHR_SHAPES, KHR_BODIES, KHR_DEFAULTS),
            omi: lists(OMI_SHAPES, OMI_BODIES, OMI_DEFAULTS),
            nodes,
            meshes,
        }
    }

    /// What the extensions of a node say; `None` if nothing. What is wrong is left out, and the
    /// rest holds. O(size).
    pub fn of_node(
        &self,
        extensions: &Map<String, Value>,
    ) -> (Option<NodePhysics>, Vec<PhysicsError>) {
        let (lists, node) = match (extensions.get(KHR_BODIES), extensions.get(OMI_BODIES)) {
            (Some(node), _) => (&self.khr, node),
            (None, Some(node)) => (&self.omi, node),
            (None, None) => {
                let has_joint = extensions.contains_key(OMI_JOINTS);
                let joint = NodePhysics { has_joint, ..NodePhysics::default() };
                return (has_joint.then_some(joint), Vec::new());
            }
        };
        let mut errors = Vec::new();
        let mut collider = |key: &str| {
            let said = node.get(key)?;
            let collider = self.collider(lists, said, &mut errors);
            collider.unwrap_or_else(|error| {
                errors.push(error);
                None
            })
        };
        let (solid, trigger) = (collider("collider"), collider("trigger"));
        let motion = node.get("motion").map(|motion| match extensions.contains_key(KHR_BODIES) {
            true => khr_motion(motion, &mut errors),
            false => omi_motion(motion, &mut errors),
        });
        let has_joint = node.get("joint").is_some() || extensions.contains_key(OMI_JOINTS);
        (Some(NodePhysics { motion, collider: solid, trigger, has_joint }), errors)
    }

    /// `None` for a compound, whose shapes are on nodes below it.
    fn collider(
        &self,
        lists: &Lists<'a>,
        said: &Value,
        errors: &mut Vec<PhysicsError>,
    ) -> Read<Option<DeclaredCollider>> {
        let geometry = match said.get("geometry") {
            Some(geometry) => Some(self.geometry(lists, geometry)?),
            None => match index(said, "shape", "shape", lists.shapes.len())? {
                Some(shape) => Some(self.shape(lists, shape, false)?),
                None => None,
            },
        };
        let Some(geometry) = geometry else { return Ok(None) };
        let mut keep = |read: Read<_>| read.map_err(|error| errors.push(error)).ok().flatten();
        let surface = keep(surface(lists, said)).unwrap_or_default();
        let filter = filter(lists, said).map_err(|error| errors.push(error)).ok().flatten();
        Ok(Some(DeclaredCollider { geometry, surface, filter }))
    }

    fn geometry(&self, lists: &Lists<'a>, geometry: &Value) -> Read<Geometry> {
        let is_convex = boolean(geometry, "convexHull")?;
        let shape = index(geometry, "shape", "shape", lists.shapes.len())?;
        let node = index(geometry, "node", "node", self.nodes)?;
        // An earlier draft names a mesh.
        let mesh = index(geometry, "mesh", "mesh", self.meshes)?;
        match (shape, node, mesh) {
            (Some(shape), None, None) => self.shape(lists, shape, is_convex),
            (None, Some(node), None) => Ok(Geometry::Node { node, is_convex }),
            (None, None, Some(mesh)) => Ok(Geometry::Mesh { mesh, is_convex }),
            (None, None, None) => Err(PhysicsError::Geometry("neither")),
            _ => Err(PhysicsError::Geometry("several of them")),
        }
    }

    fn shape(&self, lists: &Lists<'a>, shape: usize, is_convex: bool) -> Read<Geometry> {
        let shape = lists.shapes.get(shape).unwrap_or(&Value::Null);
        let kind = shape.get("type").and_then(Value::as_str).unwrap_or_default();
        let of = shape.get(kind).unwrap_or(&Value::Null);
        let Defaults { capsule_height, cylinder_height, radius } = lists.defaults;
        let radii = || -> Read<_> {
            let both = size(of, "radius", Some(radius))?;
            let (top, bottom) = (radius_at(of, "radiusTop")?, radius_at(of, "radiusBottom")?);
            let (top, bottom) = (top.unwrap_or(both), bottom.unwrap_or(both));
            if top <= 0.0 && bottom <= 0.0 {
                let (key, expected) = ("radiusTop", "positive where \"radiusBottom\" is 0");
                return Err(PhysicsError::WrongValue { key, value: top.to_string(), expected });
            }
            Ok((top, bottom))
        };
        let implicit = match kind {
            "box" => {
                let size = numbers::<3>(of, "size")?.unwrap_or([1.0; 3]);
                if !size.iter().all(|size| *size > 0.0) {
                    return Err(wrong(of, "size", "three positive numbers"));
                }
                ImplicitShape::Cuboid { size }
            }
            "sphere" => ImplicitShape::Ball { radius: size(of, "radius", Some(0.5))? },
            "capsule" => {
                let (radius_top, radius_bottom) = radii()?;
                let height = size(of, "height", Some(capsule_height))?;
                ImplicitShape::Capsule { height, radius_top, radius_bottom }
            }
            "cylinder" => {
                let (radius_top, radius_bottom) = radii()?;
                let height = size(of, "height", Some(cylinder_height))?;
                ImplicitShape::Cylinder { height, radius_top, radius_bottom }
            }
            "plane" => {
                let extent = |key| of.get(key).map(|_| size(of, key, None)).transpose();
                let is_double_sided = boolean(of, "doubleSided")?;
                let (size_x, size_z) = (extent("sizeX")?, extent("sizeZ")?);
                ImplicitShape::Plane { size_x, size_z, is_double_sided }
            }
            "convex" | "trimesh" => {
                let mesh = index(of, "mesh", "mesh", self.meshes)?;
                let mesh = mesh.ok_or_else(|| wrong(of, "mesh", "the index of a mesh"))?;
                return Ok(Geometry::Mesh { mesh, is_convex: is_convex || kind == "convex" });
            }
            _ => return Err(wrong(shape, "type", "the kind of a shape that this reader knows")),
        };
        Ok(Geometry::Shape(implicit))
    }
}

/// The material that a collider names.
fn surface(lists: &Lists<'_>, collider: &Value) -> Read<Option<SurfaceProperties>> {
    let found = index(collider, "physicsMaterial", "physics material", lists.materials.len())?;
    let Some(material) = found.and_then(|index| lists.materials.get(index)) else {
        return Ok(None);
    };
    let number = |key: &'static str| {
        let value = material.get(key);
        let read = |value| coefficient(value).ok_or_else(|| wrong(material, key, FROM_ZERO));
        value.map(read).transpose()
    };
    let rule = |key: &'static str| {
        let expected = "\"average\", \"minimum\", \"maximum\" or \"multiply\"";
        let read = |value| combine_rule(value).ok_or_else(|| wrong(material, key, expected));
        material.get(key).map(read).transpose()
    };
    Ok(Some(SurfaceProperties {
        friction: Some(number("dynamicFriction")?.unwrap_or(DEFAULT_FRICTION)),
        static_friction: Some(number("staticFriction")?.unwrap_or(DEFAULT_FRICTION)),
        friction_combine_rule: rule("frictionCombine")?,
        restitution: Some(number("restitution")?.unwrap_or(0.0)),
        restitution_combine_rule: rule("restitutionCombine")?,
        ..SurfaceProperties::default()
    }))
}

/// Both extensions'.
const DEFAULT_FRICTION: f32 = 0.6;

const FROM_ZERO: &str = "a number from 0";

/// The filter that a collider names.
fn filter(lists: &Lists<'_>, collider: &Value) -> Read<Option<CollisionFilter>> {
    let found = index(collider, "collisionFilter", "collision filter", lists.filters.len())?;
    let Some(filter) = found.and_then(|index| lists.filters.get(index)) else { return Ok(None) };
    let names = |key: &'static str| -> Read<Option<Vec<String>>> {
        let Some(list) = filter.get(key) else { return Ok(None) };
        let name = |name: &Value| name.as_str().map(str::to_owned);
        let names = list.as_array().and_then(|list| list.iter().map(name).collect());
        names.ok_or_else(|| wrong(filter, key, "a list of names")).map(Some)
    };
    let (systems, mut collide_with) = (names("collisionSystems")?, names("collideWithSystems")?);
    let not_collide_with = names("notCollideWithSystems")?.unwrap_or_default();
    // By OMI's extension an empty list is none.
    if collide_with.as_ref().is_some_and(Vec::is_empty) {
        collide_with = None;
    }
    if collide_with.is_some() && !not_collide_with.is_empty() {
        return Err(PhysicsError::BothFilters);
    }
    let systems = systems.unwrap_or_default();
    Ok(Some(CollisionFilter { systems, collide_with, not_collide_with }))
}

fn khr_motion(motion: &Value, errors: &mut Vec<PhysicsError>) -> BodyMotion {
    let mut keep = Kept { errors };
    let is_kinematic = keep.value(boolean(motion, "isKinematic")).unwrap_or_default();
    let body = if is_kinematic { Body::Kinematic } else { Body::Dynamic };
    body_motion(motion, body, &mut keep)
}

fn omi_motion(motion: &Value, errors: &mut Vec<PhysicsError>) -> BodyMotion {
    let mut keep = Kept { errors };
    let body = match motion.get("type").and_then(Value::as_str) {
        Some("static") => Ok(Body::Fixed),
        Some("kinematic") => Ok(Body::Kinematic),
        Some("dynamic") => Ok(Body::Dynamic),
        _ => Err(wrong(motion, "type", "\"static\", \"kinematic\" or \"dynamic\"")),
    };
    let body = keep.value(body).unwrap_or(Body::Dynamic);
    let mut read = body_motion(motion, body, &mut keep);
    // No inertia is the one of the colliders there, and no mass one kilogram.
    read.inertia = read.inertia.filter(|moments| *moments != [0.0; 3]);
    read.mass = Some(read.mass.unwrap_or(1.0));
    read
}

/// Errors that leave the rest as it is.
struct Kept<'a> {
    errors: &'a mut Vec<PhysicsError>,
}

impl Kept<'_> {
    fn value<T>(&mut self, read: Read<T>) -> Option<T> {
        read.map_err(|error| self.errors.push(error)).ok()
    }
}

fn body_motion(motion: &Value, body: Body, keep: &mut Kept<'_>) -> BodyMotion {
    let not_negative = |key: &'static str| match motion.get(key) {
        None => Ok(None),
        Some(value) => coefficient(value).map(Some).ok_or_else(|| wrong(motion, key, FROM_ZERO)),
    };
    let vector = |key: &'static str| numbers::<3>(motion, key);
    let moments = vector("inertiaDiagonal").and_then(|moments| match moments {
        Some(moments) if moments.iter().any(|moment| *moment < 0.0) => {
            Err(wrong(motion, "inertiaDiagonal", "three numbers from 0"))
        }
        moments => Ok(moments),
    });
    let rotation = numbers::<4>(motion, "inertiaOrientation").and_then(|rotation| {
        let Some(rotation) = rotation else { return Ok(NO_ROTATION) };
        let length = rotation.iter().map(|x| x * x).sum::<f32>().sqrt();
        let unit = rotation.map(|x| x / length);
        let is_usable = length > 0.0 && unit.iter().all(|x| x.is_finite());
        is_usable
            .then_some(unit)
            .ok_or_else(|| wrong(motion, "inertiaOrientation", "a unit quaternion"))
    });
    let gravity_factor = motion.get("gravityFactor").map_or(Ok(1.0), |value| {
        number(value).ok_or_else(|| wrong(motion, "gravityFactor", "a number"))
    });
    BodyMotion {
        body,
        mass: keep.value(not_negative("mass")).flatten(),
        centre: keep.value(vector("centerOfMass")).flatten(),
        inertia: keep.value(moments).flatten(),
        inertia_rotation: keep.value(rotation).unwrap_or(NO_ROTATION),
        linear_velocity: keep.value(vector("linearVelocity")).flatten().unwrap_or_default(),
        angular_velocity: keep.value(vector("angularVelocity")).flatten().unwrap_or_default(),
        gravity_factor: keep.value(gravity_factor).unwrap_or(1.0),
    }
}

const NO_ROTATION: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

fn wrong(of: &Value, key: &'static str, expected: &'static str) -> PhysicsError {
    let value = of.get(key).map_or_else(|| "not there".into(), Value::to_string);
    let value = match value.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}…", value.get(..end).unwrap_or_default()),
        None => value,
    };
    PhysicsError::WrongValue { key, value, expected }
}

/// A message shows this much of a value, in characters.
const LONGEST_VALUE: usize = 80;

/// A number of a list that has so many; `None` where there is none, or -1, which is none by OMI's
/// extensions.
fn index(of: &Value, key: &str, what: &'static str, count: usize) -> Read<Option<usize>> {
    let Some(value) = of.get(key).filter(|value| value.as_i64() != Some(-1)) else {
        return Ok(None);
    };
    let index = value.as_u64().and_then(|index| usize::try_from(index).ok());
    match index.filter(|index| *index < count) {
        Some(index) => Ok(Some(index)),
        None => Err(PhysicsError::NotThere { what, index: value.to_string(), count }),
    }
}

fn boolean(of: &Value, key: &'static str) -> Read<bool> {
    let Some(value) = of.get(key) else { return Ok(false) };
    value.as_bool().ok_or_else(|| wrong(of, key, "true or false"))
}

fn number(value: &Value) -> Option<f32> {
    value.as_f64().map(|x| x as f32).filter(|x| x.is_finite())
}

fn numbers<const N: usize>(of: &Value, key: &'static str) -> Read<Option<[f32; N]>> {
    let Some(value) = of.get(key) else { return Ok(None) };
    let list =
        value.as_array().and_then(|list| list.iter().map(number).collect::<Option<Vec<_>>>());
    let array = list.and_then(|list| list.try_into().ok());
    array.map(Some).ok_or_else(|| wrong(of, key, "a list of as many numbers as it has axes"))
}

/// A positive length.
fn size(of: &Value, key: &'static str, default: Option<f32>) -> Read<f32> {
    let read = of.get(key).map_or(default, number);
    read.filter(|size| *size > 0.0).ok_or_else(|| wrong(of, key, "a positive number"))
}

/// A radius that may be 0.
fn radius_at(of: &Value, key: &'static str) -> Read<Option<f32>> {
    let Some(value) = of.get(key) else { return Ok(None) };
    coefficient(value).map(Some).ok_or_else(|| wrong(of, key, FROM_ZERO))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn object(value: &Value) -> &Map<String, Value> {
        value.as_object().expect("an object")
    }

    /// What a node says in a document with two nodes and one mesh.
    fn read(document: &Value, node: &Value) -> (Option<NodePhysics>, Vec<PhysicsError>) {
        PhysicsExtensions::new(object(document), 2, 1).of_node(object(node))
    }

    fn geometry_of(shape: Value) -> Result<Geometry, PhysicsError> {
        let document = json!({"KHR_implicit_shapes": {"shapes": [shape.clone()]},
            "OMI_physics_shape": {"shapes": [shape]}});
        let khr = json!({"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}});
        let omi = json!({"OMI_physics_body": {"collider": {"shape": 0}}});
        let [khr, omi] = [khr, omi].map(|node| {
            let (physics, mut errors) = read(&document, &node);
            match physics.and_then(|physics| physics.collider) {
                Some(collider) => Ok(collider.geometry),
                None => Err(errors.remove(0)),
            }
        });
        assert_eq!(khr, omi);
        khr
    }

    #[test]
    fn every_shape_is_read_alike_by_both_extensions() {
        use ImplicitShape::{Ball, Capsule, Cuboid, Cylinder, Plane};
        for (shape, expected) in [
            (
                json!({"type": "box", "box": {"size": [1, 2, 3.5]}}),
                Cuboid { size: [1.0, 2.0, 3.5] },
            ),
            (json!({"type": "box"}), Cuboid { size: [1.0; 3] }),
            (json!({"type": "sphere", "sphere": {"radius": 2}}), Ball { radius: 2.0 }),
            (json!({"type": "sphere"}), Ball { radius: 0.5 }),
            (
                json!({"type": "capsule", "capsule":
                    {"height": 1, "radiusTop": 0.25, "radiusBottom": 0}}),
                Capsule { height: 1.0, radius_top: 0.25, radius_bottom: 0.0 },
            ),
            (
                json!({"type": "capsule", "capsule": {"height": 0.5, "radius": 0.05}}),
                Capsule { height: 0.5, radius_top: 0.05, radius_bottom: 0.05 },
            ),
            (
                json!({"type": "cylinder", "cylinder":
                    {"height": 2, "radiusTop": 0, "radiusBottom": 1}}),
                Cylinder { height: 2.0, radius_top: 0.0, radius_bottom: 1.0 },
            ),
            (
                json!({"type": "plane", "plane": {"sizeX": 4, "doubleSided": true}}),
                Plane { size_x: Some(4.0), size_z: None, is_double_sided: true },
            ),
        ] {
            assert_eq!(geometry_of(shape), Ok(Geometry::Shape(expected)));
        }
        for (kind, is_convex) in [("convex", true), ("trimesh", false)] {
            let shape = json!({"type": kind, kind: {"mesh": 0}});
            assert_eq!(geometry_of(shape), Ok(Geometry::Mesh { mesh: 0, is_convex }));
        }
    }

    #[test]
    fn a_measure_that_is_left_out_has_the_default_of_its_extension() {
        let document = json!({"KHR_implicit_shapes": {"shapes": [{"type": "cylinder"}]},
            "OMI_physics_shape": {"shapes": [{"type": "cylinder"}]}});
        let khr = json!({"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}});
        let omi = json!({"OMI_physics_body": {"collider": {"shape": 0}}});
        for (node, height, radius) in [(khr, 0.5, 0.25), (omi, 2.0, 0.5)] {
            let collider = read(&document, &node).0.and_then(|of| of.collider).expect("one");
            let (radius_top, radius_bottom) = (radius, radius);
            let expected = ImplicitShape::Cylinder { height, radius_top, radius_bottom };
            assert_eq!(collider.geometry, Geometry::Shape(expected));
        }
    }

    #[test]
    fn a_shape_that_is_none_is_an_error_that_names_the_value() {
        for (shape, text) in [
            (json!({"type": "box", "box": {"size": [1, 0, 1]}}), "\"size\" is [1,0,1]"),
            (json!({"type": "box", "box": {"size": [1, 1]}}), "\"size\" is [1,1]"),
            (json!({"type": "sphere", "sphere": {"radius": -1}}), "\"radius\" is -1"),
            (json!({"type": "sphere", "sphere": {"radius": 1e300}}), "\"radius\" is 1e+300"),
            (json!({"type": "capsule", "capsule": {"height": 0}}), "\"height\" is 0"),
            (
                json!({"type": "cylinder", "cylinder": {"radiusTop": 0, "radiusBottom": 0}}),
                "\"radiusTop\" is 0",
            ),
            (json!({"type": "plane", "plane": {"sizeX": 0}}), "\"sizeX\" is 0"),
            (json!({"type": "torus"}), "\"type\" is \"torus\""),
            (json!({}), "\"type\" is not there"),
            (json!(null), "\"type\" is not there"),
            (json!({"type": "convex"}), "\"mesh\" is not there"),
            (json!({"type": "convex", "convex": {"mesh": 1}}), "mesh 1 does not exist"),
            (json!({"type": "x".repeat(1000)}), "xxx…"),
        ] {
            let error = geometry_of(shape.clone()).expect_err("an error").to_string();
            assert!(error.contains(text) && error.len() < 300, "{shape}: {error}");
        }
    }

    #[test]
    fn meshes_are_named_by_nodes_and_may_be_convex() {
        for (geometry, expected) in [
            (json!({"node": 1}), Some(Geometry::Node { node: 1, is_convex: false })),
            (
                json!({"node": 0, "convexHull": true}),
                Some(Geometry::Node { node: 0, is_convex: true }),
            ),
            (json!({"mesh": 0}), Some(Geometry::Mesh { mesh: 0, is_convex: false })),
            (json!({"node": 2}), None),
            (json!({"node": -2}), None),
            (json!({"node": 4_294_967_296_u64}), None),
            (json!({"node": "0"}), None),
            (json!({"node": 0, "mesh": 0}), None),
            (json!({}), None),
            (json!({"node": 0, "convexHull": 1}), None),
        ] {
            let node = json!({"KHR_physics_rigid_bodies": {"collider": {"geometry": geometry}}});
            let (physics, errors) = read(&json!({}), &node);
            assert_eq!(errors.len(), usize::from(expected.is_none()), "{geometry}");
            let collider = physics.expect("something").collider;
            assert_eq!(collider.map(|collider| collider.geometry), expected, "{geometry}");
        }
    }

    #[test]
    fn materials_and_filters_are_read_and_wrong_ones_cost_no_collider() {
        let document = json!({
            "KHR_implicit_shapes": {"shapes": [{"type": "box"}]},
            "KHR_physics_rigid_bodies": {
                "physicsMaterials": [
                    {"staticFriction": 0.9, "dynamicFriction": 0.5, "restitution": 0.25,
                        "frictionCombine": "minimum", "restitutionCombine": "maximum"},
                    {},
                    {"restitution": -1},
                ],
                "collisionFilters": [
                    {"collisionSystems": ["a"], "collideWithSystems": ["b", "c"]},
                    {"notCollideWithSystems": ["a"]},
                    {"collideWithSystems": ["a"], "notCollideWithSystems": ["b"]},
                    {"collisionSystems": [1]},
                ],
            },
        });
        let read = |material: usize, filter: usize| {
            let node = json!({"KHR_physics_rigid_bodies": {"collider":
                {"geometry": {"shape": 0}, "physicsMaterial": material, "collisionFilter": filter}}});
            let (physics, errors) = read(&document, &node);
            (physics.and_then(|physics| physics.collider).expect("a collider"), errors.len())
        };
        let (collider, errors) = read(0, 0);
        let surface = SurfaceProperties {
            friction: Some(0.5),
            static_friction: Some(0.9),
            friction_combine_rule: Some(super::super::CombineRule::Min),
            restitution: Some(0.25),
            restitution_combine_rule: Some(super::super::CombineRule::Max),
            ..SurfaceProperties::default()
        };
        assert_eq!((collider.surface, errors), (surface, 0));
        let (systems, collide_with) = (vec!["a".into()], Some(vec!["b".into(), "c".into()]));
        let filter = CollisionFilter { systems, collide_with, not_collide_with: Vec::new() };
        assert_eq!(collider.filter, Some(filter));
        let (collider, errors) = read(1, 1);
        assert_eq!((collider.surface.friction, errors), (Some(0.6), 0));
        assert_eq!(collider.filter.map(|of| of.not_collide_with), Some(vec!["a".to_owned()]));
        for (material, filter) in [(2, 2), (3, 3), (9, 9)] {
            let (collider, errors) = read(material, filter);
            assert_eq!(
                (collider.surface, collider.filter, errors),
                (SurfaceProperties::default(), None, 2)
            );
        }
    }

    #[test]
    fn motion_is_read_and_what_is_wrong_in_it_is_left_out_alone() {
        let read = |key: &str, motion: Value| {
            let (physics, errors) = read(&json!({}), &json!({key: {"motion": motion}}));
            (physics.and_then(|physics| physics.motion).expect("motion"), errors.len())
        };
        let khr = "KHR_physics_rigid_bodies";
        let (motion, errors) = read(
            khr,
            json!({"mass": 2, "centerOfMass": [0, 1, 0], "inertiaDiagonal": [1, 0, 2],
                "inertiaOrientation": [0, 0, 0, 2], "linearVelocity": [1, 0, 0],
                "angularVelocity": [0, 0, 3], "gravityFactor": -0.5}),
        );
        let expected = BodyMotion {
            body: Body::Dynamic,
            mass: Some(2.0),
            centre: Some([0.0, 1.0, 0.0]),
            inertia: Some([1.0, 0.0, 2.0]),
            inertia_rotation: NO_ROTATION,
            linear_velocity: [1.0, 0.0, 0.0],
            angular_velocity: [0.0, 0.0, 3.0],
            gravity_factor: -0.5,
        };
        assert_eq!((motion, errors), (expected, 0));
        let (motion, errors) = read(khr, json!({"isKinematic": true}));
        assert_eq!((motion.body, motion.mass, errors), (Body::Kinematic, None, 0));
        let (motion, errors) = read(
            khr,
            json!({"mass": -1, "centerOfMass": 3, "inertiaDiagonal": [-1, 0, 0],
                "inertiaOrientation": [0, 0, 0, 0], "gravityFactor": "none", "isKinematic": 1,
                "linearVelocity": [1, 2, 3]}),
        );
        assert_eq!((motion.linear_velocity, errors), ([1.0, 2.0, 3.0], 6));
        let omi = "OMI_physics_body";
        for (kind, body) in
            [("static", Body::Fixed), ("kinematic", Body::Kinematic), ("dynamic", Body::Dynamic)]
        {
            let (motion, errors) = read(omi, json!({"type": kind, "inertiaDiagonal": [0, 0, 0]}));
            let found = (motion.body, motion.mass, motion.inertia, errors);
            assert_eq!(found, (body, Some(1.0), None, 0));
        }
        assert_eq!(read(omi, json!({})).1, 1);
    }

    #[test]
    fn what_is_read_can_be_written_and_read_again() {
        let node = json!({"KHR_physics_rigid_bodies": {"motion": {"mass": 0.1},
            "trigger": {"geometry": {"node": 1}}, "joint": {}}});
        let (physics, errors) = read(&json!({}), &node);
        let physics = physics.expect("something");
        assert!(errors.is_empty() && physics.has_joint);
        let text = serde_json::to_string(&physics).expect("a text");
        assert_eq!(serde_json::from_str::<NodePhysics>(&text).expect("the same"), physics);
    }

    #[test]
    fn a_node_without_the_extensions_says_nothing() {
        assert_eq!(read(&json!({}), &json!({})), (None, Vec::new()));
        for node in [json!({"KHR_physics_rigid_bodies": null}), json!({"OMI_physics_body": []})] {
            assert_eq!(read(&json!({}), &node), (Some(NodePhysics::default()), Vec::new()));
        }
    }
}
