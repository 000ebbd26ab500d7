//! Shapes and mass properties for the Rapier that bevy_rapier3d brings, 0.35: for those who hold
//! hulls themselves. The plugin calls the same functions.

#![allow(clippy::missing_errors_doc, reason = "the macro's docs say it")]

crate::collider::colliders!(bevy_rapier3d::rapier);
