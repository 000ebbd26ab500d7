//! Who is in which cell: cells are made anew when one of those in them comes, changes or goes.

use bevy::ecs::system::SystemParam;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

use super::cells::{CellKey, CellPlace, InLevelCell, LevelCell, OfCell, OutOfCells, SharesCells};
use super::placement::{Placements, Stretch};
use super::work::{AttachedCollider, FailedRequest, MadeBefore, Unfinished, Work};
use crate::engine::Engine;
use crate::jobs::request::MeshPart;
use crate::tag::ConvexDecomposition;
use crate::tag::outcomes::Outcomes;

/// All cells.
#[derive(Resource, Default)]
pub(super) struct Cells(HashMap<CellKey, Entity>);

impl Cells {
    /// Puts an entity into its cell, which is made once no other has come for a while.
    pub(super) fn join(
        &mut self,
        commands: &mut Commands,
        unfinished: &mut Unfinished,
        (entity, place): (Entity, &CellPlace),
        parts: impl Iterator<Item = (Entity, MeshPart)>,
    ) {
        let cell = *self.0.entry(place.key).or_insert_with(|| {
            let transform = Transform::from_translation(place.origin);
            let name = Name::new("level cell");
            commands.spawn((OfCell(place.key), name, transform, ChildOf(place.key.root))).id()
        });
        let to_cell = place.to_cell();
        let parts = parts.map(|(entity, part)| {
            (entity, MeshPart { mesh: part.mesh, to_input: to_cell * part.to_input })
        });
        let joined = InLevelCell { cell, place: place.place, parts: parts.collect() };
        commands.entity(entity).try_insert(joined);
        unfinished.moves(cell, Stretch::default());
    }
}

/// A clone of a cell, as of all of a scene, is none.
pub(super) fn drop_clones(
    cells: Res<Cells>,
    new: Query<(Entity, &OfCell), Added<OfCell>>,
    mut commands: Commands,
) {
    for (entity, OfCell(key)) in &new {
        if cells.0.get(key) != Some(&entity) {
            commands.entity(entity).try_despawn();
        }
    }
}

/// A cell that nothing is in goes.
pub(super) fn on_empty(
    removed: On<Remove<LevelCell>>,
    mut cells: ResMut<Cells>,
    of_cells: Query<&OfCell>,
    mut work: Work,
    mut commands: Commands,
) {
    let cell = removed.entity;
    work.forget(cell);
    if let Ok(OfCell(key)) = of_cells.get(cell)
        && cells.0.get(key) == Some(&cell)
    {
        cells.0.remove(key);
    }
    commands.entity(cell).try_despawn();
}

/// A cell without what has left it is made at once.
pub(super) fn on_leave(
    removed: On<Remove<InLevelCell>>,
    members: Query<&InLevelCell>,
    attached: Query<(), (With<OfCell>, With<AttachedCollider>)>,
    mut work: Work,
) {
    if let Ok(InLevelCell { cell, .. }) = members.get(removed.entity)
        && attached.contains(*cell)
    {
        work.unfinished.marked.insert(*cell);
    }
}

type Moved = (Or<(Changed<Transform>, Changed<GlobalTransform>)>, With<InLevelCell>);

/// What moves within its scene leaves its cell. What has not come to rest yet may come to another.
pub(super) fn detect_leaving<E: Engine>(
    mut commands: Commands,
    mut work: Work,
    moved: Query<(Entity, &InLevelCell, &SharesCells), Moved>,
    shares: Query<Entity, Changed<SharesCells>>,
    mut shares_gone: RemovedComponents<SharesCells>,
    tagged: Query<(), With<ConvexDecomposition>>,
    placements: Placements<E>,
) {
    for (entity, joined, shares) in &moved {
        if placements.relative(entity, shares.root) == joined.place {
            continue;
        }
        if !work.unfinished.contains(entity) {
            commands.entity(entity).try_insert(OutOfCells);
        }
        work.unfinished.marked.insert(entity);
    }
    let changed = shares.iter().chain(shares_gone.read());
    work.unfinished.marked.extend(changed.filter(|entity| tagged.contains(*entity)));
}

/// What is known of cells and of those in them.
#[derive(SystemParam)]
pub(super) struct Members<'w, 's, E: Engine> {
    joined: Query<'w, 's, (&'static InLevelCell, MadeBefore<E>)>,
    cells: Query<'w, 's, (&'static LevelCell, Has<FailedRequest>, Has<AttachedCollider>)>,
}

/// Those whose cell has its collider have theirs. Where it could not be made each is made alone, so
/// that what is wrong with one costs no other its collider.
pub(super) fn finish_members<E: Engine>(
    mut work: Work,
    members: Members<E>,
    mut outcomes: Outcomes,
) {
    let unfinished: Vec<Entity> = work.unfinished.in_cells().collect();
    for entity in unfinished {
        let Ok((joined, before)) = members.joined.get(entity) else { continue };
        let cell = joined.cell;
        let Ok((of_cell, has_failed, is_attached)) = members.cells.get(cell) else { continue };
        if work.unfinished.is_pending(cell) {
            continue;
        }
        if has_failed {
            for &member in of_cell.entities() {
                outcomes.commands.entity(member).try_insert(OutOfCells);
                work.restart(member);
            }
            continue;
        }
        let why = work.unfinished.requested(entity).and_then(|of| of.request.why_triangles());
        let (true, Some(why)) = (is_attached, why) else { continue };
        let Some(ended) = work.unfinished.end(entity) else { continue };
        let mut commands = outcomes.commands.entity(entity);
        before.detach_own(&mut commands);
        if let Some(requested) = ended.requested {
            commands.try_insert(AttachedCollider { requested });
        }
        outcomes.skipped(entity, why);
    }
}
