//! Whatever stops the command, the file that it writes is the old one or the new one, never a part.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use hullwright::hulls_format::HullsFile;
use hullwright_formats::read_hulls;

use crate::{PROGRAM, asset};

/// Kills, spread over the time that a whole run takes. Wherever they fall on another machine, the
/// promise is the same.
const KILLS: u32 = 16;

fn decompose(output: &Path) -> Command {
    let mut command = Command::new(PROGRAM);
    command
        .args(["decompose", &asset("mug.glb"), "-o"])
        .arg(output)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

fn hulls_in(path: &Path) -> usize {
    match path.extension() {
        Some(extension) if extension == "hulls" => HullsFile::read(path).unwrap().hulls.len(),
        _ => read_hulls(path).unwrap().len(),
    }
}

#[test]
fn a_killed_command_leaves_the_old_file_or_the_whole_new_one() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["hulls.glb", "hulls.obj", "mug.hulls"] {
        let output = folder.path().join(name);
        let start = Instant::now();
        assert!(decompose(&output).status().unwrap().success());
        let whole = start.elapsed();
        let bytes = std::fs::read(&output).unwrap();
        let hulls = hulls_in(&output);
        for kill in 0..KILLS {
            if kill % 2 == 0 {
                std::fs::remove_file(&output).unwrap();
            }
            let mut child = decompose(&output).spawn().unwrap();
            std::thread::sleep(whole * kill / KILLS + Duration::from_micros(500));
            child.kill().unwrap();
            child.wait().unwrap();
            if output.exists() {
                assert_eq!(hulls_in(&output), hulls, "{name}");
            } else {
                assert_eq!(kill % 2, 0, "{name}: the old file is gone");
                std::fs::write(&output, &bytes).unwrap();
            }
        }
    }
}

/// The limit on a file's size stands for a full disk: it needs no permissions. Windows has no such
/// limit.
#[cfg(unix)]
#[test]
fn a_command_that_can_not_write_the_whole_file_leaves_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["hulls.glb", "hulls.obj", "mug.hulls"] {
        let output = folder.path().join(name);
        std::fs::write(&output, "old").unwrap();
        let command = decompose(&output);
        let limited = Command::new("sh")
            // A block is 512 bytes.
            .args(["-c", "trap '' XFSZ; ulimit -f 4; exec \"$@\"", "sh"])
            .arg(command.get_program())
            .args(command.get_args())
            .output()
            .unwrap();
        assert!(!limited.status.success(), "{name}");
        let said = String::from_utf8_lossy(&limited.stderr).into_owned();
        assert!(said.starts_with("error: ") && said.lines().count() == 1, "{name}: {said}");
        assert_eq!(std::fs::read_to_string(&output).unwrap(), "old", "{name}");
        // Nor is there a temporary file.
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{name}");
        std::fs::remove_file(&output).unwrap();
    }
}
