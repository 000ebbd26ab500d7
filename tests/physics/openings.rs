//! A ball ends where a player expects it on what modellers leave open.

use rapier3d::prelude::*;

use crate::world::{Prop, World};

const RADIUS: f32 = 0.1;

/// A box without the side at its top (`true`) or bottom, drawn from outside, or from inside.
fn open_box(is_open_above: bool, is_lined: bool) -> Prop {
    let corners = |i: usize| [(i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2 & 1) as f64];
    let positions: Vec<[f64; 3]> = (0..8).map(corners).collect();
    let mut quads = vec![[0, 4, 6, 2], [1, 3, 7, 5], [0, 2, 3, 1], [4, 5, 7, 6]];
    quads.push(if is_open_above { [0, 1, 5, 4] } else { [2, 6, 7, 3] });
    if is_lined {
        quads.iter_mut().for_each(|quad| quad.reverse());
    }
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    Prop::mesh((positions, triangles.collect()))
}

/// Where a ball ends that falls onto the middle.
fn end_of_ball(prop: &Prop) -> f32 {
    let mut world = World::new(1.0);
    world.fixed(prop.collider());
    let ball = world.dynamic_at([0.52, 2.0, 0.49], ColliderBuilder::ball(RADIUS));
    world.run(3.0);
    world.place(ball).y
}

#[test]
fn a_ball_lies_on_a_crate_without_a_bottom() {
    let end = end_of_ball(&open_box(false, false));
    assert!((end - 1.0 - RADIUS).abs() < 0.01, "{end}");
}

#[test]
fn a_ball_lies_on_the_missing_side_of_a_crate_that_is_turned_over() {
    let end = end_of_ball(&open_box(true, false));
    assert!((end - 1.0 - RADIUS).abs() < 0.01, "{end}");
}

#[test]
fn a_ball_falls_into_a_bin_that_is_seen_from_within() {
    let end = end_of_ball(&open_box(true, true));
    assert!((end - RADIUS).abs() < 0.05, "{end}");
}
