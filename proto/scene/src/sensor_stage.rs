//! The sensor stage: from exposed light to photo values.
//!
//! For exposed light `e` (exposure times gain times radiance) of a pixel whose centre lies `r` half image diagonals away
//! from the principal point, per channel c:
//!
//! ```text
//! l   = (1 + k1 r^2 + k2 r^4) balance_c e_c     vignetting, the photo's own balance
//! x_c = l_c + sum over k != c of crosstalk_ck l_k
//! y   = response_c(x)
//! y   = y^gamma where y > 0
//! y   = min(y + black_level, clip_level)
//! ```
//!
//! A number at its null value is passed over, so that it changes no bit. Everything that turns films into photo values
//! comes here: statistics, renders, pictures.

use crate::capture::{Camera, Capture, Reflectance, Response, Sensor, Target};
use crate::evaluation::Film;

/// The sensor stage of one camera.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorStage {
    /// In place of all else, where the light is a BRDF.
    reflectance: Option<Box<Reflectance>>,
    response: Response,
    vignetting: Option<[f64; 2]>,
    /// The photo's own factors of red, green and blue light.
    balance: Option<[f64; 3]>,
    /// Row c: the share of each channel's light in channel c.
    mix: Option<[[f64; 3]; 3]>,
    black_level: f64,
    gamma: f64,
    clip_level: f64,
    /// The principal point in pixels.
    centre: [f64; 2],
    /// Half the image's diagonal, squared, in pixels squared.
    reach: f64,
}

/// A photo value and how it follows from exposed light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhotoValue {
    /// R G B, as in the file.
    pub value: [f64; 3],
    /// d value of row's channel / d exposed light of column's channel.
    pub slope: [[f64; 3]; 3],
}

impl SensorStage {
    /// The stage of a sensor behind a camera.
    #[must_use]
    pub fn new(sensor: &Sensor, camera: &Camera) -> Self {
        let [rg, rb, gr, gb, br, bg] = sensor.crosstalk;
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        Self {
            reflectance: None,
            response: sensor.response.clone(),
            vignetting: (sensor.vignetting != [0.0; 2]).then_some(sensor.vignetting),
            balance: None,
            mix: (sensor.crosstalk != [0.0; 6]).then_some([[1.0, rg, rb], [gr, 1.0, gb], [br, bg, 1.0]]),
            black_level: sensor.black_level,
            gamma: sensor.gamma,
            clip_level: if sensor.clip_level < Sensor::NO_CLIP { sensor.clip_level } else { f64::INFINITY },
            centre: [camera.cx, camera.cy],
            reach: 0.25 * (width * width + height * height),
        }
    }

    /// The same with a photo's own balance.
    #[must_use]
    pub fn balanced(self, balance: [f64; 3]) -> Self {
        Self { balance: (balance != [1.0; 3]).then_some(balance), ..self }
    }

    /// The stage of photo `index` of a capture; of the capture's own camera where there is no such photo. Measured
    /// reflectance was seen by no sensor: its stage is [`Reflectance::value`].
    #[must_use]
    pub fn of(capture: &Capture, index: usize) -> Self {
        if let Some(Target::Reflectance(reflectance)) = capture.target(index) {
            let null = Self::new(&Sensor::default(), &Camera::default());
            return Self { reflectance: Some(Box::new(reflectance.clone())), ..null };
        }
        let camera = capture.photos.get(index).map_or_else(|| capture.camera.clone(), |p| capture.camera_of(p));
        let balance = capture.photos.get(index).map_or([1.0; 3], |p| p.balance);
        Self::new(&capture.sensor, &camera).balanced(balance)
    }

    /// Whether a channel's value depends on another channel's light.
    #[must_use]
    pub fn mixes(&self) -> bool {
        self.mix.is_some()
    }

    /// Whether values of photos are no linear function of light, below the clip level.
    #[must_use]
    pub fn is_curved(&self) -> bool {
        self.reflectance.is_none() && (self.response != Response::Linear || self.gamma != 1.0)
    }

