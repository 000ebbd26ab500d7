//! The one hull of all points.

use crate::control::{Control, Stage};
use crate::decomposition::Decomposition;
use crate::error::Error;
use crate::geometry::MeshView;
use crate::mesh::PreparedMesh;
use crate::mesh::canonical_order::MeshOrder;
use crate::mesh::grouping::Grouping;
use crate::openings::OpeningSettings;
use crate::parameters::check_max_vertices;
use crate::surface::pieces::Pieces;
