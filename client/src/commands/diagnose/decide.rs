//! Deciding again from stored evidence, and the policy that decides.

use crate::arguments::DiagnoseOptions;
use crate::failure::Failure;
use crate::output::{tell, to_pretty_json};
use gonio_diagnose::Policy;
use gonio_diagnose::decide::{Action, next};
use gonio_diagnose::evidence::{EVIDENCE_FORMAT, Evidence};
use gonio_scene::SceneError;
use std::path::Path;

/// The policy that the command line asks for.
///
/// # Errors
/// A policy file that cannot be read, or holds a key that is none of a policy's.
pub fn policy(options: &DiagnoseOptions) -> Result<Policy, Failure> {
    let mut policy = match &options.policy {
        None => Policy::default(),
        Some(file) => {
            let wrong = |problem: String| {
                let mend = "write numbers of the policy, such as `accident = 0.1`";
                SceneError::new(file.display().to_string(), problem, mend)
            };
            let text = std::fs::read_to_string(file).map_err(|error| wrong(format!("cannot be read: {error}")))?;
            toml::from_str(&text).map_err(|error| wrong(error.message().to_owned()))?
        }
    };
    policy.smallest_gain = options.smallest_gain.unwrap_or(policy.smallest_gain);
    policy.smallest_file_gain = options.smallest_file_gain.unwrap_or(policy.smallest_file_gain);
    Ok(policy)
}

/// Prints what follows from an evidence file: the decision, or what it would need to know.
///
/// # Errors
/// A file that cannot be read, or is no evidence of this program's form.
pub fn again(file: &Path, policy: &Policy) -> Result<(), Failure> {
    let wrong = |problem: String| {
        SceneError::new(
            file.display().to_string(),
            problem,
            "name an evidence.json that `gonio diagnose` of this version has written",
        )
    };
    let text = std::fs::read_to_string(file).map_err(|error| wrong(format!("cannot be read: {error}")))?;
    let evidence: Evidence = serde_json::from_str(&text).map_err(|error| wrong(format!("is no evidence: {error}")))?;
    if evidence.format != EVIDENCE_FORMAT {
        return Err(wrong(format!("has form {}, this program reads {EVIDENCE_FORMAT}", evidence.format)).into());
    }
    evidence.check().map_err(wrong)?;
    match next(&evidence, policy) {
        Action::Finish(decision) => tell(&to_pretty_json(&decision)?),
        lacking => {
            tell(&to_pretty_json(&lacking)?);
            return Err(Failure::Input(
                "this policy asks for more than the evidence holds: diagnose again with --policy".to_owned(),
            ));
        }
    }
    Ok(())
}
