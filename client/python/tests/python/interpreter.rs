//! The Python that the tests run.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;
use tempfile::TempDir;

/// A Python that can import the package.
pub struct Interpreter {
    program: String,
    /// Holds the package where it is not installed.
    package: Option<TempDir>,
}

/// The interpreter, found once; `None`, saying why, where there is none.
pub fn interpreter() -> Option<&'static Interpreter> {
    static FOUND: OnceLock<Option<Interpreter>> = OnceLock::new();
    FOUND.get_or_init(find).as_ref()
}

fn find() -> Option<Interpreter> {
    if let Ok(program) = std::env::var("GONIO_PYTHON") {
        return Some(Interpreter { program, package: None });
    }
    let probe = "import sys, numpy; sys.exit(sys.version_info < (3, 10))";
    let able = Command::new("python3").args(["-c", probe]).output().is_ok_and(|output| output.status.success());
    if !able {
        eprintln!("skipped: there is no python3 of 3.10 or later with numpy; GONIO_PYTHON may name one with the wheel");
        return None;
    }
    Some(Interpreter { program: "python3".to_owned(), package: Some(package()) })
}

/// A folder with the package: its Python files, and the library that this build has made.
fn package() -> TempDir {
    let top = tempfile::tempdir().unwrap();
    let inside = top.path().join("gonio");
    std::fs::create_dir(&inside).unwrap();
    for entry in std::fs::read_dir(crate_folder().join("gonio")).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, inside.join(path.file_name().unwrap())).unwrap();
        }
    }
    // Beside this test's own program.
    let built = std::env::current_exe().unwrap();
    let name = format!("{}_native{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let module = if cfg!(windows) { "_native.pyd" } else { "_native.abi3.so" };
    std::fs::copy(built.parent().unwrap().join(name), inside.join(module)).unwrap();
    top
}

/// The folder of this crate.
pub fn crate_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A capture of the repository.
pub fn capture(name: &str) -> PathBuf {
    crate_folder().join("../../tests/captures").join(name).canonicalize().unwrap()
}

impl Interpreter {
    /// A command of this Python in the folder `at`.
    pub fn command(&self, at: &Path) -> Command {
        let mut command = Command::new(&self.program);
        command.current_dir(at).env_remove("GONIO_FARM").env("PYTHONDONTWRITEBYTECODE", "1");
        if let Some(package) = &self.package {
            command.env("PYTHONPATH", package.path());
        }
        command
    }

    /// Runs a program's text with arguments.
    pub fn run(&self, at: &Path, text: &str, arguments: &[&str]) -> Output {
        self.command(at).args(["-c", text]).args(arguments).output().unwrap()
    }

    /// Runs a program's text, which must succeed; gives what it prints.
    pub fn succeeds(&self, at: &Path, text: &str, arguments: &[&str]) -> String {
        printed(&self.run(at, text, arguments))
    }

    /// Runs the command line in the process of this Python.
    pub fn gonio(&self, at: &Path, arguments: &[&str]) -> Output {
        self.command(at).args(["-m", "gonio"]).args(arguments).output().unwrap()
    }

    /// Where the package's files lie.
    pub fn package(&self) -> PathBuf {
        let text = "import gonio, os; print(os.path.dirname(gonio.__file__))";
        PathBuf::from(self.succeeds(&crate_folder(), text, &[]).trim_end())
    }
}

/// What a program that must have succeeded has printed.
pub fn printed(output: &Output) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}{stderr}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8(output.stdout.clone()).unwrap()
}
