//! Where a run takes place: asked of the machine, never guessed.

use std::process::{Command, Stdio};
use std::time::SystemTime;

use oit_record::Host;

/// The machine the program runs on.
#[must_use]
pub fn host() -> Host {
    Host {
        os: value_in("/etc/os-release", "PRETTY_NAME", '=')
            .unwrap_or_else(|| std::env::consts::OS.into()),
        cpu: value_in("/proc/cpuinfo", "model name", ':')
            .unwrap_or_else(|| std::env::consts::ARCH.into()),
        cpus: std::thread::available_parallelism().map_or(1, |n| n.get() as u32),
    }
}

/// The value after `key` and `separator` in a text file of such lines.
fn value_in(path: &str, key: &str, separator: char) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let value = text.lines().find_map(|line| {
        let (name, value) = line.split_once(separator)?;
        (name.trim() == key).then_some(value)
    })?;
    Some(value.trim().trim_matches('"').to_owned())
}

/// Clocks of a GPU, in MHz.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Clocks {
    /// Streaming multiprocessors.
    pub shader_mhz: Option<u32>,
    /// Memory.
    pub memory_mhz: Option<u32>,
}

/// The clocks of the first NVIDIA GPU, where its tool is there to ask; else nothing.
#[must_use]
pub fn clocks() -> Clocks {
    let asked = Command::new("nvidia-smi")
        .args(["--query-gpu=clocks.sm,clocks.mem", "--format=csv,noheader,nounits"])
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output();
    let Ok(output) = asked else { return Clocks::default() };
    let text = String::from_utf8_lossy(&output.stdout);
    let mut values = text.lines().next().unwrap_or("").split(',').map(|value| value.trim().parse());
    let mut next = || values.next().and_then(Result::ok);
    Clocks { shader_mhz: next(), memory_mhz: next() }
}

/// Now, in UTC: `2026-11-22T09:30:00Z`.
#[must_use]
pub fn now() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
}
