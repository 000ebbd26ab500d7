//! What every method shares: checks, the prepared mesh and the report on it, and one `async`
//! function, run to its end or in time slices.

use std::pin::{Pin, pin};
use std::task::{Context, Poll, Waker};

use crate::control::Control;
use crate::decomposition::{ALGORITHM_VERSION, Decomposition, Report, RunReport};
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::PreparedMesh;
use crate::openings::Opening;
use crate::openings::prepare::Closed;
use crate::stages::Stages;

/// [`decompose`](crate::decompose()) in time slices, for platforms whose background tasks run on
/// the main thread. A slice is a stage, or one resolution or one threshold of the paper's method.
/// [`Method::decomposer`](crate::Method::decomposer) is for the other methods.
///
/// ```
/// # let mesh = hullwright::TriangleMesh::new(
/// #     vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
/// #     vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
/// # );
/// use hullwright::{Control, Decomposer, Parameters};
///
/// let mut decomposer = Decomposer::new(&mesh, &Parameters::default(), &Control::new())?;
/// let decomposition = loop {
///     // Here a frame may be drawn.
///     if let Some(decomposition) = decomposer.step()? {
///         break decomposition;
///     }
/// };
/// assert_eq!(decomposition.hulls.len(), 1);
/// # Ok::<(), hullwright::Error>(())
/// ```
pub struct Decomposer<R = Report> {
    /// `None` after the end.
    work: Option<Pin<Box<Work<R>>>>,
}

type Work<R> = dyn Future<Output = Result<Decomposition<R>, Error>> + Send + Sync;

impl<R> std::fmt::Debug for Decomposer<R> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Decomposer").finish_non_exhaustive()
    }
}

impl<R> Decomposer<R> {
    pub(crate) fn of(
        work: impl Future<Output = Result<Decomposition<R>, Error>> + Send + Sync + 'static,
    ) -> Self {
        Self { work: Some(Box::pin(work)) }
    }

    /// Does the next slice of work. `None` while there is more to do.
    ///
    /// # Errors
    /// As [`decompose`](crate::decompose()), and [`Error::Finished`] after the result or an error.
    pub fn step(&mut self) -> Result<Option<Decomposition<R>>, Error> {
        // Taken out first: what has panicked can't be polled again.
        let mut work = self.work.take().ok_or(Error::Finished)?;
        match work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(result) => result.map(Some),
            Poll::Pending => {
                self.work = Some(work);
                Ok(None)
            }
        }
    }
}

/// Does all slices of work.
pub(crate) fn run_to_end<T>(work: impl Future<Output = T>) -> T {
    let mut work = pin!(work);
    loop {
        if let Poll::Ready(result) = work.as_mut().poll(&mut Context::from_waker(Waker::noop())) {
            return result;
        }
    }
}

/// What is checked before the mesh is copied or looked at.
///
/// # Errors
/// [`Error::TooLarge`] and [`Error::EmptyMesh`].
pub(crate) fn admit(mesh: MeshView<'_>, control: &Control) -> Result<(), Error> {
    let (vertices, triangles) = (mesh.vertex_count(), mesh.triangles().len());
    control.admit(triangles)?;
    if vertices == 0 || triangles == 0 {
        return Err(Error::EmptyMesh { vertices, triangles });
    }
    Ok(())
}

/// A mesh that is repaired, its openings closed or kept.
pub(crate) struct Input {
    pub prepared: PreparedMesh,
    source_vertices: usize,
    source_triangles: usize,
    openings: Vec<Opening>,
    nested_components: usize,
}

impl Input {
    /// A repaired mesh whose openings are closed.
    pub(crate) fn closed(source: MeshView<'_>, closed: Closed) -> Self {
        let Closed { prepared, openings, nested_components, .. } = closed;
        Self { openings, nested_components, ..Self::as_it_is(source, prepared) }
    }

    /// A repaired mesh whose openings stay.
    pub(crate) fn as_it_is(source: MeshView<'_>, prepared: PreparedMesh) -> Self {
        Self {
            prepared,
            source_vertices: source.vertex_count(),
            source_triangles: source.triangles().len(),
            openings: Vec::new(),
            nested_components: 0,
        }
    }

    /// What is reported once all stages are done.
    pub(crate) fn report(self, stages: Stages, deadline_reached: bool) -> RunReport {
        let prepared = self.prepared;
        RunReport {
            algorithm_version: ALGORITHM_VERSION,
            source_vertices: self.source_vertices,
            source_triangles: self.source_triangles,
            triangles: prepared.mesh.triangles.len(),
            diagonal: prepared.normalization.diagonal,
            components: prepared.closed.len(),
            closed_components: prepared.closed.iter().filter(|&&closed| closed).count(),
            repairs: prepared.repairs,
            openings: self.openings,
            nested_components: self.nested_components,
            deadline_reached,
            times: stages.finish(),
        }
    }
}
