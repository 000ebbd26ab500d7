//! Parry's distance from a point to a small convex polyhedron, beside the right one: plain Parry, nothing
//! of this project. `cargo run --package hullwright_lab --example parry_small_shapes`

use parry3d::math::{Pose, Vector};
use parry3d::query::{PointQuery, contact};
use parry3d::shape::{Ball, ConvexPolyhedron, Cuboid};

/// A plate of 3 cm by 3 mm by 3 cm, times a factor.
fn plate(factor: f32) -> ConvexPolyhedron {
    let half = Vector::new(0.015, 0.0015, 0.015) * factor;
    let (points, triangles) = Cuboid::new(half).to_trimesh();
    ConvexPolyhedron::from_convex_mesh(points, &triangles).expect("a box is convex")
}

fn main() {
    println!(
        "points 1 mm (times the factor) in front of the larger faces of a plate, and balls of 8 mm there"
    );
    println!("factor  points  called inside  off by 10 %  worst distance  balls off by 1 mm");
    for factor in [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0] {
        let plate = plate(factor);
        let (mut count, mut inside, mut off, mut balls) = (0, 0, 0, 0);
        let mut worst = 1.0_f32;
        for (x, z) in (-14..=14).flat_map(|x| (-14..=14).map(move |z| (x, z))) {
            let above = Vector::new(0.001 * x as f32, 0.0025, 0.001 * z as f32) * factor;
            // The right answer: 1 mm, times the factor.
            let right = 0.001 * factor;
            let projection = plate.project_local_point(above, false);
            let found = projection.point.distance(above) / right;
            count += 1;
            inside += usize::from(projection.is_inside);
            off += usize::from((found - 1.0).abs() > 0.1);
            worst = if (found - 1.0).abs() > (worst - 1.0).abs() { found } else { worst };
            let ball = Ball::new(0.008 * factor);
            let found =
                contact(&Pose::IDENTITY, &plate, &Pose::from_translation(above), &ball, 0.0);
            let is_right = matches!(found, Ok(Some(contact))
                if (contact.dist / factor + 0.007).abs() < 0.001 && contact.normal1.y > 0.98);
            balls += usize::from(!is_right);
        }
        println!("{factor:6}  {count:6}  {inside:13}  {off:11}  {worst:12.2} ×  {balls:17}");
    }
}
