//! The README's program for Rapier without Bevy. It reads `mug.glb` from the folder that it is run in.

use rapier3d::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = hullwright::io::read_mesh("mug.glb")?; // or a MeshView of your own positions and triangles
    // 500 kg per m³, if the mesh is in metres.
    let collider = hullwright::rapier::collider_from_mesh(&mesh, 500.0, &Default::default())?;
    let mut world = PhysicsWorld::new();
    let (body, _) = world.insert(RigidBodyBuilder::dynamic(), collider);
    world.step();
    println!("{:.3} kg", world.bodies[body].mass());
    Ok(())
}
