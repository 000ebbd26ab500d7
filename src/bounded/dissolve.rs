//! Dissolve.
use super::piece::{Piece, Workshop};
use super::seeds::Seeds;
use crate::{Control, Error};

pub(crate) fn dissolve(
    _seeds: &Seeds,
    pieces: Vec<Piece>,
    _shop: &mut Workshop<'_>,
    _control: &Control,
) -> Result<Vec<Piece>, Error> {
    Ok(pieces)
}
