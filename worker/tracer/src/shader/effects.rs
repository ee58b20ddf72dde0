//! A material with effects: its surface at a place, and the derivatives by what makes it more than a plain model.

mod below;

use super::column::{Column, KEYS, sharpness};
use crate::affine::rgb;
use crate::basis::Basis;
use crate::bsdf::{Built, Core, Evaluation, Layered, ParameterError, Recipe, Site, Spread};
use crate::geometry::{Geometry, Surface};
use crate::paint::Factors;
use crate::planes::{self, PlaneIndex};
use crate::surface_basis;
use glam::{Vec2, Vec3};
use gonio_scene::capture::{MapRole, Material, Model, VARIATIONS};
use gonio_scene::derivative::Plan;

/// Relative step of the differences by the logarithm of a place's colour or roughness.
const STEP: f32 = 0.005;
/// Largest exponent of a variation: beyond, colours are black or white and facets flat or round.
const EXPONENT: f32 = 20.0;
/// Largest exponent of a roughness: the ladder of tables ends there.
const ROUGHNESS_EXPONENT: f32 = 5.0;

/// One of a material's variations over its object.
#[derive(Clone, Debug)]
struct Variation {
    coefficients: [f32; VARIATIONS],
    /// Whether any coefficient is not 0.
    active: bool,
    /// Planes of the coefficients; `None` where none is wanted.
    planes: Option<Box<[PlaneIndex; VARIATIONS]>>,
}

/// The layered surface of a material.
#[derive(Clone, Debug)]
pub struct Effects {
    /// Whether it differs from the plain model; if not, it is here for its derivatives alone.
    pub active: bool,
    surface: Layered,
    columns: Vec<Column>,
    needs_center: bool,
    albedo: Variation,
    roughness: Variation,
    bump: Variation,
    /// Whether a map varies its numbers.
    mapped: bool,
    /// Half the angle between two tilts of the normal, radians.
    tilt: f32,
}

/// What a material with effects knows of a point.
#[derive(Clone, Copy, Debug)]
pub struct Detail {
    site: Site,
    /// In the object's box: where the basis functions are taken.
    place: Vec3,
    /// Along x and y of the shading frame: their products with a basis function's gradient say how its coefficient tilts the
    /// shading normal; zero where no derivative asks.
    tilt: [Vec3; 2],
}

impl Detail {
    /// Of a flat sample, which is no place of an object.
    pub fn flat() -> Self {
        let site = Site { axis: Vec3::Y, ..Site::default() };
        Self { site, place: Vec3::ZERO, tilt: [Vec3::ZERO; 2] }
    }

    /// Tells directions in the frame `to` in place of `from`; both have one normal.
    pub fn turn(&mut self, from: &Basis, to: &Basis) {
        let turn = |v: Vec2| {
            let world = from.x * v.x + from.y * v.y;
            Vec2::new(to.x.dot(world), to.y.dot(world))
        };
        self.site.axis = turn(self.site.axis.truncate()).extend(self.site.axis.z);
        let [x, y] = [turn(Vec2::X), turn(Vec2::Y)];
        let [along_x, along_y] = self.tilt;
        self.tilt = [along_x * x.x + along_y * y.x, along_x * x.y + along_y * y.y];
    }

    /// How each coefficient of the bump tilts the shading normal, along x and y of the shading frame.
    fn tilts(&self) -> [Vec2; VARIATIONS] {
        surface_basis::gradients(self.place).map(|g| Vec2::new(g.dot(self.tilt[0]), g.dot(self.tilt[1])))
    }
}

impl Variation {
    fn new(coefficients: &[f64; VARIATIONS], key: &str, material: &str, plan: &Plan) -> Self {
        let planes: [PlaneIndex; VARIATIONS] =
            std::array::from_fn(|k| planes::find(plan, &format!("material.{material}.{key}.{k}")));
        Self {
            coefficients: coefficients.map(|c| c as f32),
            active: coefficients.iter().any(|c| *c != 0.0),
            planes: planes.iter().any(Option::is_some).then(|| Box::new(planes)),
        }
    }

    fn used(&self) -> bool {
        self.active || self.planes.is_some()
    }

    fn sum(&self, values: &[f32; VARIATIONS]) -> f32 {
        self.coefficients.iter().zip(values).map(|(c, v)| c * v).sum()
    }

    /// The factor that it puts on a number.
    fn factor(&self, values: &[f32; VARIATIONS], most: f32) -> f32 {
        if self.active { libm::expf(self.sum(values).clamp(-most, most)) } else { 1.0 }
    }

    /// Adds the derivative `by(k)` to the plane of each coefficient k.
    fn scatter(&self, into: &mut [Vec3], by: impl Fn(usize) -> Vec3) {
        for (k, plane) in self.planes.iter().flat_map(|p| p.iter().enumerate()) {
            if let Some(plane) = plane {
                into[*plane] += by(k);
            }
        }
    }
}

