//! The machine and the versions that figures belong to.

use std::process::Command;
use std::time::SystemTime;

use fingerpost_vision::simd::CodePath;
use serde::Serialize;

/// What is needed to compare figures of different days.
#[derive(Debug, Clone, Serialize)]
pub struct Machine {
    /// Days since 1970-01-01 as a date.
    pub date: String,
    pub processor: String,
    pub cores: usize,
    /// The instruction set that the kernels use here.
    pub instruction_set: String,
    pub memory_gib: f64,
    pub system: String,
    pub rustc: String,
    pub opencv: String,
    pub ffmpeg: String,
}

impl Machine {
    /// Describes this machine as far as it says something about itself.
    pub fn this(opencv: String) -> Self {
        let processor = field_of("/proc/cpuinfo", "model name").unwrap_or_else(|| "unknown".to_owned());
        let family = field_of("/proc/cpuinfo", "cpu family").zip(field_of("/proc/cpuinfo", "model\t"));
        let memory = field_of("/proc/meminfo", "MemTotal")
            .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
        Self {
            date: first_line("date", &["-u", "+%Y-%m-%d"]).unwrap_or_else(days_since_1970),
            processor: family.map_or(processor.clone(), |(family, model)| {
                format!("{processor}, family {family}, model {model}")
            }),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            instruction_set: format!("{:?}", CodePath::fastest().instruction_set()),
            memory_gib: memory.map_or(f64::NAN, |kib| (kib / 1024.0 / 1024.0 * 10.0).round() / 10.0),
            system: first_line("uname", &["-sr"]).unwrap_or_default(),
            rustc: first_line("rustc", &["--version"]).unwrap_or_default(),
            opencv,
            ffmpeg: first_line("ffmpeg", &["-version"]).unwrap_or_default(),
        }
    }

    pub fn sentence(&self) -> String {
        format!(
            "{}: {}, {} cores, {} GiB, {}; kernels: {}; {}; OpenCV {}; {}",
            self.date,
            self.processor,
            self.cores,
            self.memory_gib,
            self.system,
            self.instruction_set,
            self.rustc,
            self.opencv,
            self.ffmpeg
        )
    }
}

fn field_of(path: &str, name: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn first_line(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines().next().map(|line| line.trim().to_owned())
}

fn days_since_1970() -> String {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    format!("day {} since 1970", now.as_secs() / 86_400)
}
