//! Stand-ins for ffmpeg and ffprobe, so that what videos do can be tried where there is no ffmpeg.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use fingerpost_io::read_picture;
use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::command;

/// A folder with programs called ffmpeg and ffprobe, and a video that they play.
pub(crate) struct VideoStub {
    folder: TempDir,
}

impl VideoStub {
    /// Stand-ins that play the drive's first picture as the shell commands `play` say; there, `$PICTURE` is that picture as
    /// ffmpeg writes it into its pipe.
    pub(crate) fn new(play: &str) -> Self {
        Self::described(r#"echo '{"streams":[{"avg_frame_rate":"10/1","r_frame_rate":"10/1"}]}'"#, play)
    }

    /// The same with what ffprobe does.
    pub(crate) fn described(describe: &str, play: &str) -> Self {
        let stub = Self { folder: TempDir::new().unwrap() };
        let picture = read_picture(&Drive::get().path().join("frames/000000.jpg")).unwrap();
        let mut ppm = format!("P6\n{} {}\n255\n", picture.width(), picture.height()).into_bytes();
        ppm.extend_from_slice(picture.as_slice());
        let path = stub.folder.path().join("picture.ppm");
        fs::write(&path, ppm).unwrap();
        fs::write(stub.video(), "played by the stand-ins").unwrap();
        let number = format!("echo $$ >> {}", stub.numbers().display());
        stub.program("ffprobe", &format!("{number}\n{describe}"));
        stub.program("ffmpeg", &format!("{number}\nPICTURE={}\n{play}", path.display()));
        stub
    }

    fn program(&self, name: &str, commands: &str) {
        let path = self.folder.path().join(name);
        let text = self.folder.path().join("commands");
        fs::write(&text, format!("#!/bin/sh\n{commands}\n")).unwrap();
        // What this process itself has open for writing while another test forks cannot be run ("text file busy").
        let copied = Command::new("install").args(["-m", "755"]).args([&text, &path]).status().unwrap();
        assert!(copied.success(), "{copied}");
    }

    fn numbers(&self) -> PathBuf {
        self.folder.path().join("numbers")
    }

    /// The stand-ins that are still running, by their process numbers.
    pub(crate) fn running(&self) -> Vec<String> {
        let numbers = fs::read_to_string(self.numbers()).unwrap_or_default();
        let is_running = |number: &&str| {
            let status = fs::read_to_string(format!("/proc/{number}/status")).unwrap_or_default();
            status.lines().any(|line| line.starts_with("State:") && !line.contains('Z'))
        };
        numbers.lines().filter(is_running).map(str::to_owned).collect()
    }

    fn video(&self) -> PathBuf {
        self.folder.path().join("drive.mp4")
    }

    /// `run` on that video, ready to be started.
    pub(crate) fn run(&self, out: &Path) -> Command {
        self.run_on(&self.video(), out)
    }

    /// `run` on an input that the stand-ins play, whatever it is called.
    pub(crate) fn run_on(&self, input: &Path, out: &Path) -> Command {
        let mut command = command();
        let path =
            std::env::join_paths([self.folder.path(), Path::new("/usr/bin"), Path::new("/bin")]).unwrap();
        command.args(Drive::get().run_line(input, out).split_whitespace()).env("PATH", path);
        command
    }
}
