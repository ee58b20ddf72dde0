//! The views that templates are made of: directions over the sphere, turned about the line of sight.

use glam::{DMat3, DVec3};

/// Rotations from a model to a camera that looks at it, from `count` directions spread evenly over the sphere (Fibonacci's
/// lattice: Swinbank & Purser 2006).
pub(crate) fn over_sphere(count: u32) -> Vec<DMat3> {
    let golden = std::f64::consts::PI * (5f64.sqrt() - 1.0);
    (0..count)
        .map(|index| {
            let height = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
            let (sine, cosine) = libm::sincos(golden * f64::from(index));
            let ring = (1.0 - height * height).sqrt();
            from(DVec3::new(ring * cosine, ring * sine, height))
        })
        .collect()
}

/// The rotation to a camera that stands in `direction`: what is up in the model is up in the image, where it has an up.
fn from(direction: DVec3) -> DMat3 {
    let forward = -direction;
    let across = if direction.z.abs() > 0.999 { DVec3::X } else { DVec3::Z.cross(direction).normalize() };
    let right = (across - forward * across.dot(forward)).normalize();
    let down = forward.cross(right);
    DMat3::from_cols(right, down, forward).transpose()
}

/// A turn by `angle` radians about the line of sight, from x towards y: clockwise as the image shows it.
pub(crate) fn roll(angle: f64) -> DMat3 {
    DMat3::from_rotation_z(angle)
}

/// The least rotation that takes the line of sight to `ray`.
pub(crate) fn towards(ray: DVec3) -> DMat3 {
    let ray = ray.normalize();
    let axis = DVec3::Z.cross(ray);
    match axis.try_normalize() {
        Some(axis) => DMat3::from_axis_angle(axis, DVec3::Z.angle_between(ray)),
        None => DMat3::IDENTITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_rotations_from_everywhere() {
        let views = over_sphere(160);
        let mut mean = DVec3::ZERO;
        for view in &views {
            assert!((view.determinant() - 1.0).abs() < 1e-12);
            assert!((*view * view.transpose() - DMat3::IDENTITY).to_cols_array().iter().all(|x| x.abs() < 1e-12));
            mean += view.transpose() * DVec3::Z;
        }
        assert!((mean / 160.0).length() < 0.01, "{mean}");
        // Every direction has a view within ten degrees or so.
        for other in over_sphere(977) {
            let direction = other.transpose() * DVec3::Z;
            let nearest = views.iter().map(|v| (v.transpose() * DVec3::Z).dot(direction)).fold(-1.0, f64::max);
            assert!(nearest > libm::cos(14f64.to_radians()), "{nearest}");
        }
    }

    #[test]
    fn a_ray_is_where_the_line_of_sight_goes() {
        let ray = DVec3::new(0.3, -0.2, 1.0);
        assert!((towards(ray) * DVec3::Z - ray.normalize()).length() < 1e-12);
        assert_eq!(towards(DVec3::Z), DMat3::IDENTITY);
    }
}
