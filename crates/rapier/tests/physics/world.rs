//! Meshes, their decompositions, and a world to drop them into.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use hullwright::{
    Control, Decomposition, Length, MassProperties, Parameters, TriangleMesh, decompose,
    mass_properties,
};
use hullwright_formats::read_mesh;
use rapier3d::prelude::*;

use crate::common::Mesh;

/// Water. Only how mass is distributed matters here.
pub const DENSITY: f64 = 1000.0;

/// A mesh and its decomposition.
pub struct Prop {
    pub mesh: TriangleMesh,
    pub decomposition: Decomposition,
}

impl Prop {
    /// One of the bundled models, decomposed once for all tests.
    pub fn model(name: &str) -> Arc<Self> {
        static MODELS: Mutex<BTreeMap<String, Arc<Prop>>> = Mutex::new(BTreeMap::new());
        let known = MODELS.lock().unwrap().get(name).cloned();
        known.unwrap_or_else(|| {
            let prop = Arc::new(Self::model_within(name, &Parameters::default()));
            MODELS.lock().unwrap().insert(name.into(), prop.clone());
            prop
        })
    }

    /// One of the bundled models, with a bound as a fraction of its diagonal.
    pub fn model_bounded(name: &str, share: f64) -> Self {
        Self::model_within(name, &Parameters::default().with_max_error(Length::share(share)))
    }

    fn model_within(name: &str, parameters: &Parameters) -> Self {
        let path = format!("{}/../../assets/{name}.glb", env!("CARGO_MANIFEST_DIR"));
        Self::new(read_mesh(path).unwrap().mesh, parameters)
    }

    pub fn mesh((positions, triangles): Mesh) -> Self {
        Self::new(TriangleMesh::new(positions, triangles), &Parameters::default())
    }

    fn new(mesh: TriangleMesh, parameters: &Parameters) -> Self {
        let decomposition = decompose(&mesh, parameters, &Control::new()).unwrap();
        Self { mesh, decomposition }
    }

    pub fn mass_properties(&self) -> MassProperties {
        mass_properties(&self.mesh, &self.decomposition.hulls, DENSITY).unwrap()
    }

    pub fn collider(&self) -> ColliderBuilder {
        self.scaled_collider([1.0; 3])
    }

    pub fn scaled_collider(&self, scale: [f32; 3]) -> ColliderBuilder {
        let hulls = &self.decomposition.hulls;
        hullwright_rapier::collider(hulls, &self.mass_properties(), scale).unwrap()
    }

    /// The least height of the mesh's own vertices once a body has a pose.
    pub fn lowest(&self, pose: &Pose, scale: [f32; 3]) -> f32 {
        let place = |p: &[f64; 3]| {
            pose.transform_point(Vector::from(p.map(|x| x as f32)) * Vector::from(scale)).y
        };
        self.mesh.positions.iter().map(place).fold(f32::INFINITY, f32::min)
    }
}

/// Rapier's world, with steps that suit bodies of a given size.
pub struct World(pub PhysicsWorld);

impl World {
    pub fn new(size: f32) -> Self {
        let mut world = PhysicsWorld::new();
        world.integration_parameters.length_unit = size;
        // Small bodies cross their own size sooner.
        world.integration_parameters.dt *= size.sqrt();
        Self(world)
    }

    /// Contacts are computed by the crate's dispatcher.
    pub fn dispatched(mut self) -> Self {
        self.0.narrow_phase =
            NarrowPhase::with_query_dispatcher(hullwright_rapier::ContactDispatcher);
        self
    }

    /// With a floor whose top is at height 0.
    pub fn with_floor(size: f32) -> Self {
        let mut world = Self::new(size);
        let floor = ColliderBuilder::cuboid(100.0 * size, size, 100.0 * size);
        world.fixed(floor.translation(Vector::new(0.0, -size, 0.0)));
        world
    }

    pub fn fixed(&mut self, collider: impl Into<Collider>) -> ColliderHandle {
        self.0.insert_collider(collider, None)
    }

    pub fn dynamic(
        &mut self,
        body: RigidBodyBuilder,
        collider: impl Into<Collider>,
    ) -> RigidBodyHandle {
        self.0.insert(body, collider).0
    }

    pub fn dynamic_at(&mut self, at: [f32; 3], collider: impl Into<Collider>) -> RigidBodyHandle {
        self.dynamic(RigidBodyBuilder::dynamic().translation(Vector::from(at)), collider)
    }

    pub fn run(&mut self, seconds: f32) {
        self.run_with(seconds, |_| {});
    }

    /// Calls back after each step.
    pub fn run_with(&mut self, seconds: f32, mut after: impl FnMut(&Self)) {
        let steps = (seconds / self.0.integration_parameters.dt).round() as usize;
        for _ in 0..steps {
            self.0.step();
            after(self);
        }
    }

    pub fn body(&self, handle: RigidBodyHandle) -> &RigidBody {
        &self.0.bodies[handle]
    }

    pub fn place(&self, handle: RigidBodyHandle) -> Vector {
        self.body(handle).translation()
    }

    /// How far a direction of the body's own has turned away from where it pointed, in degrees.
    pub fn tilt(&self, handle: RigidBodyHandle, direction: Vector) -> f32 {
        (self.body(handle).rotation() * direction).angle_between(direction).to_degrees()
    }

    pub fn is_at_rest(&self, handle: RigidBodyHandle) -> bool {
        let body = self.body(handle);
        let size = self.0.integration_parameters.length_unit;
        body.linvel().length() < 0.02 * size && body.angvel().length() < 0.05
    }
}
