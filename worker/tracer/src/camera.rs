//! Camera rays: an OpenCV pinhole, or a thin lens in its place, with Brown-Conrady distortion, undone by Newton's method.

use crate::affine::affine;
use crate::bvh::{Bundle, Ray};
use crate::vectors::{BLOCK, Lanes, Vectors};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec3};
use gonio_scene::capture::{CAPTURE_FILE, Camera, Photo};
use gonio_scene::{Result, SceneError};

/// The width of a camera ray in pixels. Sixteen of them fill a pixel side by side, and a render has that many samples or
/// more (a fit's fewest): textures lose no sharpness that a pixel's mean would keep.
const RAY: f64 = 0.25;

/// The camera of one photo, ready to shoot rays.
#[derive(Debug, Clone)]
pub struct PhotoCamera {
    intrinsics: Camera,
    rotation: Mat3,
    /// Image position (x, y, 1) to an unnormalised world direction, without distortion.
    projective: Mat3,
    /// The camera's centre in world coordinates.
    pub origin: Vec3,
    /// World direction of the camera's z axis.
    pub forward: Vec3,
    /// The angle that a camera ray stands for, radians: what is finer is averaged.
    pub spread: f32,
    distorted: bool,
    lens: Option<Lens>,
    /// Light that reaches a pixel from around it.
    pub glare: Option<Glare>,
}

/// A thin lens.
#[derive(Debug, Clone, Copy)]
struct Lens {
    /// World vectors along the image's axes, as long as the lens's radius.
    x: Vec3,
    y: Vec3,
    /// Depth that is sharp, metres.
    focus: f32,
}

/// Veiling glare: a share of a pixel's light comes from elsewhere in the image.
#[derive(Debug, Clone, Copy)]
pub struct Glare {
    /// The share, above 0.
    pub fraction: f32,
    /// Standard deviation along each axis, pixels.
    width: f32,
}

impl Glare {
    /// Where the light comes from instead, in pixels from where it arrives: Box and Muller's pair of normal numbers.
    #[must_use]
    pub fn offset(&self, u: f32, v: f32) -> (f32, f32) {
        let radius = self.width * (-2.0 * libm::logf(1.0 - u)).sqrt();
        let (sin, cos) = libm::sincosf(2.0 * std::f32::consts::PI * v);
        (radius * cos, radius * sin)
    }
}

impl PhotoCamera {
    /// # Errors
    /// A distortion that folds the image onto itself inside the frame, so that no ray belongs to a pixel.
    pub fn new(camera: &Camera, photo: &Photo) -> Result<Self> {
        let pose = affine(&photo.pose());
        let rotation = pose.matrix3;
        let (right, down) = (rotation.x_axis / camera.fx, rotation.y_axis / camera.fy);
        let corner = rotation.z_axis - right * camera.cx - down * camera.cy;
        let this = Self {
            intrinsics: camera.clone(),
            rotation: rotation.as_mat3(),
            projective: DMat3::from_cols(right, down, corner).as_mat3(),
            origin: pose.translation.as_vec3(),
            forward: rotation.z_axis.as_vec3(),
            spread: (RAY / (camera.fx * camera.fy).sqrt()) as f32,
            distorted: camera.distortion.iter().any(|d| *d != 0.0),
            lens: (camera.aperture_radius > 0.0).then(|| Lens {
                x: (rotation.x_axis * camera.aperture_radius).as_vec3(),
                y: (rotation.y_axis * camera.aperture_radius).as_vec3(),
                focus: camera.focus_distance as f32,
            }),
            glare: (camera.glare_fraction > 0.0)
                .then_some(Glare { fraction: camera.glare_fraction as f32, width: camera.glare_width as f32 }),
        };
        let (w, h) = (f64::from(camera.width), f64::from(camera.height));
        let border = (0..=8).flat_map(|i| {
            let t = f64::from(i) / 8.0;
            [(t * w, 0.0), (t * w, h), (0.0, t * h), (w, t * h)]
        });
        for (x, y) in border {
            if this.distorted && this.undistort(this.normalised(x, y)).is_none() {
                return Err(SceneError::new(
                    CAPTURE_FILE,
                    format!("folds the image at ({x:.0}, {y:.0}): no ray belongs to that pixel"),
                    "check the order k1 k2 p1 p2 k3 and the focal lengths",
                )
                .at(format!("photo.{}.distortion", photo.name())));
            }
        }
        Ok(this)
    }

