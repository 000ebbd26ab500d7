//! Meshes that several of the tests use.

pub type Mesh = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A prism over a polygon in the x-y plane, counter-clockwise, given with the triangles that fill
/// it.
pub fn prism(outline: &[[f64; 2]], fill: &[[u32; 3]], height: f64) -> Mesh {
    let count = outline.len() as u32;
    let at = |z: f64| outline.iter().map(move |&[x, y]| [x, y, z]);
    let positions = at(0.0).chain(at(height)).collect();
    let top = fill.iter().map(|t| t.map(|v| v + count));
    let bottom = fill.iter().map(|&[a, b, c]| [a, c, b]);
    let walls = (0..count).flat_map(|a| {
        let b = (a + 1) % count;
        [[a, b, b + count], [a, b + count, a + count]]
    });
    (positions, top.chain(bottom).chain(walls).collect())
}

/// Two legs of length 2 and width 1, of height 1.
pub fn l_prism() -> Mesh {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    prism(&outline, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 1.0)
}
