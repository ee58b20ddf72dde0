//! A stack of exposures of one scene.

use gonio_scene::SceneError;
use gonio_scene::image::Image;

/// One photograph of a stack.
#[derive(Debug, Clone, Default)]
pub struct Shot {
    /// The file's name, for messages.
    pub name: String,
    /// Values as in the file, 0..1, no curve removed.
    pub image: Image,
    /// Exposure time in seconds, or the equivalent at the first shot's aperture and speed; above 0.
    pub seconds: f64,
}

/// Mean values that differ by less, half a step of eight bits, have no order.
const NO_DIFFERENCE: f64 = 0.5 / 255.0;

/// Photographs of one scene that differ in exposure alone, the longest first.
#[derive(Debug, Clone)]
pub struct Stack {
    shots: Vec<Shot>,
    /// Pixels that are not part of a shot, by shot; empty where all are.
    outside: Vec<Vec<bool>>,
}

impl Stack {
    /// Sorts `shots` by exposure. Pixels that have exactly the colour `excluded` (8 bit) lie outside of their shot's frame,
    /// as registered scans mark them.
    ///
    /// # Errors
    /// Fewer than two shots, sizes that differ, a time that is not above 0, or times that are all equal.
    pub fn new(mut shots: Vec<Shot>, excluded: Option<[u8; 3]>) -> Result<Self, SceneError> {
        let first = shots.first().ok_or_else(|| too_few("no photo"))?;
        let size = (first.image.width, first.image.height);
        if shots.len() < 2 {
            return Err(too_few(&first.name));
        }
        if size.0 < 8 || size.1 < 8 {
            let problem = format!("is {} x {} pixels", size.0, size.1);
            return Err(SceneError::new(&first.name, problem, "give photos of 8 x 8 pixels or more"));
        }
        for shot in &shots {
            let found = (shot.image.width, shot.image.height);
            if found != size {
                let problem =
                    format!("is {} x {} pixels, but {} is {} x {}", found.0, found.1, first.name, size.0, size.1);
                return Err(SceneError::new(&shot.name, problem, "give photos of one camera at one size"));
            }
            if !(shot.seconds.is_finite() && shot.seconds > 0.0) {
                let problem = format!("has an exposure time of {} s", shot.seconds);
                let mend = "write its time in seconds, above 0, into the list that --times names";
                return Err(SceneError::new(&shot.name, problem, mend).at("seconds"));
            }
        }
        let (least, most) = shots
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(least, most), shot| (least.min(shot.seconds), most.max(shot.seconds)));
        if most < least * 1.05 {
            let problem = format!("and the other {} photos all have an exposure of {least} s", shots.len() - 1);
            let mend = "photograph with times at least a third of a stop apart, or write the true times into --times";
            return Err(SceneError::new(&first.name, problem, mend).at("seconds"));
        }
        shots.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        let outside = shots.iter().map(|shot| outside(&shot.image, excluded)).collect();
        let stack = Self { shots, outside };
        stack.check_order()?;
        Ok(stack)
    }

    /// Refuses times in the wrong order: a longer exposure is brighter. One shot may have a wrong time, which is found
    /// later; where most pairs contradict, it is the list that is wrong.
    fn check_order(&self) -> Result<(), SceneError> {
        let pixels = self.size().0 * self.size().1;
        let mean = |shot: usize| {
            let values = || (0..pixels).filter_map(|pixel| self.value(shot, pixel));
            let sum: f64 = values().map(|value| value.iter().map(|v| f64::from(*v)).sum::<f64>()).sum();
            sum / values().count().max(1) as f64 / 3.0
        };
        let means: Vec<f64> = (0..self.shots.len()).map(mean).collect();
        let (mut pairs, mut against) = (0, Vec::new());
        for (long, bright) in means.iter().enumerate() {
            for (short, dark) in means.iter().enumerate().skip(long + 1) {
                pairs += 1;
                if bright + NO_DIFFERENCE < *dark {
                    against.push((long, short));
                }
            }
        }
        let worst = against.iter().max_by(|a, b| (means[a.1] - means[a.0]).total_cmp(&(means[b.1] - means[b.0])));
        let Some(&(long, short)) = worst.filter(|_| 2 * against.len() > pairs) else { return Ok(()) };
        let [long, short] = [long, short].map(|index| &self.shots[index]);
        let problem = format!(
            "has an exposure of {} s and is darker than {}, which has {} s; so are {} of {pairs} pairs",
            long.seconds,
            short.name,
            short.seconds,
            against.len()
        );
        let mend = "correct the times, which seem to be in reverse order: a longer exposure is brighter";
        Err(SceneError::new(&long.name, problem, mend).at("seconds"))
    }

    /// The shots, the longest exposure first.
    pub fn shots(&self) -> &[Shot] {
        &self.shots
    }

    /// Columns and rows.
    pub fn size(&self) -> (usize, usize) {
        self.shots.first().map_or((0, 0), |shot| (shot.image.width as usize, shot.image.height as usize))
    }

    /// Natural logarithms of the exposure times.
    pub fn log_times(&self) -> Vec<f64> {
        self.shots.iter().map(|shot| libm::log(shot.seconds)).collect()
    }

    /// The value 0..1 of a pixel in a shot; none where it lies outside of the frame.
    pub fn value(&self, shot: usize, pixel: usize) -> Option<[f32; 3]> {
        if self.outside.get(shot).and_then(|mask| mask.get(pixel)).copied().unwrap_or(false) {
            return None;
        }
        self.shots.get(shot).and_then(|shot| shot.image.pixels.get(pixel)).copied()
    }

    /// Sets a shot's exposure time in seconds.
    pub fn set_seconds(&mut self, shot: usize, seconds: f64) {
        if let Some(shot) = self.shots.get_mut(shot) {
            shot.seconds = seconds;
        }
    }

    /// Moves every shot by its number of columns and rows; what comes in from beyond a border is outside of the frame.
    pub fn shift(&mut self, shifts: &[[i32; 2]]) {
        let (width, height) = self.size();
        for (k, &[dx, dy]) in shifts.iter().enumerate().filter(|&(_, shift)| *shift != [0, 0]) {
            let mut pixels = vec![[0.0; 3]; width * height];
            let mut mask = vec![true; width * height];
            for y in 0..height {
                for x in 0..width {
                    let (sx, sy) = (x as i64 - i64::from(dx), y as i64 - i64::from(dy));
                    if sx < 0 || sy < 0 || sx >= width as i64 || sy >= height as i64 {
                        continue;
                    }
                    if let Some(value) = self.value(k, sy as usize * width + sx as usize) {
                        pixels[y * width + x] = value;
                        mask[y * width + x] = false;
                    }
                }
            }
            self.shots[k].image.pixels = pixels;
            self.outside[k] = mask;
        }
    }
}

fn too_few(name: &str) -> SceneError {
    let mend = "give two or more photos of the scene at different exposure times";
    SceneError::new(name, "is a stack of fewer than two exposures", mend).at("PHOTOS")
}

fn outside(image: &Image, excluded: Option<[u8; 3]>) -> Vec<bool> {
    let Some(excluded) = excluded else { return Vec::new() };
    let colour = excluded.map(|value| f32::from(value) / 255.0);
    image.pixels.iter().map(|pixel| (0..3).all(|c| (pixel[c] - colour[c]).abs() < 1e-4)).collect()
}
