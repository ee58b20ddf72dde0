//! The numbers of a layered surface.

use glam::Vec3;

/// What a layered surface stands on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// Ideal diffuse: `base_color`, `diffuse_roughness`, sheen.
    Lambert,
    /// A rough dielectric boundary over a diffuse base: everything but `eta` and `k`.
    Plastic {
        /// As for `Plastic::new`.
        energy_compensation: bool,
    },
    /// A rough metal: `roughness`, `eta`, `k`, anisotropy.
    Conductor,
}

/// All numbers of a layered surface; those that its core does not have are not looked at.
///
/// Keys, units and ranges are the capture format's, but that indices of refraction are relative to the air outside.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // the capture format says what each is
pub struct Recipe {
    pub core: Core,
    pub base_color: Vec3,
    pub roughness: f32,
    pub ior: f32,
    pub eta: Vec3,
    pub k: Vec3,
    pub diffuse_roughness: f32,
    /// Of the light below, metres.
    pub scatter_distance: f32,
    pub second_lobe_weight: f32,
    pub second_lobe_roughness: f32,
    pub clearcoat_factor: f32,
    pub clearcoat_roughness: f32,
    pub clearcoat_ior: f32,
    pub metallic: f32,
    pub anisotropy_strength: f32,
    pub anisotropy_rotation: f32,
    pub sheen_color: Vec3,
    pub sheen_roughness: f32,
    /// How far a place's roughness may be from `roughness`; `None` where it has the same everywhere.
    pub roughness_spread: Option<Spread>,
}

/// The range of roughness over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// By at most this factor, at least 1, above and below.
    By(f32),
    /// From 0 to this factor times the material's.
    Below(f32),
}

/// What a place on a surface changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Factors on `base_color`, at least 0; the product counts as 1 where it is more.
    pub albedo: Vec3,
    /// Factor on `roughness`, at least 0; the product counts as 1 where it is more.
    pub roughness: f32,
    /// Factor on `metallic`, 0 to 1.
    pub metallic: f32,
    /// The direction whose cross product with the normal is the tangent, in the shading frame.
    pub axis: Vec3,
}

impl Recipe {
    /// A surface of this core that is gray, half rough, and has no effect.
    pub fn plain(core: Core) -> Self {
        Self {
            core,
            base_color: Vec3::splat(0.5),
            roughness: 0.5,
            ior: 1.5,
            eta: Vec3::ONE,
            k: Vec3::ONE,
            diffuse_roughness: 0.0,
            scatter_distance: 0.0,
            second_lobe_weight: 0.0,
            second_lobe_roughness: 0.25,
            clearcoat_factor: 0.0,
            clearcoat_roughness: 0.1,
            clearcoat_ior: 1.5,
            metallic: 0.0,
            anisotropy_strength: 0.0,
            anisotropy_rotation: 0.0,
            sheen_color: Vec3::ZERO,
            sheen_roughness: 0.5,
            roughness_spread: None,
        }
    }
}

impl Default for Site {
    /// A place like any other, with its tangent along -y.
    fn default() -> Self {
        Self { albedo: Vec3::ONE, roughness: 1.0, metallic: 1.0, axis: Vec3::X }
    }
}
