//! Smooth transforms between a bounded physical value and the coordinate that an optimiser moves freely.

use gonio_scene::capture::Range;

/// How a parameter's value follows from its coordinate `u`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Transform {
    /// The value is `u`: geometry.
    Identity,
    /// The value is `min + exp(u)`: intensities, gains, lengths.
    Above {
        /// The bound.
        min: f64,
    },
    /// The value is `min + (max - min) / (1 + exp(-u))`: reflectances, roughness, indices of refraction.
    Between {
        /// Lower bound.
        min: f64,
        /// Upper bound.
        max: f64,
    },
}

/// A coordinate this far out is at the bound: the rest of the way is 6e-6 of the range.
const FAR: f64 = 12.0;
/// Ranges that end beyond this are open for every practical purpose.
const OPEN: f64 = 1e6;
/// The part of a bounded range, at either end, that counts as the bound itself for a start: derivatives vanish there.
const EDGE: f64 = 0.002;
/// Where a start on the bound is moved to, as a part of the range.
const INSIDE: f64 = 0.02;
/// Smoothest surface that a fit considers: GGX with alpha 4e-4 is a mirror to any camera, and its highlight falls
/// between the samples.
const MIN_ROUGHNESS: f64 = 0.02;

impl Transform {
    /// The transform of a parameter, by its bounds and its name.
    #[must_use]
    pub fn of(name: &str, range: Range) -> Self {
        let min = if name.ends_with(".roughness") { range.min.max(MIN_ROUGHNESS) } else { range.min };
        match (min > -OPEN, range.max < OPEN) {
            (true, true) => Self::Between { min, max: range.max },
            // A length's 1e-12 is there to keep 0 out; the exponential does so by itself.
            (true, false) => Self::Above { min: if min.abs() <= 1e-6 { 0.0 } else { min } },
            // A bound from above alone: no number of a capture has one.
            (false, _) => Self::Identity,
        }
    }

    /// The value at coordinate `u`, strictly inside the bounds.
    #[must_use]
    pub fn value(self, u: f64) -> f64 {
        match self {
            Self::Identity => u,
            Self::Above { min } => min + libm::exp(u.clamp(-27.0, 27.0)),
            Self::Between { min, max } => min + (max - min) / (1.0 + libm::exp(-u.clamp(-FAR, FAR))),
        }
    }

    /// d value / d u.
    #[must_use]
    pub fn slope(self, u: f64) -> f64 {
        match self {
            Self::Identity => 1.0,
            Self::Above { min } => self.value(u) - min,
            Self::Between { min, max } => {
                let x = self.value(u);
                (x - min) * (max - x) / (max - min)
            }
        }
    }

    /// The coordinate of a value; one on a bound, or as good as on it, is first moved inside. A positive quantity that is 0
    /// starts from 1: nothing says how large it is, and the first scale is solved for.
    #[must_use]
    pub fn coordinate(self, value: f64) -> f64 {
        match self {
            Self::Identity => value,
            Self::Above { min } => {
                let above = value - min;
                libm::log(if above > 1e-11 { above } else { 1.0 })
            }
            Self::Between { min, max } => {
                let part = (value - min) / (max - min);
                let part = if part < EDGE {
                    INSIDE
                } else if part > 1.0 - EDGE {
                    1.0 - INSIDE
                } else {
                    part
                };
                libm::log(part / (1.0 - part))
            }
        }
    }

    /// The coordinate after a step of `du`, taken so that the value moves as a model that is linear in the *value*
    /// wants: an intensity that is to become five times itself does so, where `u + du` would make it exp(4) times.
    /// Agrees with `u + du` to first order.
    #[must_use]
    pub fn retract(self, u: f64, du: f64) -> f64 {
        match self {
            Self::Above { .. } => {
                // Below half, the straight line would soon cross zero: go on as an exponential with the same slope.
                let log_factor = if du >= -0.5 { libm::log(1.0 + du) } else { libm::log(0.5) + 2.0 * (du + 0.5) };
                (u + log_factor).clamp(-27.0, 27.0)
            }
            Self::Between { .. } => (u + du).clamp(-FAR, FAR),
            Self::Identity => u + du,
        }
    }

