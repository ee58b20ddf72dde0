//! A plastic's boundary at the roughness of a place: tables for a ladder of roughnesses, and what lies between.

use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::Arc;

use glam::Vec3;

use super::super::microfacet::Ggx;
use super::super::plastic::{self, Tables};
use super::recipe::Spread;

/// Largest step of the ladder. Values between rungs are right to 1e-3, at grazing angles.
const RUNG: f32 = 0.025;

/// The tables that the surfaces of one material have built so far, by (roughness, ior, energy compensation).
#[derive(Default)]
pub struct Built(Vec<([u32; 2], bool, Arc<Tables>)>);

impl Built {
    fn get(&mut self, roughness: f32, ior: f32, energy_compensation: bool) -> Arc<Tables> {
        let key = [roughness.to_bits(), ior.to_bits()];
        if let Some((_, _, tables)) = self.0.iter().find(|(k, e, _)| *k == key && *e == energy_compensation) {
            return tables.clone();
        }
        let tables = Arc::new(plastic::tables(Ggx::new(roughness).alpha(), ior, energy_compensation));
        self.0.push((key, energy_compensation, tables.clone()));
        tables
    }
}

/// The boundary over a range of roughness, ascending.
#[derive(Clone, Debug)]
pub struct Ladder {
    rungs: Vec<(f32, Arc<Tables>)>,
    ior: f32,
}

/// The boundary at one roughness: `share` of `high`, the rest of `low`.
pub struct Through<'a> {
    low: &'a Tables,
    high: &'a Tables,
    share: f32,
    ior: f32,
}

impl Ladder {
    /// A ladder through `roughness`, and up and down from it as far as `spread` says, where it does.
    pub fn new(roughness: f32, spread: Option<Spread>, ior: f32, energy_compensation: bool, built: &mut Built) -> Self {
        let mut at = |r: f32| (r, built.get(r, ior, energy_compensation));
        if let Some(Spread::Below(factor)) = spread {
            // At the same roughnesses for every material: what lies between them is one function, whose difference
            // between two materials is its slope.
            let steps = ((roughness * factor).min(1.0) / RUNG).ceil().max(1.0);
            let rungs = (0..=steps as u32).map(|i| at((i as f32 * RUNG).min(1.0))).collect();
            return Self { rungs, ior };
        }
        let mut rungs = vec![at(roughness)];
        if let Some(Spread::By(spread)) = spread {
            for end in [roughness / spread, (roughness * spread).min(1.0)] {
                let steps = ((end - roughness).abs() / RUNG).ceil();
                rungs.extend((1..=steps as u32).map(|i| at(roughness + (end - roughness) * (i as f32 / steps))));
            }
            rungs.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        Self { rungs, ior }
    }

    /// The boundary at a roughness of the range.
    #[inline]
    pub fn at(&self, roughness: f32) -> Option<Through<'_>> {
        let above = self.rungs.partition_point(|r| r.0 < roughness).min(self.rungs.len() - 1);
        let high = self.rungs.get(above)?;
        let low = self.rungs.get(above.saturating_sub(1))?;
        let span = high.0 - low.0;
        let share = if span > 0.0 { ((roughness - low.0) / span).clamp(0.0, 1.0) } else { 1.0 };
        Some(Through { low: &low.1, high: &high.1, share, ior: self.ior })
    }
}

impl Through<'_> {
    #[inline]
    fn mix(&self, part: impl Fn(&Tables) -> f32) -> f32 {
        if self.share == 1.0 {
            return part(self.high);
        }
        (1.0 - self.share) * part(self.low) + self.share * part(self.high)
    }

    /// The boundary's transmittance at a cosine.
    #[inline]
    pub fn transmittance(&self, cos: f32) -> f32 {
        self.mix(|t| t.transmittance.value(cos))
    }

    /// The diffuse factor of a base: see `plastic::Base`.
    #[inline]
    pub fn base(&self, color: Vec3) -> Vec3 {
        let internal = self.mix(|t| t.internal.value as f32);
        color * FRAC_1_PI / (self.ior * self.ior * (Vec3::ONE - color * internal))
    }

    /// Mean over the channels of the diffuse albedo of `base` divided by the transmittance of the view.
    #[inline]
    pub fn base_weight(&self, base: Vec3) -> f32 {
        base.element_sum() * (PI / 3.0) * self.mix(|t| t.mean_transmittance.value as f32)
    }
}
