//! Draws a mesh, its hulls, and the hulls moved apart:
//! `cargo run --release --example picture --features io -- MESH OUT.png`.

use std::error::Error;

use hullwright::io::read_mesh;
use hullwright::render::{Panel, render};
use hullwright::{Control, Parameters, decompose};

/// Size of the picture in pixels: three square panels.
const SIZE: (usize, usize) = (1500, 500);

/// How far hulls move away from the centre in the last panel, as a share of their distance.
const EXPLOSION: f64 = 0.5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(mesh), Some(output)) = (arguments.next(), arguments.next()) else {
        return Err("usage: picture MESH OUT.png".into());
    };
    let file = read_mesh(&mesh)?;
    let parameters = Parameters::default();
    let result = decompose(&file, &parameters, &Control::new())?;
    let panels = [
        Panel::mesh(&file),
        Panel::hulls(&result.hulls),
        Panel::hulls(&result.hulls).exploded(EXPLOSION),
    ];
    render(&panels, SIZE.0, SIZE.1)?.write_png(&output)?;
    println!("wrote {output}: {} hulls", result.hulls.len());
    Ok(())
}