    /// Whether rays of one image position differ.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// The ray that reaches image position (x, y), in pixels, through the middle of the lens.
    #[inline]
    #[must_use]
    pub fn centre_ray(&self, x: f32, y: f32) -> Ray {
        Ray { origin: self.origin, direction: self.direction(x, y), t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The ray that reaches image position (x, y), in pixels, through the point of the lens that (u, v) in the unit
    /// square stands for.
    #[inline]
    #[must_use]
    pub fn ray(&self, x: f32, y: f32, u: f32, v: f32) -> Ray {
        let pinhole = self.centre_ray(x, y);
        let Some(lens) = &self.lens else { return pinhole };
        let (sin, cos) = libm::sincosf(2.0 * std::f32::consts::PI * v);
        let shift = (lens.x * cos + lens.y * sin) * u.sqrt();
        // All rays of an image position meet in one point of the plane that is sharp.
        let sharp = pinhole.direction * (lens.focus / pinhole.direction.dot(self.forward));
        Ray { origin: self.origin + shift, direction: (sharp - shift).normalize(), ..pinhole }
    }

    /// [`PhotoCamera::ray`] through some positions of one pixel: its left and upper edge, and in units of pixels the place
    /// in it, then the place in the lens.
    #[allow(clippy::needless_range_loop)] // Four arrays at one index.
    pub fn rays(&self, [left, top]: [f32; 2], [x, y, u, v]: &[Lanes; 4], into: &mut Bundle) {
        if self.distorted || self.lens.is_some() {
            for lane in 0..BLOCK {
                into.set(lane, &self.ray(left + x[lane], top + y[lane], u[lane], v[lane]));
            }
            return;
        }
        // As `centre_ray`, in a loop that vectorises.
        into.origin = Vectors::splat(self.origin);
        let m = &self.projective;
        for lane in 0..BLOCK {
            let (x, y) = (left + x[lane], top + y[lane]);
            into.direction.set(lane, (m.x_axis * x + m.y_axis * y + m.z_axis).normalize());
        }
        into.t_min = [0.0; BLOCK];
        into.t_max = [f32::INFINITY; BLOCK];
    }

    /// The world direction (unit length) seen at image position (x, y), in pixels from the top left corner.
    #[inline]
    #[must_use]
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        if self.distorted {
            return self.distorted_direction(f64::from(x), f64::from(y));
        }
        let m = &self.projective;
        (m.x_axis * x + m.y_axis * y + m.z_axis).normalize()
    }

    #[inline(never)]
    fn distorted_direction(&self, x: f64, y: f64) -> Vec3 {
        let distorted = self.normalised(x, y);
        // A position that failed to converge lies beyond the checked border only by rounding: take it as it is.
        let p = self.undistort(distorted).unwrap_or(distorted);
        (self.rotation * DVec3::new(p.x, p.y, 1.0).normalize().as_vec3()).normalize()
    }

    fn normalised(&self, x: f64, y: f64) -> DVec2 {
        let c = &self.intrinsics;
        DVec2::new((x - c.cx) / c.fx, (y - c.cy) / c.fy)
    }

    /// OpenCV's forward model and its Jacobian (rows d x', d y').
    fn distort(&self, p: DVec2) -> (DVec2, [[f64; 2]; 2]) {
        let [k1, k2, p1, p2, k3] = self.intrinsics.distortion;
        let DVec2 { x, y } = p;
        let r2 = p.length_squared();
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        let out = DVec2::new(
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        );
        let cross = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let jacobian = [
            [radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, cross],
            [cross, radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x],
        ];
        (out, jacobian)
    }

    /// The undistorted point whose distortion is `target`, on the branch that holds the image's centre.
    fn undistort(&self, target: DVec2) -> Option<DVec2> {
        let mut p = target;
        for _ in 0..30 {
            let (value, j) = self.distort(p);
            let error = value - target;
            let det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
            if det <= 1e-6 {
                return None;
            }
            if error.length_squared() < 1e-24 {
                return Some(p);
            }
            p -= DVec2::new(j[1][1] * error.x - j[0][1] * error.y, j[0][0] * error.y - j[1][0] * error.x) / det;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn camera(distortion: [f64; 5]) -> Camera {
        Camera { width: 640, height: 480, fx: 500.0, fy: 510.0, cx: 310.0, cy: 245.0, distortion, ..Camera::default() }
    }

    #[test]
    fn the_principal_point_looks_forward_and_x_to_the_right() {
        let c = PhotoCamera::new(&camera([0.0; 5]), &Photo::default()).unwrap();
        assert!((c.direction(310.0, 245.0) - Vec3::Z).length() < 1e-6);
        let right = c.direction(810.0, 245.0);
        assert!((right - Vec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn a_fold_is_refused() {
        let error = PhotoCamera::new(&camera([-3.0, 0.0, 0.0, 0.0, 0.0]), &Photo::default()).unwrap_err();
        assert!(error.to_string().contains("folds"), "{error}");
    }

    proptest! {
        /// Projecting a ray by OpenCV's formula gives back the pixel it was shot through.
        #[test]
        fn rays_project_to_their_pixel(
            x in 0.0..640.0f64, y in 0.0..480.0f64, k1 in -0.1..0.2f64, k2 in -0.03..0.05f64,
            p1 in -0.003..0.003f64, p2 in -0.003..0.003f64,
        ) {
            let c = PhotoCamera::new(&camera([k1, k2, p1, p2, 0.0]), &Photo::default()).unwrap();
            let d = c.direction(x as f32, y as f32).as_dvec3();
            let (q, _) = c.distort(DVec2::new(d.x / d.z, d.y / d.z));
            prop_assert!((q.x * 500.0 + 310.0 - x).abs() < 1e-3);
            prop_assert!((q.y * 510.0 + 245.0 - y).abs() < 1e-3);
        }
    }
}
