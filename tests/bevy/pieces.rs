//! Pieces of colliders that an artist made belong to their mesh and move with its body, beside it
//! or below it.

use bevy::prelude::*;
use bevy_hullwright::ColliderPieces;
use bevy_hullwright::prelude::*;
use serde_json::{Value, json};

use crate::app::*;
use crate::artists::{app_with_file, file_of, node};
use crate::engine::*;

fn chair(extras: Value) -> Value {
    json!({"name": "chair", "mesh": 0, "translation": [5, 1, 0], "extras": extras})
}

fn piece(name: &str, at: [f32; 3]) -> Value {
    json!({"name": name, "mesh": 0, "translation": at})
}

const DYNAMIC: &str = "dynamic";

/// A chair that is a body with a piece, which is below it or beside it, at the same place in the
/// world.
fn app_with_chair(is_below: bool) -> (App, tempfile::TempDir) {
    let mut chair = chair(json!({"collider": "convex_decomposition", "body": DYNAMIC}));
    let (place, roots) = match is_below {
        true => ([0.5, 0.0, 0.0], vec![0]),
        false => ([5.5, 1.0, 0.0], vec![0, 1]),
    };
    if is_below {
        chair["children"] = json!([1]);
    }
    let file = file_of(vec![chair, piece("UCX_chair_01", place)], roots);
    app_with_file(file, ConvexDecompositionHierarchy::new(automatic()))
}

#[test]
fn a_piece_beside_or_below_its_mesh_is_its_only_collider_and_moves_with_it() {
    let mut masses = Vec::new();
    for is_below in [true, false] {
        let (mut app, _directory) = app_with_chair(is_below);
        let [chair, piece] = ["chair", "UCX_chair_01"].map(|name| node(&mut app, name));
        assert_eq!(app.get::<ColliderPieceOf>(piece), Some(&ColliderPieceOf(chair)));
        let pieces: Vec<Entity> = app.get::<ColliderPieces>(chair).unwrap().iter().collect();
        assert_eq!(pieces, [piece]);
        assert!(!has_collider(&app, chair) && has_collider(&app, piece));
        let at = |app: &App| app.get::<GlobalTransform>(piece).unwrap().translation();
        let before = at(&app);
        assert!((before - translation(&app, chair)).distance(Vec3::X * 0.5) < 1e-3);
        update_times(&mut app, 30);
        let moved = at(&app) - before;
        assert!(moved.y < -0.5 && moved.with_y(0.0).length() < 1e-3, "{moved}");
        assert!((at(&app) - translation(&app, chair)).distance(Vec3::X * 0.5) < 1e-3);
        masses.push(mass_of_whole(&mut app, chair).0);
    }
    assert_eq!(masses[0], masses[1]);
}

#[test]
fn copies_have_their_own_pieces() {
    let body = || json!({"collider": "convex_decomposition", "body": DYNAMIC});
    let mut copy = chair(body());
    copy["name"] = "chair.001".into();
    copy["translation"] = json!([20, 1, 0]);
    let pieces = [piece("UCX_chair_01.001", [20., 1., 0.]), piece("UCX_chair_01", [5., 1., 0.])];
    let [first, second] = pieces;
    let file = file_of(vec![chair(body()), copy, first, second], vec![0, 1, 2, 3]);
    let (mut app, _directory) = app_with_file(file, ConvexDecompositionHierarchy::default());
    for (whole, piece) in [("chair", "UCX_chair_01"), ("chair.001", "UCX_chair_01.001")] {
        let [whole, piece] = [whole, piece].map(|name| node(&mut app, name));
        assert_eq!(app.get::<ColliderPieceOf>(piece), Some(&ColliderPieceOf(whole)));
    }
}

#[test]
fn a_piece_is_free_again_when_names_are_not_followed() {
    let (mut app, _directory) = app_with_chair(false);
    let mut scenes = app.world_mut().query::<&mut ConvexDecompositionHierarchy>();
    scenes.single_mut(app.world_mut()).unwrap().follows_artists = false;
    update_times(&mut app, 3);
    let [chair, piece] = ["chair", "UCX_chair_01"].map(|name| node(&mut app, name));
    assert!(app.get::<ColliderPieceOf>(piece).is_none());
    update_until_finished(&mut app, &[chair, piece]);
    assert!(has_collider(&app, chair) && has_collider(&app, piece));
}

#[test]
fn a_body_alone_is_told_what_is_missing() {
    Log::install();
    let mut chair = chair(json!({"body": DYNAMIC}));
    chair["name"] = "a body alone".into();
    let (_app, _directory) = app_with_file(
        file_of(vec![chair, piece("other", [0.0; 3])], vec![0, 1]),
        ConvexDecompositionHierarchy::default(),
    );
    let mut lines = Log::lines_with("a body alone");
    lines.retain(|line| line.contains("extras"));
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains(r#"add "collider": "convex_decomposition""#), "{lines:?}");
}
