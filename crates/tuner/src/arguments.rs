//! What the command takes.

use std::path::PathBuf;

use crate::model::{BUNDLED, bundled};
use crate::scene::Trial;

/// What `--help` says.
pub const USAGE: &str = "\
cargo tuner [FILE] [OPTIONS]

FILE is a mesh (OBJ, OFF, PLY, STL, glTF or GLB), or the name of a bundled model; mug without it.

  --try TRIAL        begins with look, drop, hook or stack
  --out DIR          where .hulls and .glb are saved; here without it
  --screenshot FILE  writes a picture once the hulls are there and all lies still, and ends
  --tour DIR         drives every control, writes a picture of each step, and ends; with an error if a
                     control does not do what it should
  --step NAMES       only these steps of the tour, separated by commas";

/// What was asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Arguments {
    /// The first model.
    pub model: PathBuf,
    /// What is tried first.
    pub trial: Trial,
    /// Where files are saved.
    pub folder: PathBuf,
    /// Where the only picture goes.
    pub screenshot: Option<PathBuf>,
    /// Where the tour's pictures go.
    pub tour: Option<PathBuf>,
    /// The only steps, separated by commas.
    pub step: Option<String>,
}

impl Arguments {
    /// `None` where help is asked for.
    pub fn read(words: impl IntoIterator<Item = String>) -> Result<Option<Self>, String> {
        let mut arguments = Self {
            model: bundled(BUNDLED[0]),
            trial: Trial::Look,
            folder: PathBuf::from("."),
            screenshot: None,
            tour: None,
            step: None,
        };
        let mut words = words.into_iter();
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
            match word.as_str() {
                "--help" | "-h" => return Ok(None),
                "--try" => arguments.trial = trial(&value()?)?,
                "--out" => arguments.folder = value()?.into(),
                "--screenshot" => arguments.screenshot = Some(value()?.into()),
                "--tour" => arguments.tour = Some(value()?.into()),
                "--step" => arguments.step = Some(value()?),
                option if option.starts_with('-') => {
                    return Err(format!("unknown option {option}"));
                }
                name if BUNDLED.contains(&name) => arguments.model = bundled(name),
                path => arguments.model = path.into(),
            }
        }
        Ok(Some(arguments))
    }
}

fn trial(name: &str) -> Result<Trial, String> {
    match name {
        "look" => Ok(Trial::Look),
        "drop" => Ok(Trial::Drop),
        "hook" => Ok(Trial::Hook),
        "stack" => Ok(Trial::Stack),
        _ => Err(format!("--try takes look, drop, hook or stack, not {name}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(words: &[&str]) -> Result<Option<Arguments>, String> {
        Arguments::read(words.iter().map(ToString::to_string))
    }

    #[test]
    fn a_name_is_a_bundled_model_and_all_else_a_path() {
        assert_eq!(read(&["dog"]).unwrap().unwrap().model, bundled("dog"));
        assert_eq!(read(&["dog.obj"]).unwrap().unwrap().model, PathBuf::from("dog.obj"));
        assert_eq!(read(&[]).unwrap().unwrap().model, bundled("mug"));
    }

    #[test]
    fn what_is_unknown_is_an_error() {
        for words in [&["--fast"][..], &["--try", "fly"], &["--tour"]] {
            assert!(read(words).is_err());
        }
        assert_eq!(read(&["mug", "--help"]), Ok(None));
    }
}