    /// The photo value of the pixel in column `x` and row `y` for its exposed light.
    #[must_use]
    pub fn value(&self, exposed: [f64; 3], x: usize, y: usize) -> PhotoValue {
        let share = self.vignetting.map_or(1.0, |k| self.share(k, x, y));
        let shares = self.balance.map_or([share; 3], |balance| balance.map(|b| share * b));
        let light = [0, 1, 2].map(|c| shares[c] * exposed[c]);
        let mut photo = PhotoValue { value: [0.0; 3], slope: [[0.0; 3]; 3] };
        for c in 0..3 {
            let Some(mix) = &self.mix else {
                let (value, slope) = self.curve(c, light[c]);
                (photo.value[c], photo.slope[c][c]) = (value, slope * shares[c]);
                continue;
            };
            let mixed = mix[c][0] * light[0] + mix[c][1] * light[1] + mix[c][2] * light[2];
            let (value, slope) = self.curve(c, mixed);
            (photo.value[c], photo.slope[c]) = (value, [0, 1, 2].map(|k| slope * shares[k] * mix[c][k]));
        }
        photo
    }

    /// The film of a photo, which holds exposed light, as photo values: what a file of that photo would hold. A
    /// first-hit film has no photo values and comes back as it is.
    #[must_use]
    pub fn photo_values(&self, film: &Film) -> Film {
        let mut photo = film.clone();
        if let ([red, green, blue], true) = (&mut photo.channels[..], film.width > 0) {
            for (i, ((r, g), b)) in red.iter_mut().zip(green).zip(blue).enumerate() {
                let (x, y) = (i % film.width as usize, i / film.width as usize);
                let found = self.value([*r, *g, *b].map(f64::from), x, y).value;
                #[allow(clippy::cast_possible_truncation)]
                let [red, green, blue] = found.map(|v| v as f32);
                (*r, *g, *b) = (red, green, blue);
            }
        }
        photo
    }

    /// What vignetting leaves of the light at a pixel's centre.
    #[allow(clippy::cast_precision_loss)]
    fn share(&self, [k1, k2]: [f64; 2], x: usize, y: usize) -> f64 {
        let (dx, dy) = (x as f64 + 0.5 - self.centre[0], y as f64 + 0.5 - self.centre[1]);
        let r2 = (dx * dx + dy * dy) / self.reach;
        1.0 + r2 * (k1 + r2 * k2)
    }

