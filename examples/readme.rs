//! The README's program for Rust and Rapier. It reads `mug.glb` from the current folder.

use hullwright::{Control, Length, Parameters, decompose, mass_properties};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = hullwright_formats::read_mesh("mug.glb")?;
    let parameters = Parameters::default().with_max_error(Length::share(0.02)).with_max_hulls(32);
    let made = decompose(&mesh, &parameters, &Control::new())?;
    // `hull.shape` has points and triangles. For Rapier: a compound with the mesh's mass at 500 kg/m³.
    let mass = mass_properties(&mesh, &made.hulls, 500.0)?;
    let collider = hullwright_rapier::collider(&made.hulls, &mass, [1.0; 3])?.build();
    println!("{} hulls, {:.2} kg", made.hulls.len(), collider.mass());
    Ok(())
}
