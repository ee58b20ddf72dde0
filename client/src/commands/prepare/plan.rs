//! `gonio plan`: from where to photograph a part.

use super::write;
use crate::arguments::PlanArguments;
use crate::failure::Failure;
use crate::output::tell;
use gonio_prepare::plan::plan;
use gonio_scene::SceneError;

/// Writes the views.
pub fn run(arguments: &PlanArguments) -> Result<(), Failure> {
    let plan = plan(arguments.interval, arguments.radius)?;
    let text = match arguments.out.extension().and_then(|extension| extension.to_str()) {
        Some("json") => plan.to_json(),
        Some("csv") => plan.to_csv(),
        _ => {
            let mend = "name a .json or a .csv file by --out";
            let problem = "has an extension that says no format";
            return Err(SceneError::new(arguments.out.display().to_string(), problem, mend).into());
        }
    };
    write(&arguments.out, text.as_bytes())?;
    tell(&format!("{}: {} views", arguments.out.display(), plan.views.len()));
    Ok(())
}
