//! The numbers of the file as suspects: what the capture fixes may be wrong. They are scored beside the catalogue and accepted by the
//! same rule; a finding gives the corrected value.
//!
//! A number of one photo alone is predicted by no other photo. It is a suspect where that photo stands out among the others.

mod base_color;
mod focal_length;
mod lamp_color;
mod mesh_scale;
mod photo_balance;
mod photo_exposure;
mod photo_pose;
mod principal_point;
mod white_balance;

use crate::effects::Effect;

/// Every group of numbers that a diagnosis suspects.
pub const SUSPECTS: [&Effect; 9] = [
    &focal_length::SUSPECT,
    &principal_point::SUSPECT,
    &base_color::SUSPECT,
    &lamp_color::SUSPECT,
    &mesh_scale::SUSPECT,
    &photo_pose::SUSPECT,
    &photo_exposure::SUSPECT,
    &photo_balance::SUSPECT,
    &white_balance::SUSPECT,
];
