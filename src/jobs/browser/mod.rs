//! Where there are no threads: meshes are decomposed and simplified in Web Workers, hashed by the
//! browser, and hulls are kept in its database. `native` has the same items.

mod database;
mod digest;
mod worker;

use bevy::tasks::TaskPoolBuilder;
use hullwright::hulls_format::MeshHash;
use hullwright::{Method, SimplifyParameters};

pub(super) use self::database::{DiskCache, DiskState};
use self::digest::Digest;
pub(super) use self::worker::processors;
use super::elsewhere::{Answer, Lookup};
use super::progress::SharedProgress;
use super::request::{ContentKey, MeshData};
use crate::tag::parameters::metres;
use crate::tag::settings::{BudgetSettings, Execution};

/// The hash of a mesh, which the browser makes.
pub(super) struct Hashing(Option<Digest>);

impl Hashing {
    pub(super) fn new() -> Self {
        Self(None)
    }

    /// `None` as long as the browser is at it.
    pub(super) fn hash(&mut self, data: &MeshData) -> Option<MeshHash> {
        if let Some(digest) = &self.0 {
            let hash = digest.answer()?;
            self.0 = None;
            return Some(hash.unwrap_or_else(|| MeshHash::of(data.view())));
        }
        self.0 = Digest::start(data);
        self.0.is_none().then(|| MeshHash::of(data.view()))
    }

    pub(super) fn is_pending(&self) -> bool {
        self.0.is_some()
    }
}

/// Looks into the database.
pub(super) fn look(cache: &DiskCache, key: ContentKey) -> Lookup<Elsewhere> {
    let look = cache.look(key).map(Elsewhere::InDatabase);
    look.map_or(Lookup::Missing, Lookup::Pending)
}

/// Where hulls or triangles come from.
pub(super) enum Elsewhere {
    InWorker(worker::Call),
    /// Nowhere yet: they may be in the cache.
    InDatabase(database::Look),
}

impl Elsewhere {
    pub(super) fn answer(&self) -> Answer {
        match self {
            Self::InWorker(call) => match call.answer() {
                worker::Answer::Pending => Answer::Pending,
                worker::Answer::Hulls(file) => Answer::Made(file),
                worker::Answer::Surface(few) => Answer::Simplified(few),
                worker::Answer::Trapped => Answer::Trapped,
                // Or the worker was short of memory, or there was none.
                worker::Answer::Refused => Answer::Refused,
            },
            Self::InDatabase(look) => match look.answer() {
                database::Answer::Pending => Answer::Pending,
                database::Answer::Found(file) => Answer::Found(file),
                database::Answer::Missing => Answer::Missing,
            },
        }
    }
}

/// Starts work in workers, if the settings say so.
pub(super) struct Runner(Option<(String, SharedProgress)>);

impl Runner {
    pub(super) fn new(budget: &BudgetSettings, progress: &SharedProgress) -> Self {
        let is_in_worker = matches!(budget.execution, Execution::Worker);
        Self(is_in_worker.then(|| (budget.worker_folder.clone(), progress.clone())))
    }

    pub(super) fn decompose(&self, data: &MeshData, method: &Method) -> Option<Elsewhere> {
        let Method::Bounded(parameters) = method else { return None };
        self.start("decompose", data, parameters.to_string())
    }

    pub(super) fn simplify(&self, data: &MeshData, bound: f32) -> Option<Elsewhere> {
        self.start("simplify", data, SimplifyParameters::new(metres(bound)).to_string())
    }

    fn start(
        &self,
        function: &'static str,
        data: &MeshData,
        parameters: String,
    ) -> Option<Elsewhere> {
        let (folder, progress) = self.0.as_ref()?;
        let progress = progress.clone();
        let heard = move |fraction| progress.set(fraction);
        let call = worker::Call::start(folder, function, data, parameters, heard);
        call.map(Elsewhere::InWorker)
    }
}

/// There are no threads.
pub(super) fn with_lower_priority(pool: TaskPoolBuilder) -> TaskPoolBuilder {
    pool
}
