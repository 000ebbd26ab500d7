//! A decomposition as one `async` function, run to its end or in time slices.

use std::pin::{Pin, pin};
use std::task::{Context, Poll, Waker};

use crate::decomposition::{Decomposition, Report};
use crate::error::Error;

/// [`decompose`](crate::decompose()) in time slices, for platforms whose background tasks run on the main
/// thread. A slice is a stage, or one resolution or one threshold of the paper's method.
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