    /// Whether the value is at a bound for all that an optimiser can do: which one.
    #[must_use]
    pub fn bound(self, value: f64) -> Option<f64> {
        match self {
            Self::Between { min, max } if value - min < 1e-3 * (max - min) => Some(min),
            Self::Between { min, max } if max - value < 1e-3 * (max - min) => Some(max),
            Self::Above { min } if value - min < 1e-9 => Some(min),
            _ => None,
        }
    }

    /// The bound that is nearer to a value; none where there is no bound.
    #[must_use]
    pub fn nearest_bound(self, value: f64) -> Option<f64> {
        match self {
            Self::Between { min, max } => Some(if value - min < max - value { min } else { max }),
            Self::Above { min } => Some(min),
            Self::Identity => None,
        }
    }

    /// The length of the range; infinite where it is open.
    #[must_use]
    pub fn span(self) -> f64 {
        match self {
            Self::Between { min, max } => max - min,
            _ => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Transform> {
        vec![
            Transform::of("object.a.object_to_world.0.3", Range::ANY),
            Transform::of("light.led.intensity", Range::NON_NEGATIVE),
            Transform::of("photo.00.gain", Range::POSITIVE),
            Transform::of("material.a.base_color.r", Range::UNIT),
            Transform::of("material.a.roughness", Range::UNIT),
            Transform::of("material.a.ior", Range::IOR),
        ]
    }

    #[test]
    fn values_survive_the_round_trip() {
        for t in all() {
            for x in [1.05, 0.03, 0.2, 0.5, 0.97, 1.3, 1.8, 3.9] {
                if matches!(t, Transform::Between { min, max } if x <= min + 0.001 || x >= max - 0.001) {
                    continue;
                }
                let back = t.value(t.coordinate(x));
                assert!((back - x).abs() < 1e-9 * x.abs().max(1.0), "{t:?}: {x} became {back}");
            }
        }
    }

    #[test]
    fn slopes_agree_with_differences() {
        for t in all() {
            for u in [-3.0, -0.4, 0.0, 0.7, 2.5] {
                let h = 1e-5;
                let difference = (t.value(u + h) - t.value(u - h)) / (2.0 * h);
                assert!((difference - t.slope(u)).abs() < 1e-8 * (1.0 + difference.abs()), "{t:?} at {u}");
                // A step agrees with its coordinate to first order.
                assert!((t.retract(u, h) - u - h).abs() < 1e-9 && (t.retract(u, -h) - u + h).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn no_step_leaves_the_bounds() {
        for t in all() {
            for du in [-1e6, -30.0, -0.5, 0.5, 30.0, 1e6] {
                let x = t.value(t.retract(0.3, du));
                assert!(x.is_finite());
                match t {
                    Transform::Between { min, max } => assert!(x > min && x < max, "{t:?}: {x}"),
                    Transform::Above { min } => assert!(x > min && x < 1e12, "{t:?}: {x}"),
                    Transform::Identity => {}
                }
            }
        }
    }

    #[test]
    fn a_value_on_its_bound_starts_inside_with_a_slope() {
        let colour = Transform::of("material.a.base_color.r", Range::UNIT);
        for x in [0.0, 1.0] {
            let u = colour.coordinate(x);
            assert!(u.abs() < 4.0 && colour.slope(u) > 0.01, "{x}: {u}");
        }
        let ior = Transform::of("material.a.ior", Range::IOR);
        assert!(ior.value(ior.coordinate(1.0)) > 1.0);
        let roughness = Transform::of("material.a.roughness", Range::UNIT);
        assert!(roughness.value(roughness.coordinate(0.0)) > MIN_ROUGHNESS);
        let intensity = Transform::of("light.led.intensity", Range::NON_NEGATIVE);
        assert!((intensity.value(intensity.coordinate(0.0)) - 1.0).abs() < 1e-12);
    }
}
