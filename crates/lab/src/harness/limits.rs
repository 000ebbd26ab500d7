//! A process with limits on time and memory: whatever a method does, it ends, and only itself.

use std::fs::File;
use std::io::{Read, Seek};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use sysinfo::{Pid, ProcessRefreshKind, ProcessesToUpdate, System};

pub use super::row::Status;

/// How long and how large a process may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Longest time until the first output, and from each to the next or the end.
    pub time: Duration,
    /// Largest resident memory, in bytes.
    pub memory: u64,
}

/// What a process said, and how it ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    pub status: Status,
    /// Lines of standard output.
    pub lines: Vec<String>,
    /// The last line of standard error, or what stopped the process.
    pub reason: String,
}

/// Between two looks at the memory: short enough that a process takes little more in between, long
/// enough that looking costs it nothing.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// What is read of an output: far more than rows, or a message of an error or a panic.
const MOST_BYTES: u64 = 1 << 24;

/// Exit code of a Rust program that panicked.
const PANICKED: i32 = 101;

/// Runs a command under limits. Exit code 1 is an error that the program reports in its last line
/// of standard error; any other end but success is a crash.
pub fn run(mut command: Command, limits: Limits) -> Result<Ended, String> {
    // Without any time, whether a quick process ends in it would be chance.
    if limits.time.is_zero() {
        let (lines, reason) = (Vec::new(), "over 0 s".to_owned());
        return Ok(Ended { status: Status::TimeOut, lines, reason });
    }
    let program = command.get_program().to_string_lossy().into_owned();
    let say = |error: std::io::Error| format!("{program}: {error}");
    // Files and no pipes: a process that is killed may leave helpers that hold a pipe open.
    let [mut output, mut errors] =
        [tempfile::tempfile().map_err(say)?, tempfile::tempfile().map_err(say)?];
    command.stdin(Stdio::null());
    command.stdout(output.try_clone().map_err(say)?).stderr(errors.try_clone().map_err(say)?);
    let mut child = command.spawn().map_err(say)?;
    let stopped = watch(&mut child, &output, limits);
    if stopped.is_some() {
        let _ = child.kill();
    }
    let exit = child.wait().map_err(say)?;
    let output = text(&mut output);
    // A last line that was cut off is no line.
    let whole = output.rfind('\n').map_or("", |end| &output[..end]);
    let lines = whole.lines().map(str::to_owned).collect();
    let errors = text(&mut errors);
    let (status, reason) = match (stopped, exit.code()) {
        (Some(Status::OutOfMemory), _) => {
            (Status::OutOfMemory, format!("over {} MB", limits.memory >> 20))
        }
        (Some(status), _) => (status, format!("over {} s", limits.time.as_secs_f64())),
        (None, Some(0)) => (Status::Done, String::new()),
        (None, Some(1)) => (Status::Error, last_line(&errors)),
        (None, Some(PANICKED)) => (Status::Crash, panic_message(&errors)),
        (None, _) => {
            let reason = last_line(&errors);
            (Status::Crash, if reason.is_empty() { exit.to_string() } else { reason })
        }
    };
    Ok(Ended { status, lines, reason })
}

/// Waits for the end of a process: why it must be stopped, if it must.
fn watch(child: &mut Child, output: &File, limits: Limits) -> Option<Status> {
    // Where the system does not tell, memory has no limit.
    let mut system = System::new().ok();
    let (mut start, mut length) = (Instant::now(), 0);
    while !matches!(child.try_wait(), Ok(Some(_)) | Err(_)) {
        std::thread::sleep(LOOK_EVERY);
        let now = output.metadata().map_or(0, |file| file.len());
        if now > length {
            (start, length) = (Instant::now(), now);
        }
        let memory = system.as_mut().and_then(|system| resident_memory(system, child.id()));
        if memory.is_some_and(|bytes| bytes > limits.memory) {
            return Some(Status::OutOfMemory);
        }
        if start.elapsed() > limits.time {
            return Some(Status::TimeOut);
        }
    }
    None
}

