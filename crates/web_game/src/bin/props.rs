//! Bakes the game's props: `props ASSETS FILE.hullscene`. The bundled models, each stretched by a
//! little more, so that no two have the same hulls.

#[cfg(not(target_family = "wasm"))]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    use std::fs::write;
    use std::path::Path;

    use hullwright::hulls_format::{BakedMesh, HullScene, HullsFile};
    use hullwright::{Control, Method, Parameters, Preset, TriangleMesh, mass_properties};

    const MODELS: [&str; 10] =
        ["mug", "table", "chair", "lamp", "bowl", "plus", "torus", "gear", "l_prism", "u_prism"];
    const PROPS: usize = 300;

    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [assets, file] = arguments.as_slice() else { return Err("props ASSETS FILE".into()) };
    let parameters = Parameters::default().with_preset(Preset::Fast);
    let mut baked = Vec::new();
    for number in 0..PROPS {
        let name = MODELS[number % MODELS.len()];
        let read = hullwright_formats::read_mesh(Path::new(assets).join(format!("{name}.glb")))?;
        let stretch = 1.0 + 0.02 * (number / MODELS.len()) as f64;
        let positions = read.mesh.positions.iter().map(|p| [p[0] * stretch, p[1], p[2]]);
        let mesh = TriangleMesh::new(positions.collect(), read.mesh.triangles);
        let made = hullwright::decompose(&mesh, &parameters, &Control::new())?;
        let mass = mass_properties(&mesh, &made.hulls, 1.0)?;
        let hulls = HullsFile::new(number.to_string(), &made).with_mass_properties(mass);
        baked.push(BakedMesh::new(&mesh, Method::from(parameters.clone()), hulls));
    }
    write(file, HullScene::new("props", baked).to_bytes()?)?;
    Ok(())
}

#[cfg(target_family = "wasm")]
fn main() {}
