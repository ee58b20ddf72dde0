//! Three numbers as a vector.

/// A point, a direction or a colour.
pub type V = [f64; 3];

pub fn add(a: V, b: V) -> V {
    [0, 1, 2].map(|i| a[i] + b[i])
}

pub fn sub(a: V, b: V) -> V {
    [0, 1, 2].map(|i| a[i] - b[i])
}

pub fn scale(a: V, s: f64) -> V {
    a.map(|x| x * s)
}

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn unit(a: V) -> V {
    scale(a, 1.0 / dot(a, a).sqrt().max(1e-30))
}
