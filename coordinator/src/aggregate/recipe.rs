//! How a film's channels become a photo's predicted values and their derivatives.

use gonio_scene::derivative::{Contribution, Plan};

/// One Gram column in one colour channel: a sum over channels of the film.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveColumn {
    /// Index among the request's columns.
    pub column: usize,
    /// Channel of the film and d exposed light / d that channel times d channel / d parameter.
    pub terms: Vec<(usize, f64)>,
}

/// What a photo's pixels need to be compared: derived from the [`Plan`] once per photo.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// Factor from radiance to exposed light: exposure times gain.
    pub factor: f64,
    /// The columns that are not zero, per colour channel.
    pub channels: [Vec<ActiveColumn>; 3],
    /// Number of columns, zero ones included.
    pub columns: usize,
}

impl Recipe {
    /// The recipe for photo `photo`, whose exposure times gain is `factor`.
    #[must_use]
    pub fn new(plan: &Plan, photo: usize, factor: f64) -> Self {
        let channels = [0, 1, 2].map(|channel| {
            let active = |(column, contributions): (usize, &Vec<Contribution>)| {
                let terms: Vec<_> = contributions.iter().filter_map(|c| term(c, photo, channel, factor)).collect();
                (!terms.is_empty()).then_some(ActiveColumn { column, terms })
            };
            plan.columns.iter().enumerate().filter_map(active).collect()
        });
        Self { factor, channels, columns: plan.columns.len() }
    }
}

fn term(contribution: &Contribution, this: usize, channel: usize, photo_factor: f64) -> Option<(usize, f64)> {
    match *contribution {
        Contribution::Plane { plane, channel: only, factor } => {
            only.is_none_or(|only| only == channel).then_some((3 * (1 + plane) + channel, photo_factor * factor))
        }
        // The value is factor x radiance, so its derivative by the factor is the radiance.
        Contribution::Factor { photo, factor } => (photo == this).then_some((channel, factor)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::derivative::Plane;

    #[test]
    fn columns_are_active_where_they_are_not_zero() {
        let planes = vec![Plane::Colour { prefix: "a".into() }, Plane::Scalar { number: "b".into() }];
        let columns = vec![
            vec![Contribution::Plane { plane: 0, channel: Some(1), factor: 2.0 }],
            vec![Contribution::Plane { plane: 1, channel: None, factor: 3.0 }],
            vec![Contribution::Factor { photo: 5, factor: 7.0 }],
        ];
        let plan = Plan { planes, columns };
        let recipe = Recipe::new(&plan, 5, 10.0);
        let column = |column, channel, factor| ActiveColumn { column, terms: vec![(channel, factor)] };
        assert_eq!(recipe.channels[0], [column(1, 6, 30.0), column(2, 0, 7.0)]);
        assert_eq!(recipe.channels[1], [column(0, 4, 20.0), column(1, 7, 30.0), column(2, 1, 7.0)]);
        assert_eq!(recipe.channels[2], [column(1, 8, 30.0), column(2, 2, 7.0)]);
        assert_eq!(Recipe::new(&plan, 4, 10.0).channels[0], [column(1, 6, 30.0)]);
    }
}
