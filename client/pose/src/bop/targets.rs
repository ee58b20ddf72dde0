//! What is to be found: `test_targets_bop19.json` (objects and how many) or `test_targets_bop24.json` (images alone).

use super::json::parse;
use gonio_scene::{Result, SceneError};
use serde::{Deserialize, Serialize};

/// One line of a file of targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Target {
    /// Number of the scene.
    #[serde(rename = "scene_id")]
    pub scene: u32,
    /// Number of the image.
    #[serde(rename = "im_id")]
    pub image: u32,
    /// Number of the object; absent in BOP24, where any object of the dataset may be there.
    #[serde(rename = "obj_id", default, skip_serializing_if = "Option::is_none")]
    pub object: Option<u32>,
    /// How many of the object are to be found, at least 1.
    #[serde(rename = "inst_count", default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
}

/// Reads a file of targets: all of them with object and count (BOP19), or none (BOP24).
///
/// # Errors
/// No JSON, no target, both kinds mixed, or a count of 0.
pub fn parse_targets(file: &str, bytes: &[u8]) -> Result<Vec<Target>> {
    let targets: Vec<Target> = parse(file, bytes)?;
    let mend = "write scene_id, im_id, obj_id and inst_count (BOP19), or scene_id and im_id (BOP24), in every entry";
    let Some(first) = targets.first() else { return Err(SceneError::new(file, "lists no target", mend)) };
    for (index, target) in targets.iter().enumerate() {
        let whole = target.object.is_some() == target.count.is_some();
        if !whole || target.object.is_some() != first.object.is_some() || target.count == Some(0) {
            return Err(SceneError::new(file, "is no target like the others", mend).at(format!("[{index}]")));
        }
    }
    Ok(targets)
}
