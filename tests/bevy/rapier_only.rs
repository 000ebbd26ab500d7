//! What only Rapier needs: Avian scales the colliders that it has by itself, whatever a frame's
//! budget.

use bevy::prelude::*;
use bevy_hullwright::prelude::*;

use crate::app::*;

#[test]
fn where_a_frame_has_no_time_for_all_those_that_have_waited_longest_follow_first() {
    let scale_delay = std::time::Duration::from_secs(3600);
    let settings = HullwrightSettings { scale_delay, ..sliced() };
    let (mut app, mesh) = with_mesh(app_with(settings), model("u_prism"));
    let all = [0; 4].map(|_| finish(&mut app, &mesh, ()));
    let height = |app: &App, entity: Entity| bounds(app, entity).1.y;
    let before = height(&app, all[0]);
    all.iter().for_each(|entity| set_scale(&mut app, *entity, Vec3::splat(2.0)));
    for frame in 1..=all.len() {
        // One that pulses on keeps none of the others from their turn.
        set_scale(&mut app, all[0], Vec3::splat(2.0 + 0.1 * frame as f32));
        app.update();
        let have_followed = all.iter().filter(|of| height(&app, **of) > 1.9 * before).count();
        assert_eq!(have_followed, frame);
    }
}
