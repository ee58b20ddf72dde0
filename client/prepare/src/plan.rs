//! Views over a hemisphere.

use gonio_scene::SceneError;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

/// A view of the part from a place on the hemisphere about it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Name of its photo, without extension.
    pub name: String,
    /// Degrees about z, from x towards y.
    pub azimuth: f64,
    /// Degrees above the plane of x and y.
    pub elevation: f64,
    /// The camera's place, in the unit of the radius; it looks at the origin with z up.
    pub position: [f64; 3],
}

/// The views of a hemisphere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Distance of the cameras from the part, in the user's unit.
    pub radius: f64,
    /// From the lowest ring up.
    pub views: Vec<View>,
}

/// Rings every `interval` degrees (1..=90) of elevation, each with views as near to that apart: about 100 at 15 degrees.
///
/// # Errors
/// The interval is not in 1..=90, or the radius is not above 0.
pub fn plan(interval: f64, radius: f64) -> Result<Plan, SceneError> {
    if !(1.0..=90.0).contains(&interval) {
        let problem = format!("is {interval} degrees");
        return Err(SceneError::new("--interval", problem, "write a number from 1 to 90"));
    }
    if !(radius.is_finite() && radius > 0.0) {
        return Err(SceneError::new("--radius", format!("is {radius}"), "write a distance above 0"));
    }
    let mut views = Vec::new();
    let rings = (90.0 / interval + 1e-9).floor() as usize;
    for ring in 0..=rings {
        let elevation = interval * ring as f64;
        let (sin, cos) = libm::sincos(elevation.to_radians());
        let count = ((360.0 * cos / interval).round() as usize).max(1);
        for k in 0..count {
            let azimuth = 360.0 * k as f64 / count as f64;
            let (across, along) = libm::sincos(azimuth.to_radians());
            let position = [radius * cos * along, radius * cos * across, radius * sin];
            views.push(View { name: format!("view_{:03}", views.len()), azimuth, elevation, position });
        }
    }
    Ok(Plan { radius, views })
}

impl Plan {
    /// Lines `name,azimuth,elevation,x,y,z` under a heading.
    pub fn to_csv(&self) -> String {
        let mut csv = String::from("name,azimuth,elevation,x,y,z\n");
        for View { name, azimuth, elevation, position: [x, y, z] } in &self.views {
            // Writing to a string cannot fail.
            let _ = writeln!(csv, "{name},{azimuth:.4},{elevation:.4},{x:.6},{y:.6},{z:.6}");
        }
        csv
    }

    /// The plan as JSON text.
    pub fn to_json(&self) -> String {
        serde_json::json!(self).to_string()
    }

    /// Reads what [`to_json`](Self::to_json) wrote; `file` is for messages.
    ///
    /// # Errors
    /// The text is no plan, or has no views.
    pub fn from_json(file: &str, text: &str) -> Result<Self, SceneError> {
        let mend = "name a views.json that `gonio plan` wrote";
        let plan: Self = serde_json::from_str(text)
            .map_err(|error| SceneError::new(file, format!("is no plan of views: {error}"), mend))?;
        if plan.views.is_empty() || !(plan.radius.is_finite() && plan.radius > 0.0) {
            return Err(SceneError::new(file, "has no views, or no radius above 0", mend).at("views"));
        }
        Ok(plan)
    }

    /// Index of the view whose direction is nearest to the given one, degrees.
    pub fn nearest(&self, azimuth: f64, elevation: f64) -> usize {
        let direction = |azimuth: f64, elevation: f64| {
            let ((across, along), (sin, cos)) =
                (libm::sincos(azimuth.to_radians()), libm::sincos(elevation.to_radians()));
            [cos * along, cos * across, sin]
        };
        let wanted = direction(azimuth, elevation);
        let nearness = |view: &View| {
            let found = direction(view.azimuth, view.elevation);
            (0..3).map(|k| found[k] * wanted[k]).sum::<f64>()
        };
        let best = self.views.iter().enumerate().max_by(|a, b| nearness(a.1).total_cmp(&nearness(b.1)));
        best.map_or(0, |(index, _)| index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn about_a_hundred_views_at_fifteen_degrees() -> Result<(), SceneError> {
        let plan = plan(15.0, 2.0)?;
        assert_eq!(plan.views.len(), 104);
        assert_eq!(Plan::from_json("views.json", &plan.to_json())?, plan);
        assert_eq!(plan.to_csv().lines().count(), 105);
        for (k, view) in plan.views.iter().enumerate() {
            assert_eq!(plan.nearest(view.azimuth + 2.0, (view.elevation + 2.0).min(89.0)), k);
            let length = view.position.iter().map(|value| value * value).sum::<f64>();
            assert!((length - 4.0).abs() < 1e-9);
        }
        assert!(super::plan(0.0, 1.0).is_err() && super::plan(15.0, -1.0).is_err());
        assert!(Plan::from_json("views.json", "{}").is_err());
        Ok(())
    }
}
