//! What the command line promises, by running the program.

mod bake;
mod curve;
mod decompose;
mod documents;
mod inspect;
mod interrupted;
mod measure;
mod simplify;
mod view;

use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::Value;

const PROGRAM: &str = env!("CARGO_BIN_EXE_hullwright");

/// The path of a bundled model.
fn asset(name: &str) -> String {
    format!("{}/../../assets/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// A folder that the command runs in.
struct Place(tempfile::TempDir);

impl Place {
    fn new(files: &[(&str, &str)]) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        files.iter().for_each(|(name, content)| place.write(name, content));
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(PROGRAM).current_dir(self.0.path()).args(arguments).output().unwrap()
    }

    /// Standard output. There is no terminal, so standard error has no progress.
    #[track_caller]
    fn succeed(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), error.as_str()), (Some(0), ""));
        String::from_utf8(output.stdout).unwrap()
    }

    /// The one line of standard output.
    #[track_caller]
    fn json(&self, arguments: &[&str]) -> Value {
        let line = self.succeed(&[arguments, &["--json"]].concat());
        assert_eq!(line.lines().count(), 1);
        serde_json::from_str(&line).unwrap()
    }

    /// Standard error.
    #[track_caller]
    fn fail(&self, arguments: &[&str], code: i32) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    }

    /// The single line of standard error, where nothing goes to standard output.
    #[track_caller]
    fn fail_in_one_line(&self, arguments: &[&str], code: i32) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(code));
        assert!(output.stdout.is_empty());
        let error = String::from_utf8(output.stderr).unwrap();
        assert!(error.starts_with("error: ") && error.lines().count() == 1, "{error}");
        error
    }
}

/// The value in a table of names and values.
#[track_caller]
fn value<'a>(shown: &'a str, name: &str) -> &'a str {
    shown.lines().find_map(|line| line.strip_prefix(name)).expect(name).trim()
}
