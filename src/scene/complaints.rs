//! What is wrong in files, logged once.

use std::collections::BTreeMap;

use bevy::platform::collections::HashSet;
use bevy::prelude::*;

use crate::tag::outcomes::{Descriptions, entities};

/// Errors in extras, with the entities that have them. Each is logged once.
#[derive(Default)]
pub(super) struct Complaints {
    known: HashSet<String>,
    new: BTreeMap<String, Vec<Entity>>,
}

impl Complaints {
    #[cfg(feature = "bevy_gltf")]
    pub(super) fn add(&mut self, text: String, of: Entity) {
        self.new.entry(text).or_default().push(of);
    }

    pub(super) fn log(&mut self, descriptions: &Descriptions) {
        for (text, of) in std::mem::take(&mut self.new) {
            if let Some(first) = of.first().filter(|_| self.known.insert(text.clone())) {
                let who = entities(of.len(), &descriptions.entity(*first, None));
                log::warn!("glTF extras of {who}: {text}");
            }
        }
    }
}
