//! Russian roulette: when a path ends by chance. This rule is the only one; single paths and their twins all ask it.
//!
//! A path is worth ending where what it can still bring is small beside what the pixel holds already. Both are measured by
//! the path's throughput, which is 1 at the camera: the light that surfaces further on send is about as much as that on
//! the first. So the rule is a window on the throughput, not on the last albedo: ending a path of throughput 0.8 saves
//! little and makes its noise larger (Rath et al. 2022, "EARS", where the window follows learned variances; learned state
//! would make a task depend on others).

use glam::Vec3;

/// A path may end by chance where its throughput is below the inverse of this. Without unit. Calibrated by
/// `examples/noise.rs --seeds 3 --photos 1` on captures of other scenes than the benches judge by. Variance times CPU time at 1, 2, 3
/// and 6: 3.05, 2.74, 2.86 and 2.92e-6 for a matte and glossy part under a point lamp (none-201), 1.20, 1.28, 1.29 and 1.45e-5 for a
/// metal under a map (conductor-knob-sky).
const WORTH: f32 = 3.0;
/// From this bounce on a path goes on with at most [`MOST`], so that none between white walls lasts for ever.
const BOUNDED_FROM: u32 = 4;
/// The largest survival there.
const MOST: f32 = 0.95;
/// The least survival: it keeps derivatives alive where the value itself has died (a black base).
const LEAST: f32 = 0.05;

/// The chance that a path goes on from its surface number `bounce`, the first being 0, where it would go on with
/// throughput `proposed`. Divide the throughput by it. 1 at the first surface.
#[inline(always)]
#[must_use]
pub fn survival(bounce: u32, proposed: Vec3) -> f32 {
    if bounce == 0 {
        return 1.0;
    }
    (proposed.max_element() * WORTH).clamp(LEAST, if bounce < BOUNDED_FROM { 1.0 } else { MOST })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between white walls the chance to be alive falls to nothing: 0.95^400 < 2e-9.
    #[test]
    fn no_path_lasts_for_ever() {
        let mut alive = 1.0;
        let mut proposed = Vec3::ONE;
        for bounce in 0..400 + BOUNDED_FROM {
            let survives = survival(bounce, proposed);
            alive *= survives;
            // A throughput of 1 again, whatever roulette has made of it.
            proposed = (proposed / survives).min(Vec3::ONE);
        }
        assert!(alive < 2e-9, "{alive}");
    }

    #[test]
    fn survival_is_a_chance_and_falls_with_the_throughput() {
        for bounce in 0..8 {
            let of = |x: f32| survival(bounce, Vec3::new(x, 0.0, 0.0));
            assert!((0..100).all(|k| (0.0..=1.0).contains(&of(k as f32 * 0.05))));
            assert!((0..100).all(|k| of(k as f32 * 0.05) <= of((k + 1) as f32 * 0.05)));
            assert!(of(0.0) > 0.0, "derivatives live on");
        }
        assert_eq!(survival(1, Vec3::splat(0.8)), 1.0, "a bright path is not ended");
    }
}
