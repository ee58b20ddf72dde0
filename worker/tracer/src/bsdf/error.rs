//! Parameters that no surface has.

use glam::Vec3;

/// A material parameter outside the range of its model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{parameter}` is {value}, must be from {least} to {most}")]
pub struct ParameterError {
    /// The capture format's key.
    pub parameter: &'static str,
    /// What was given.
    pub value: f32,
    /// Least value allowed.
    pub least: f32,
    /// Greatest value allowed.
    pub most: f32,
}

/// Accepts a finite number in `[least, most]`.
pub(super) fn check(parameter: &'static str, value: f32, least: f32, most: f32) -> Result<f32, ParameterError> {
    // Written so that NaN fails.
    if value >= least && value <= most { Ok(value) } else { Err(ParameterError { parameter, value, least, most }) }
}

/// [`check`] on each channel.
pub(super) fn check_color(parameter: &'static str, color: Vec3, least: f32, most: f32) -> Result<Vec3, ParameterError> {
    for value in color.to_array() {
        check(parameter, value, least, most)?;
    }
    Ok(color)
}