    /// The value for a channel's light, and its slope.
    fn curve(&self, channel: usize, light: f64) -> (f64, f64) {
        if let Some(reflectance) = &self.reflectance {
            return reflectance.value(light);
        }
        let (mut value, mut slope) = self.response.apply(channel, light);
        if self.gamma != 1.0 && value > 0.0 {
            let power = libm::pow(value, self.gamma);
            slope *= self.gamma * power / value;
            value = power;
        }
        if self.black_level != 0.0 {
            value += self.black_level;
        }
        if value >= self.clip_level { (self.clip_level, 0.0) } else { (value, slope) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NULL: [f64; 3] = [0.3, 0.002, 1.7];

    fn camera() -> Camera {
        Camera { width: 8, height: 6, cx: 4.25, cy: 2.5, ..Camera::default() }
    }

    fn value(sensor: &Sensor, exposed: [f64; 3]) -> PhotoValue {
        SensorStage::new(sensor, &camera()).value(exposed, 6, 1)
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-14 * b.abs().max(1.0), "{a} is not {b}");
    }

    #[test]
    fn null_values_leave_the_response_alone_to_the_last_bit() {
        for response in [Response::Linear, Response::Srgb] {
            let found = value(&Sensor { response: response.clone(), ..Sensor::default() }, NULL);
            for (c, exposed) in NULL.into_iter().enumerate() {
                let (value, slope) = response.apply(c, exposed);
                assert_eq!((found.value[c].to_bits(), found.slope[c][c].to_bits()), (value.to_bits(), slope.to_bits()));
                assert_eq!(found.slope[c].iter().filter(|s| **s == 0.0).count(), 2);
            }
        }
        // What is brighter than the null clip level is not clipped, zeros keep their sign.
        let found = value(&Sensor::default(), [3e7, -0.0, -1.0]);
        assert_eq!(found.value.map(f64::to_bits), [3e7, -0.0, -1.0].map(f64::to_bits));
    }

    #[test]
    fn each_key_follows_its_formula() {
        // Column 6, row 1: (2.25, -1) pixels from the principal point; half the diagonal is 5.
        let r2: f64 = (2.25 * 2.25 + 1.0) / 25.0;
        let found = value(&Sensor { vignetting: [-0.4, 0.1], ..Sensor::default() }, NULL);
        found.value.iter().zip(NULL).for_each(|(v, e)| close(*v, e * (1.0 - 0.4 * r2 + 0.1 * r2 * r2)));

        let crosstalk = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
        let found = value(&Sensor { crosstalk, ..Sensor::default() }, [1.0, 10.0, 100.0]);
        found.value.iter().zip([22.0, 50.3, 106.5]).for_each(|(v, e)| close(*v, e));
        close(found.slope[0][2], 0.2);
        close(found.slope[2][1], 0.6);

        let found = value(&Sensor { black_level: 0.05, ..Sensor::default() }, [0.0, 1.0, -1.0]);
        found.value.iter().zip([0.05, 1.05, -0.95]).for_each(|(v, e)| close(*v, e));

        let found = value(&Sensor { gamma: 0.5, black_level: 0.1, ..Sensor::default() }, [0.25, 0.0, -2.0]);
        found.value.iter().zip([0.6, 0.1, -1.9]).for_each(|(v, e)| close(*v, e));
        close(found.slope[0][0], 1.0);

        let sensor = Sensor { clip_level: 0.9, black_level: 0.1, ..Sensor::default() };
        let found = value(&sensor, [0.79, 0.81, 5.0]);
        found.value.iter().zip([0.89, 0.9, 0.9]).for_each(|(v, e)| close(*v, e));
        assert_eq!([found.slope[0][0], found.slope[1][1], found.slope[2][2]], [1.0, 0.0, 0.0]);
    }

    #[test]
    fn the_slope_is_the_values_derivative() {
        for response in [Response::Linear, Response::Srgb] {
            let sensor = Sensor {
                response,
                vignetting: [-0.3, 0.2],
                crosstalk: [0.05, -0.02, 0.1, 0.03, 0.2, 0.07],
                black_level: 0.02,
                gamma: 1.3,
                clip_level: 1.2,
                ..Sensor::default()
            };
            let exposed = [0.4, 0.7, 9.0];
            let found = value(&sensor, exposed);
            for k in 0..3 {
                let moved = |by: f64| {
                    let mut exposed = exposed;
                    exposed[k] += by;
                    value(&sensor, exposed).value
                };
                let (low, high) = (moved(-1e-5), moved(1e-5));
                for c in 0..3 {
                    let expected = (high[c] - low[c]) / 2e-5;
                    assert!((found.slope[c][k] - expected).abs() < 1e-8, "{c} {k}: {} {expected}", found.slope[c][k]);
                }
            }
            assert_eq!((found.value[2], found.slope[2]), (1.2, [0.0; 3]));
        }
    }

    #[test]
    fn a_film_becomes_photo_values_pixel_by_pixel() {
        let sensor = Sensor { vignetting: [-0.5, 0.0], black_level: 0.25, ..Sensor::default() };
        let capture = Capture { sensor: sensor.clone(), camera: camera(), ..Capture::default() };
        let plane = |c: u8| (0..48).map(|i| f32::from(c) + i as f32 / 64.0).collect::<Vec<f32>>();
        let film = Film { photo: 0, width: 8, height: 6, channels: (0..3).map(plane).collect() };
        let photo = SensorStage::of(&capture, 0).photo_values(&film);
        let expected = value(&sensor, [0, 1, 2].map(|c| f64::from(film.channels[c][14]))).value;
        assert_eq!([0, 1, 2].map(|c| photo.channels[c][14]), expected.map(|v| v as f32));
        let null = SensorStage::new(&Sensor::default(), &camera());
        assert_eq!(null.photo_values(&film), film);
    }
}