impl Effects {
    /// The effects of a material; `None` where it has none and no derivative by one is wanted. `air` is the index of the
    /// air outside.
    ///
    /// # Errors
    /// Numbers outside the model's domain.
    pub fn new(material: &Material, plan: &Plan, air: f64) -> Result<Option<Self>, ParameterError> {
        let (effects, name) = (&material.effects, &material.name);
        let albedo = Variation::new(&effects.albedo_variation, "albedo_variation", name, plan);
        let roughness = Variation::new(&effects.roughness_variation, "roughness_variation", name, plan);
        let bump = Variation::new(&effects.bump, "bump", name, plan);
        let plane = |key: &str| planes::find(plan, &format!("material.{name}.{key}"));
        let variations = [&albedo, &roughness, &bump];
        let active = effects.diffuse_roughness != 0.0
            || effects.scatter_distance != 0.0
            || effects.second_lobe_weight != 0.0
            || effects.clearcoat_factor != 0.0
            || effects.metallic != 0.0
            || effects.anisotropy_strength != 0.0
            || effects.sheen_color != [0.0; 3]
            || variations.iter().any(|v| v.active)
            || !material.maps.is_empty();
        // A plain surface has analytic derivatives by what it has.
        let wanted = KEYS.iter().filter(|k| active || !k.plain).filter_map(|k| Some((k, plane(k.name)?)));
        if !active && wanted.clone().next().is_none() && !variations.iter().any(|v| v.used()) {
            return Ok(None);
        }
        let mut recipe = recipe(material, air);
        if roughness.used() {
            let reach: f32 = roughness.coefficients.iter().map(|c| c.abs()).sum();
            // Room for the differences.
            recipe.roughness_spread = Some(Spread::By(libm::expf(reach.min(ROUGHNESS_EXPONENT)) * (1.0 + 2.0 * STEP)));
        }
        if material.maps.get(MapRole::Roughness).is_some() {
            recipe.roughness_spread = Some(match recipe.roughness_spread {
                Some(Spread::By(factor)) => Spread::Below(factor),
                _ => Spread::Below(1.0),
            });
        }
        let mut built = Built::default();
        let surface = Layered::new(recipe, &mut built)?;
        let mut columns = Vec::new();
        for (key, plane) in wanted {
            columns.extend(key.column(&recipe, plane, &mut built)?);
        }
        let needs_center = columns.iter().any(Column::needs_center);
        let tilt = (0.02 * sharpness(&recipe)).clamp(2e-4, 5e-3);
        let mapped = !material.maps.is_empty();
        Ok(Some(Self { active, surface, columns, needs_center, albedo, roughness, bump, mapped, tilt }))
    }

    /// Whether any derivative is wanted.
    pub fn wanted(&self) -> bool {
        !self.columns.is_empty() || [&self.albedo, &self.roughness, &self.bump].iter().any(|v| v.planes.is_some())
    }

    /// The shading frame and details of a point.
    pub fn local(&self, surface: &Surface, geometry: &Geometry) -> (Basis, Detail) {
        let extent = geometry.extent_at(surface);
        let position = extent.position(surface.position);
        let varied = self.albedo.active || self.roughness.active;
        let values = if varied { surface_basis::values(position) } else { [0.0; VARIATIONS] };
        let mut basis = Basis::new(surface.normal);
        let mut tilt = [Vec3::ZERO; 2];
        if self.bump.used() {
            let flat = surface.normal;
            let along_surface = |v: Vec3| v - flat * flat.dot(v);
            let mut length = 1.0;
            if self.bump.active {
                let gradients = surface_basis::gradients(position);
                let gradient = self.bump.coefficients.iter().zip(&gradients).map(|(c, g)| *c * *g).sum();
                let slope = along_surface(extent.gradient(gradient)) * extent.diagonal;
                // At least 1: the slope is across the normal.
                length = (flat - slope).length();
                basis = Basis::new((flat - slope) / length);
            }
            if self.bump.planes.is_some() {
                let scale = -extent.diagonal / length;
                tilt = [basis.x, basis.y].map(|axis| extent.along(along_surface(axis)) * scale);
            }
        }
        let mapped = if self.mapped { geometry.factors(surface) } else { Factors::ONE };
        let site = Site {
            albedo: mapped.base_color * self.albedo.factor(&values, EXPONENT),
            roughness: mapped.roughness * self.roughness.factor(&values, ROUGHNESS_EXPONENT),
            metallic: mapped.metallic,
            axis: basis.local(extent.axis(basis.z)),
        };
        (basis, Detail { site, place: position, tilt })
    }

