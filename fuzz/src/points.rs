//! Points that are hard: equal, nearly equal, in planes, on grids, at the ends of the range.

use arbitrary::{Result, Unstructured};

/// Coordinates of one set are of one kind, since mixed kinds make the finer one invisible.
#[derive(Clone, Copy)]
enum Kind {
    /// On a grid of four.
    Lattice,
    /// The same, moved by next to nothing.
    NearLattice,
    /// Any finite or not finite single-precision number.
    Bits,
    /// Even numbers of 16 bits.
    Fine,
    /// On a sphere, or on circles around an axis.
    Round,
}

/// Up to so many points.
pub fn points(bytes: &mut Unstructured<'_>, most: usize) -> Result<Vec<[f64; 3]>> {
    let kind =
        *bytes.choose(&[Kind::Lattice, Kind::NearLattice, Kind::Bits, Kind::Fine, Kind::Round])?;
    // Of thin and flat sets, and of sets far from the origin.
    let thin = *bytes.choose(&[1.0, 1.0, 1e-3, 1e-6, 3e-7, 1e-12, 0.0])?;
    let scale = *bytes.choose(&[1.0, 1.0, 1e-18, 1e-9, 1e9, 1e18])?;
    let offset = *bytes.choose(&[0.0, 0.0, 1.0, 1e3, 1e6])?;
    let count = bytes.int_in_range(1..=most)?;
    let mut points = Vec::with_capacity(count);
    for _ in 0..count {
        if bytes.is_empty() {
            break;
        }
        let [x, y, z] = match kind {
            Kind::Round => round(bytes)?,
            kind => [coordinate(bytes, kind)?, coordinate(bytes, kind)?, coordinate(bytes, kind)?],
        };
        let placed = [x, y, z * thin].map(|x| (x + offset) * scale);
        // As files and engines hold them.
        points.push(placed.map(|x| f64::from(x as f32)));
    }
    Ok(points)
}

fn coordinate(bytes: &mut Unstructured<'_>, kind: Kind) -> Result<f64> {
    const NOTHINGS: [f64; 4] = [0.0, 1e-9, -3e-7, 1e-6];
    Ok(match kind {
        Kind::Lattice | Kind::Round => f64::from(bytes.arbitrary::<u8>()? % 4),
        Kind::NearLattice => {
            let byte = bytes.arbitrary::<u8>()?;
            f64::from(byte % 4) + NOTHINGS[usize::from(byte >> 6)]
        }
        Kind::Bits => f64::from(f32::from_bits(bytes.arbitrary()?)),
        Kind::Fine => f64::from(bytes.arbitrary::<i16>()?) / 8192.0,
    })
}

fn round(bytes: &mut Unstructured<'_>) -> Result<[f64; 3]> {
    const STEPS: f64 = 16.0;
    let [azimuth, polar] = bytes.arbitrary::<[u8; 2]>()?;
    let azimuth = f64::from(azimuth % 32) / STEPS * std::f64::consts::PI;
    // Every other one on the rim of a prism.
    if polar & 128 != 0 {
        return Ok([azimuth.cos(), azimuth.sin(), f64::from(polar & 1)]);
    }
    let polar = f64::from(polar % 17) / STEPS * std::f64::consts::PI;
    Ok([polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()])
}
