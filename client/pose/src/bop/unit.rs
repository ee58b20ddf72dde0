//! Files have millimetres, Gonio has metres: the one place where one becomes the other.

const MILLIMETRE: f64 = 1e-3;

/// A file's length in metres.
pub(crate) fn metres(millimetres: f64) -> f64 {
    millimetres * MILLIMETRE
}

/// A length as files have it.
pub(crate) fn millimetres(metres: f64) -> f64 {
    metres / MILLIMETRE
}
