//! Directions in which a model may be wrong.

/// A direction in which the model may be wrong: one column of the score.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// The number whose value is reported.
    pub name: String,
    /// Further numbers that move along with it: name, and how far while `name` moves by one.
    pub along: Vec<(String, f64)>,
    /// The finite difference's step; where absent, the number's own derivative is used.
    pub step: Option<f64>,
    /// The step that the number's own derivative takes at its null, where it has none of first order there.
    pub step_at_null: Option<f64>,
    /// The derivative is with respect to this power of the number, 1 or 2: a size that enters squared.
    pub power: i32,
    /// Value that changes nothing.
    pub null: f64,
    /// Whether the number can only be above its null.
    pub one_sided: bool,
    /// Largest sensible distance from the null, beyond which an expected change is cut.
    pub most: f64,
    /// The only channel that the direction is seen in.
    pub channel: Option<usize>,
    /// The photo (its index) whose pixels alone are asked, and its number, which is the one that moves where the effect is present.
    /// The score's column moves all photos' alike, `name` and those along with it: one column serves every photo.
    pub of_photo: Option<(usize, String)>,
}

impl Direction {
    /// A number that may go either way from `null`.
    #[must_use]
    pub fn of(name: String, null: f64, most: f64) -> Self {
        Self {
            name,
            along: Vec::new(),
            step: None,
            step_at_null: None,
            power: 1,
            null,
            one_sided: false,
            most,
            channel: None,
            of_photo: None,
        }
    }

    /// A number that can only grow from 0.
    #[must_use]
    pub fn growing(name: String, most: f64) -> Self {
        Self { one_sided: true, ..Self::of(name, 0.0, most) }
    }

    /// A number that every photo has, in one photo alone: `names` are all photos', in their order.
    #[must_use]
    pub fn of_photo(names: &[String], photo: usize, null: f64, most: f64) -> Option<Self> {
        let (first, others) = names.split_first()?;
        let along = others.iter().map(|name| (name.clone(), 1.0)).collect();
        Some(Self { along, of_photo: Some((photo, names.get(photo)?.clone())), ..Self::of(first.clone(), null, most) })
    }

    /// The number that moves where the effect is present.
    #[must_use]
    pub fn moves(&self) -> &str {
        self.of_photo.as_ref().map_or(&self.name, |(_, name)| name)
    }

    /// By a finite difference with this step.
    #[must_use]
    pub fn by_step(self, step: f64) -> Self {
        Self { step: Some(step), ..self }
    }

    /// Seen in one channel alone.
    #[must_use]
    pub fn in_channel(self, channel: usize) -> Self {
        Self { channel: Some(channel), ..self }
    }

    /// Scored by its square.
    #[must_use]
    pub fn squared(self) -> Self {
        Self { power: 2, ..self }
    }

    /// While another number is set to `value`, from `now`: at the null it makes no difference.
    #[must_use]
    pub fn with(mut self, number: String, now: f64, value: f64) -> Self {
        if let Some(step) = self.step {
            self.along.push((number, (value - now) / step));
        }
        self
    }
}
