//! Hashes of large meshes in a browser: by its own SHA-256, beside the thread of the game. A frame
//! only asks whether it has answered.

use std::sync::{Arc, OnceLock};

use hullwright::hulls_format::MeshHash;
use js_sys::Uint8Array;
use wasm_bindgen::prelude::{Closure, JsValue};

use super::worker::then;
use crate::jobs::request::MeshData;

/// A mesh of fewer triangles is hashed at once: it takes less than a quarter of a millisecond.
const LEAST_TRIANGLES: usize = 2000;

/// A hash that the browser makes, once it has; `None` if it does not.
#[derive(Debug, Clone, Default)]
pub(super) struct Digest(Arc<OnceLock<Option<MeshHash>>>);

impl Digest {
    /// Begins to hash a mesh; `None` where it is small, or the browser does not hash, as on a page
    /// that came by plain HTTP.
    pub(super) fn start(data: &MeshData) -> Option<Self> {
        if data.triangles.len() < LEAST_TRIANGLES {
            return None;
        }
        let subtle = web_sys::window()?.crypto().ok()?.subtle();
        if subtle.is_undefined() {
            return None;
        }
        let bytes = Uint8Array::from(MeshHash::message(data.view()).as_slice());
        let promise = subtle.digest_with_str_and_buffer_source("SHA-256", &bytes).ok()?;
        let digest = Self::default();
        let Self(answer) = digest.clone();
        // An error has no bytes.
        let end = Closure::once_into_js(move |value: JsValue| {
            let hash = <[u8; 32]>::try_from(Uint8Array::new(&value).to_vec());
            // Nobody else answers.
            let _ = answer.set(hash.ok().map(MeshHash::from_bytes));
        });
        then(&promise, &[end.clone(), end]).ok()?;
        Some(digest)
    }

    /// The hash, or `None` in it if there will be none; `None` as long as it is not known.
    pub(super) fn answer(&self) -> Option<Option<MeshHash>> {
        self.0.get().copied()
    }
}