/// What was written to a file; what can't be read is not needed.
fn text(file: &mut File) -> String {
    let mut bytes = Vec::new();
    let _ = file.rewind().and_then(|()| file.take(MOST_BYTES).read_to_end(&mut bytes));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Resident memory of a process now, in bytes.
fn resident_memory(system: &mut System, process: u32) -> Option<u64> {
    let process = Pid::from_u32(process);
    let memory_only = ProcessRefreshKind::nothing().with_memory();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[process]), true, memory_only);
    system.process(process).map(sysinfo::Process::memory)
}

/// The most resident memory that this process has had, in bytes. Only Linux tells; samples of the
/// memory now would miss the peak of a short run.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes << 10)
}

/// Resets the peak of this process to its memory now.
pub fn reset_peak_memory() {
    // Where that is refused, the peak is that of the whole process.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

fn last_line(text: &str) -> String {
    let line = text.lines().rev().map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
    line.strip_prefix("error: ").unwrap_or(line).to_owned()
}

/// Where it panicked and why: the lines after "panicked at".
fn panic_message(text: &str) -> String {
    let mut lines = text.lines().skip_while(|line| !line.contains("panicked at "));
    let place = lines.next().and_then(|line| line.split("panicked at ").nth(1)).unwrap_or("");
    // The path is that of somebody's registry; the file's name is enough.
    let file = place.rsplit('/').next().unwrap_or(place).trim_end_matches(':');
    format!("panic in {file}: {}", lines.next().unwrap_or("").trim())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(script: &str, seconds: f64, megabytes: u64) -> Ended {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        let limits = Limits { time: Duration::from_secs_f64(seconds), memory: megabytes << 20 };
        run(command, limits).unwrap()
    }

    /// Plenty for anything that is not meant to reach a limit.
    const PLENTY: (f64, u64) = (60.0, 1 << 20);

    #[test]
    fn what_it_says_is_kept() {
        let ended = shell("echo one; echo two; echo noise >&2", PLENTY.0, PLENTY.1);
        assert_eq!(ended.status, Status::Done);
        assert_eq!(ended.lines, ["one", "two"]);
        assert_eq!(ended.reason, "");
    }

    #[test]
    fn an_error_is_told_from_a_crash() {
        let error = shell("echo 'error: no mesh' >&2; exit 1", PLENTY.0, PLENTY.1);
        assert_eq!((error.status, &error.reason[..]), (Status::Error, "no mesh"));
        let killed = shell("echo part; kill -SEGV $$", PLENTY.0, PLENTY.1);
        assert_eq!(killed.status, Status::Crash);
        assert_eq!(killed.lines, ["part"]);
        assert!(killed.reason.contains("signal"), "{}", killed.reason);
    }

    #[test]
    fn a_panic_says_where_and_why() {
        let message = "thread 'main' panicked at /home/a/registry/hull.rs:12:5:\\nno normal\\nnote";
        let ended = shell(&format!("printf \"{message}\" >&2; exit 101"), PLENTY.0, PLENTY.1);
        assert_eq!(ended.status, Status::Crash);
        assert_eq!(ended.reason, "panic in hull.rs:12:5: no normal");
    }

    #[test]
    fn what_hangs_is_stopped_and_what_it_said_before_is_kept() {
        let ended = shell("echo before; exec sleep 1000", 0.3, PLENTY.1);
        assert_eq!(ended.status, Status::TimeOut);
        assert_eq!(ended.lines, ["before"]);
    }

    #[test]
    fn what_closes_its_output_and_hangs_is_stopped_too() {
        assert_eq!(shell("exec >&-; exec sleep 1000", 0.3, PLENTY.1).status, Status::TimeOut);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn what_takes_too_much_memory_is_stopped() {
        // A string that doubles until something gives.
        let script = "x=0123456789abcdef; while :; do x=$x$x; done";
        assert_eq!(shell(script, PLENTY.0, 64).status, Status::OutOfMemory);
    }

    #[test]
    fn a_program_that_is_not_there_is_an_error_of_ours() {
        let limits = Limits { time: Duration::from_secs(1), memory: 1 << 30 };
        assert!(run(Command::new("/nowhere/at-all"), limits).is_err());
    }
}
