//! Finds the commit that is built, for `--version`: `GONIO_COMMIT` if it is set, as where an image is built from sources
//! without their history, else what git says of this clone, else "unknown".

use std::path::{Path, PathBuf};
use std::process::Command;

/// Digits of a commit that are shown.
const DIGITS: &str = "--short=12";

fn main() {
    println!("cargo:rerun-if-env-changed=GONIO_COMMIT");
    println!("cargo:rerun-if-changed=build.rs");
    let given = std::env::var("GONIO_COMMIT").ok().map(|text| text.trim().to_owned());
    let commit = given.filter(|text| !text.is_empty()).or_else(of_clone).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo:rustc-env=GONIO_COMMIT={commit}");
}

/// The commit of the clone whose root holds this workspace: one that merely lies somewhere in another is none of it.
fn of_clone() -> Option<String> {
    let root = Path::new(&std::env::var_os("CARGO_MANIFEST_DIR")?).ancestors().nth(2)?.canonicalize().ok()?;
    let top = PathBuf::from(git(&root, &["rev-parse", "--show-toplevel"])?).canonicalize().ok()?;
    if top != root {
        return None;
    }
    // What changes with a commit or a checkout: HEAD, the branch that it names, and where branches are packed.
    let branch = git(&root, &["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        let path = git(&root, &["rev-parse", "--git-path", name]).map(|path| root.join(path));
        if let Some(path) = path.filter(|path| path.exists()) {
            println!("cargo:rerun-if-changed={}", path.display());
        }
    }
    git(&root, &["rev-parse", DIGITS, "HEAD"])
}

fn git(folder: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
    (output.status.success() && !text.is_empty()).then_some(text)
}
