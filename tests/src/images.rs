//! The images of this version, and Docker to run them.

use crate::cluster::PROGRAMS;
use std::process::{Command, Output, Stdio};

fn out(command: &mut Command) -> Option<Output> {
    command.stdin(Stdio::null()).output().ok().filter(|output| output.status.success())
}

/// What a command prints, if it succeeds.
pub fn text(command: &mut Command) -> Option<String> {
    out(command).map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// What Docker prints; it has to succeed.
pub fn docker(arguments: &[&str]) -> String {
    text(Command::new("docker").args(arguments)).unwrap_or_else(|| panic!("docker {arguments:?} failed"))
}

/// Why no image of this version can run here.
pub fn missing() -> Option<String> {
    if text(Command::new("docker").args(["info", "--format", "{{.ServerVersion}}"])).is_none_or(|v| v.is_empty()) {
        return Some("no Docker engine answers".to_owned());
    }
    let wanted = text(Command::new(PROGRAMS.join("gonio")).arg("--version")).unwrap();
    let wanted = wanted.split_whitespace().nth(1).unwrap().to_owned();
    for program in ["gonio-coordinator", "gonio-worker", "gonio"] {
        let image = format!("{program}:latest");
        let label = "{{index .Config.Labels \"org.opencontainers.image.version\"}}";
        let version = text(Command::new("docker").args(["image", "inspect", "--format", label, &image]));
        if version.as_deref() != Some(&wanted) {
            return Some(format!("there is no image {image} of version {wanted}: k8s/images/build makes it"));
        }
    }
    None
}
