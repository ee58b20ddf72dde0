//! How a film's channels become a photo's predicted values and their derivatives.

use gonio_scene::capture::Target;
use gonio_scene::derivative::{Contribution, Plan};
use gonio_scene::{Capture, SensorStage};

/// One Gram column in one colour channel of the photo.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ActiveColumn {
    /// Index among the request's columns.
    pub column: usize,
    /// A sum over channels of the film: channel of the film and d exposed light / d that channel times d channel / d
    /// parameter. Channel `i` of a film holds light of colour `i % 3`.
    pub terms: Vec<(usize, f64)>,
    /// Index in [`Recipe::sensor`], where the column is a sensor number's.
    pub sensor: Option<usize>,
}

/// The two sensors whose difference is a sensor number's column.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorColumn {
    /// With the smaller parameter.
    pub from: SensorStage,
    /// With the larger parameter.
    pub to: SensorStage,
    /// The parameter's distance between them.
    pub distance: f64,
}

/// What a photo's pixels need to be compared: derived from the [`Plan`] once per photo.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// Factor from radiance to exposed light: exposure times gain.
    pub factor: f64,
    /// From exposed light to photo values.
    pub stage: SensorStage,
    /// The columns that are not zero, per colour channel of the photo.
    pub channels: [Vec<ActiveColumn>; 3],
    /// The columns that need no film.
    pub sensor: Vec<SensorColumn>,
    /// Number of columns, zero ones included.
    pub columns: usize,
}

impl Recipe {
    /// The recipe for photo `photo` of a capture, or for measured reflectance behind the photos.
    #[must_use]
    pub fn new(plan: &Plan, capture: &Capture, photo: usize) -> Self {
        let stage = SensorStage::of(capture, photo);
        // No sensor has seen it, so none of the sensor's numbers changes it.
        let reflectance = matches!(capture.target(photo), Some(Target::Reflectance(_)));
        let camera = capture.photos.get(photo).map_or_else(|| capture.camera.clone(), |p| capture.camera_of(p));
        let factor = capture.photos.get(photo).map_or(1.0, gonio_scene::capture::Photo::factor);
        let balance = capture.photos.get(photo).map_or([1.0; 3], |p| p.balance);
        let mut recipe =
            Self { factor, stage, channels: Default::default(), sensor: Vec::new(), columns: plan.columns.len() };
        for (column, contributions) in plan.columns.iter().enumerate() {
            let sensor = contributions.iter().find_map(|contribution| match contribution {
                Contribution::Sensor { from, to, distance } if !reflectance => Some(SensorColumn {
                    from: SensorStage::new(from, &camera).balanced(balance),
                    to: SensorStage::new(to, &camera).balanced(balance),
                    distance: *distance,
                }),
                _ => None,
            });
            let sensor = sensor.map(|found| {
                recipe.sensor.push(found);
                recipe.sensor.len() - 1
            });
            for (channel, active) in recipe.channels.iter_mut().enumerate() {
                let light = |light: usize| contributions.iter().filter_map(move |c| term(c, photo, light, factor));
                // With crosstalk, each channel's value follows from the light of all three.
                let terms: Vec<_> = (0..3).filter(|l| *l == channel || recipe.stage.mixes()).flat_map(light).collect();
                if !terms.is_empty() || sensor.is_some() {
                    active.push(ActiveColumn { column, terms, sensor });
                }
            }
        }
        recipe
    }
}

fn term(contribution: &Contribution, this: usize, light: usize, photo_factor: f64) -> Option<(usize, f64)> {
    match *contribution {
        Contribution::Plane { plane, channel: only, factor } => {
            only.is_none_or(|only| only == light).then_some((3 * (1 + plane) + light, photo_factor * factor))
        }
        // The value is factor x radiance, so its derivative by the factor is the radiance.
        Contribution::Factor { photo, channel: only, factor } => {
            (photo == this && only.is_none_or(|only| only == light)).then_some((light, factor))
        }
        Contribution::Sensor { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gonio_scene::capture::{Photo, Sensor};
    use gonio_scene::derivative::Plane;

    #[test]
    fn columns_are_active_where_they_are_not_zero() {
        let planes = vec![Plane::Colour { prefix: "a".into() }, Plane::Scalar { number: "b".into() }];
        let sensor = Box::new(Sensor::default());
        let columns = vec![
            vec![Contribution::Plane { plane: 0, channel: Some(1), factor: 2.0 }],
            vec![Contribution::Plane { plane: 1, channel: None, factor: 3.0 }],
            vec![Contribution::Factor { photo: 5, channel: None, factor: 7.0 }],
            vec![Contribution::Sensor { from: sensor.clone(), to: sensor, distance: 0.5 }],
        ];
        let plan = Plan { planes, columns };
        let mut capture =
            Capture { photos: vec![Photo { exposure: 5.0, gain: 2.0, ..Photo::default() }; 6], ..Capture::default() };
        let recipe = Recipe::new(&plan, &capture, 5);
        let column = |column, channel, factor| ActiveColumn { column, terms: vec![(channel, factor)], sensor: None };
        let difference = ActiveColumn { column: 3, terms: vec![], sensor: Some(0) };
        assert_eq!(recipe.channels[0], [column(1, 6, 30.0), column(2, 0, 7.0), difference.clone()]);
        assert_eq!(recipe.channels[1], [column(0, 4, 20.0), column(1, 7, 30.0), column(2, 1, 7.0), difference.clone()]);
        assert_eq!(recipe.channels[2], [column(1, 8, 30.0), column(2, 2, 7.0), difference.clone()]);
        assert_eq!(Recipe::new(&plan, &capture, 4).channels[0], [column(1, 6, 30.0), difference]);
        capture.sensor.crosstalk[0] = 0.1;
        let mixed = Recipe::new(&plan, &capture, 4);
        assert_eq!(mixed.channels[0][0], column(0, 4, 20.0));
        assert_eq!(mixed.channels[0][1].terms, [(6, 30.0), (7, 30.0), (8, 30.0)]);
    }
}