    /// The basis functions at a point; zero where no derivative by a variation of colour or roughness is wanted.
    fn values(&self, detail: &Detail) -> [f32; VARIATIONS] {
        let wanted = self.albedo.planes.is_some() || self.roughness.planes.is_some();
        if wanted { surface_basis::values(detail.place) } else { [0.0; VARIATIONS] }
    }

    /// As `Bsdf::evaluate`.
    pub fn evaluate(&self, detail: &Detail, wo: Vec3, wi: Vec3) -> Evaluation {
        self.surface.evaluate(&detail.site, wo, wi)
    }

    /// As `Bsdf::sample_direction`.
    pub fn sample_direction(&self, detail: &Detail, wo: Vec3, u: [f32; 3]) -> Option<Vec3> {
        self.surface.sample_direction(&detail.site, wo, u)
    }

    /// Adds `weight` times the derivative at fixed directions of each wanted number to its plane: of the whole surface, or of
    /// what [`Effects::evaluate_above`] counts.
    pub fn scatter<const WHOLE: bool>(&self, detail: &Detail, wo: Vec3, wi: Vec3, weight: Vec3, into: &mut [Vec3]) {
        let value = |surface: &Layered, site: &Site, wo: Vec3, wi: Vec3| {
            if WHOLE { surface.evaluate(site, wo, wi).value } else { surface.evaluate_above(site, wo, wi).value }
        };
        let site = &detail.site;
        let at = |site: &Site| value(&self.surface, site, wo, wi);
        let center = if self.needs_center { at(site) } else { Vec3::ZERO };
        for column in &self.columns {
            into[column.plane] += weight * column.derivative(center, |surface| value(surface, site, wo, wi));
        }
        let slope = 0.5 / STEP * weight;
        let values = self.values(detail);
        if self.albedo.planes.is_some() {
            let [up, down] = [1.0 + STEP, 1.0 - STEP].map(|f| Site { albedo: site.albedo * f, ..*site });
            let derivative = slope * (at(&up) - at(&down));
            self.albedo.scatter(into, |k| derivative * values[k]);
        }
        if self.roughness.planes.is_some() {
            let [up, down] = [1.0 + STEP, 1.0 - STEP].map(|f| Site { roughness: site.roughness * f, ..*site });
            let derivative = slope * (at(&up) - at(&down));
            self.roughness.scatter(into, |k| derivative * values[k]);
        }
        if self.bump.planes.is_some() {
            let tilted = |tilt: Vec2| {
                let scale = 1.0 / (1.0 + tilt.length_squared()).sqrt();
                let turn = |v: Vec3| (v.truncate() - tilt * v.z).extend(v.z + tilt.dot(v.truncate())) * scale;
                let site = Site { axis: turn(site.axis), ..*site };
                value(&self.surface, &site, turn(wo), turn(wi))
            };
            let slope = 0.5 / self.tilt * weight;
            let [x, y] = [Vec2::X, Vec2::Y].map(|axis| slope * (tilted(axis * self.tilt) - tilted(axis * -self.tilt)));
            let tilts = detail.tilts();
            self.bump.scatter(into, |k| x * tilts[k].x + y * tilts[k].y);
        }
    }
}

/// A material's numbers.
fn recipe(material: &Material, air: f64) -> Recipe {
    let effects = &material.effects;
    let mut recipe = match &material.model {
        Model::Lambert { base_color } => Recipe { base_color: rgb(base_color), ..Recipe::plain(Core::Lambert) },
        Model::Plastic { base_color, roughness, ior, energy_compensation } => Recipe {
            base_color: rgb(base_color),
            roughness: *roughness as f32,
            ior: (*ior / air) as f32,
            ..Recipe::plain(Core::Plastic { energy_compensation: *energy_compensation })
        },
        Model::Conductor { roughness, eta, k } => {
            Recipe { roughness: *roughness as f32, eta: rgb(eta), k: rgb(k), ..Recipe::plain(Core::Conductor) }
        }
    };
    recipe.diffuse_roughness = effects.diffuse_roughness as f32;
    recipe.scatter_distance = effects.scatter_distance as f32;
    recipe.second_lobe_weight = effects.second_lobe_weight as f32;
    recipe.second_lobe_roughness = effects.second_lobe_roughness as f32;
    recipe.clearcoat_factor = effects.clearcoat_factor as f32;
    recipe.clearcoat_roughness = effects.clearcoat_roughness as f32;
    recipe.clearcoat_ior = (effects.clearcoat_ior / air) as f32;
    recipe.metallic = effects.metallic as f32;
    recipe.anisotropy_strength = effects.anisotropy_strength as f32;
    recipe.anisotropy_rotation = effects.anisotropy_rotation as f32;
    recipe.sheen_color = rgb(&effects.sheen_color);
    recipe.sheen_roughness = effects.sheen_roughness as f32;
    recipe
}
