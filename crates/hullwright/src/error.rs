//! The error type.

/// Every way in which the library refuses input or stops early. It never panics instead.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// There are no vertices or no triangles.
    #[error("the mesh is empty: {vertices} vertices, {triangles} triangles")]
    EmptyMesh {
        /// Number of positions given.
        vertices: usize,
        /// Number of triangles given.
        triangles: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} uses vertex {index}, but there are only {vertices} vertices")]
    IndexOutOfRange {
        /// The first such triangle.
        triangle: usize,
        /// The index that it holds.
        index: u32,
        /// Number of positions given.
        vertices: usize,
    },
    /// After repair no triangle is left.
    #[error(
        "no usable triangle: of {triangles} triangles {degenerate} have no area and \
         {non_finite} have a coordinate that is not finite"
    )]
    NothingUsable {
        /// Number of triangles given.
        triangles: usize,
        /// How many of them have no area, also after welding.
        degenerate: usize,
        /// How many of them use a vertex that is infinite or not a number.
        non_finite: usize,
    },
    /// The mesh has more vertices or triangles than 32-bit indices can name, or than the caller
    /// allows: see [`Control::with_max_triangles`](crate::Control::with_max_triangles).
    #[error("the mesh is too large: {count} {what}, at most {limit} can be handled")]
    TooLarge {
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A parameter has a value that means nothing.
    #[error("parameter `{name}`: {reason}")]
    InvalidParameter {
        /// Name of the field.
        name: &'static str,
        /// What is wrong with its value.
        reason: String,
    },
    /// A mesh names the sidedness of some of its triangles only, or of more than it has.
    #[error("the sidedness of {sidedness} triangles is given, but there are {triangles}")]
    SidednessCount {
        /// How many there are of it.
        sidedness: usize,
        /// Number of triangles given.
        triangles: usize,
    },
    /// The points have no convex hull: none is finite, or they have no volume.
    #[error("no convex hull: {reason}")]
    NoHull {
        /// Why not.
        reason: &'static str,
    },
    /// There are no hulls to measure or to join.
    #[error("there are no hulls")]
    NoHulls,
    /// A hull can't be used: it has no triangles or no volume, names a point that it does not have,
    /// or has a coordinate that is not finite.
    #[error("hull {hull} can't be used: {reason}")]
    UnusableHull {
        /// Its index.
        hull: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// A dense mesh could not be simplified: it would take more memory or work than meshes of its
    /// size need, or memory is short.
    #[error("the mesh could not be simplified: {reason}")]
    Simplification {
        /// What the simplifier says.
        reason: String,
    },
    /// [`Control::cancel`](crate::Control::cancel) was called.
    #[error("cancelled")]
    Cancelled,
    /// The time limit passed, or the deadline before there was any valid result: see
    /// [`Control::with_time_limit`](crate::Control::with_time_limit) and
    /// [`Control::with_deadline`](crate::Control::with_deadline).
    #[error("the time ran out before there was a result")]
    DeadlineExceeded,
    /// There is nothing left to run: [`Decomposer::step`](crate::Decomposer::step) was called after
    /// the result or an error.
    #[error("the work is already finished")]
    Finished,
    /// A file could not be read or written, or does not hold what its suffix says.
    #[error("{path}: {source}")]
    File {
        /// The file's path, as given.
        path: String,
        /// What is wrong, and where in the file if that is known.
        source: FileError,
    },
}

/// What is wrong with a file.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// The file system refused.
    #[error("{message}")]
    System {
        /// The kind of [`std::io::Error`].
        kind: std::io::ErrorKind,
        /// What it says.
        message: String,
    },
    /// The content, or the name, is not what it should be.
    #[error("{0}")]
    Content(String),
}

impl From<std::io::Error> for FileError {
    fn from(error: std::io::Error) -> Self {
        Self::System { kind: error.kind(), message: error.to_string() }
    }
}

impl From<String> for FileError {
    fn from(reason: String) -> Self {
        Self::Content(reason)
    }
}

impl Error {
    /// A name of the variant that stays the same when its message changes: for programs in other
    /// languages.
    pub fn code(&self) -> &'static str {
        match self {
            Self::EmptyMesh { .. } => "empty_mesh",
            Self::IndexOutOfRange { .. } => "index_out_of_range",
            Self::NothingUsable { .. } => "nothing_usable",
            Self::TooLarge { .. } => "too_large",
            Self::InvalidParameter { .. } => "invalid_parameter",
            Self::SidednessCount { .. } => "sidedness_count",
            Self::NoHull { .. } => "no_hull",
            Self::NoHulls => "no_hulls",
            Self::UnusableHull { .. } => "unusable_hull",
            Self::Simplification { .. } => "simplification",
            Self::Cancelled => "cancelled",
            Self::DeadlineExceeded => "deadline_exceeded",
            Self::Finished => "finished",
            Self::File { .. } => "file",
        }
    }

    /// A parameter with a value that means nothing.
    pub(crate) fn parameter(name: &'static str, reason: impl Into<String>) -> Self {
        Self::InvalidParameter { name, reason: reason.into() }
    }

    /// A file that could not be read or written.
    pub fn file(path: &std::path::Path, source: impl Into<FileError>) -> Self {
        Self::File { path: path.display().to_string(), source: source.into() }
    }
}
