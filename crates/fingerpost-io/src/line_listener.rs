//! Lines that come as they are written: of a receiver at a serial port, or of gpsd.

use std::collections::VecDeque;
use std::fs::{File, FileType, OpenOptions};
use std::io::{self, ErrorKind, IsTerminal, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use thiserror::Error;

/// How long a read waits for bytes before it looks whether to end.
const READ_WAIT: Duration = Duration::from_millis(50);
/// How long after it broke off a source is opened again.
const OPEN_AGAIN_AFTER: Duration = Duration::from_secs(1);
/// Lines that are kept until they are asked for; older ones are forgotten.
const MOST_LINES: usize = 256;
/// A line that is longer is none, bytes: gpsd's longest reports, of the satellites in view, are shorter.
const LONGEST_LINE: usize = 16_384;
/// What makes gpsd report what it knows (gpsd's JSON protocol, `gpsd_json(5)`).
const WATCH: &[u8] = b"?WATCH={\"enable\":true,\"json\":true}\n";

/// A source of lines that cannot be opened.
#[derive(Debug, Error)]
pub enum LineListenerError {
    /// The device cannot be read.
    #[error("{} cannot be read ({cause}); see that the receiver is there and may be read", path.display())]
    Device {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
    /// Nobody answers.
    #[error(
        "gpsd at {address} does not answer ({cause}); see that it runs and listens there, 127.0.0.1:2947 as a rule"
    )]
    Gpsd {
        /// Host and port.
        address: String,
        /// What the system says.
        cause: io::Error,
    },
}

/// A line and when it came.
pub type TimedLine = (Vec<u8>, Instant);

/// Listens in a thread of its own and keeps the newest lines. A source that breaks off is opened again until it is there.
#[derive(Debug)]
pub struct LineListener {
    lines: Arc<Mutex<VecDeque<TimedLine>>>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl LineListener {
    /// Listens to a serial device. Its speed stays as it is set (`stty`).
    ///
    /// # Errors
    /// [`LineListenerError::Device`] when it cannot be read.
    pub fn device(path: &Path) -> Result<Self, LineListenerError> {
        let at = path.to_owned();
        Self::listen(move || open_device(&at))
            .map_err(|cause| LineListenerError::Device { path: path.to_owned(), cause })
    }

    /// Listens to gpsd at a host and port.
    ///
    /// # Errors
    /// [`LineListenerError::Gpsd`] when nobody answers there.
    pub fn gpsd(address: &str) -> Result<Self, LineListenerError> {
        let at = address.to_owned();
        Self::listen(move || connect(&at))
            .map_err(|cause| LineListenerError::Gpsd { address: address.to_owned(), cause })
    }

    fn listen<R: Read + Send>(open: impl Fn() -> io::Result<R> + Send + 'static) -> io::Result<Self> {
        // What cannot be opened at all is an error at once.
        drop(open()?);
        let lines = Arc::new(Mutex::new(VecDeque::new()));
        let ended = Arc::new(AtomicBool::new(false));
        let (kept, over) = (Arc::clone(&lines), Arc::clone(&ended));
        let thread = std::thread::spawn(move || {
            while !over.load(Ordering::Relaxed) {
                if let Ok(source) = open() {
                    read_lines(source, &kept, &over);
                }
                let broke_off = Instant::now();
                while broke_off.elapsed() < OPEN_AGAIN_AFTER && !over.load(Ordering::Relaxed) {
                    std::thread::sleep(READ_WAIT);
                }
            }
        });
        Ok(Self { lines, ended, thread: Some(thread) })
    }

    /// The lines since it was asked before, in their order.
    pub fn drain(&self) -> Vec<TimedLine> {
        self.lines.lock().unwrap_or_else(PoisonError::into_inner).drain(..).collect()
    }
}

impl Drop for LineListener {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has nothing left to end.
            let _ = thread.join();
        }
    }
}

/// Reads until the source ends or nobody listens any more.
fn read_lines(mut source: impl Read, kept: &Mutex<VecDeque<TimedLine>>, over: &AtomicBool) {
    let (mut line, mut bytes) = (Vec::new(), [0; 1024]);
    while !over.load(Ordering::Relaxed) {
        let count = match source.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                std::thread::sleep(READ_WAIT);
                continue;
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(_) => return,
        };
        for &byte in bytes.iter().take(count) {
            // A terminal makes a line's end of each of the two that receivers send.
            if !matches!(byte, b'\n' | b'\r') {
                if line.len() < LONGEST_LINE {
                    line.push(byte);
                }
                continue;
            }
            if line.is_empty() {
                continue;
            }
            let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
            if kept.len() == MOST_LINES {
                kept.pop_front();
            }
            kept.push_back((std::mem::take(&mut line), Instant::now()));
        }
    }
}

/// Whether a path names a serial port: a terminal, as the system calls it, which lines come from for as long as they are asked for.
pub fn is_serial_port(path: &Path) -> bool {
    // Nothing but a device is opened to be asked: who writes a pipe is gone when its reader leaves.
    let may_be_one = path.metadata().map_or(cfg!(not(unix)), |metadata| is_device(metadata.file_type()));
    may_be_one && open_device(path).is_ok_and(|device| device.is_terminal())
}

#[cfg(unix)]
fn is_device(kind: FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&kind)
}

#[cfg(not(unix))]
fn is_device(kind: FileType) -> bool {
    !kind.is_file()
}

fn open_device(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        // A device that says nothing must not hold the thread; a terminal must not become this program's own.
        let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY;
        options.custom_flags(flags.bits() as i32);
    }
    options.open(path)
}

fn connect(address: &str) -> io::Result<TcpStream> {
    let mut stream = TcpStream::connect(address)?;
    stream.set_read_timeout(Some(READ_WAIT))?;
    stream.write_all(WATCH)?;
    Ok(stream)
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    /// The first line that comes within ten seconds.
    fn first(listener: &LineListener) -> Vec<u8> {
        let started = Instant::now();
        while started.elapsed() < Duration::from_secs(10) {
            if let Some((line, _)) = listener.drain().into_iter().next() {
                return line;
            }
            std::thread::sleep(READ_WAIT);
        }
        Vec::new()
    }

    /// Stands in for gpsd: asks each caller for its wish, says one line and hangs up.
    #[test]
    fn a_server_that_hangs_up_is_called_again() {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = server.local_addr().unwrap().to_string();
        let serving = std::thread::spawn(move || {
            // The first call only sees whether anybody is there.
            for number in 0..3 {
                let (mut caller, _) = server.accept().unwrap();
                let mut wish = [0; WATCH.len()];
                caller.read_exact(&mut wish).unwrap();
                assert_eq!(wish, WATCH);
                let _ = writeln!(caller, "{{\"class\":\"TPV\",\"call\":{number}}}");
            }
        });
        let listener = LineListener::gpsd(&address).unwrap();
        assert_eq!(first(&listener), b"{\"class\":\"TPV\",\"call\":1}");
        assert_eq!(first(&listener), b"{\"class\":\"TPV\",\"call\":2}");
        serving.join().unwrap();
        drop(listener);
        let refused = LineListener::gpsd(&address).unwrap_err().to_string();
        assert!(refused.contains("does not answer") && refused.contains(&address), "{refused}");
    }

    #[test]
    fn a_device_that_is_not_there_is_named() {
        let refused = LineListener::device(Path::new("/dev/no-such-receiver")).unwrap_err().to_string();
        assert!(refused.contains("/dev/no-such-receiver"), "{refused}");
    }

    #[test]
    fn lines_without_end_and_too_many_lines_take_no_more_memory() {
        let (kept, over) = (Mutex::new(VecDeque::new()), AtomicBool::new(false));
        read_lines(io::repeat(b'x').take(1_000_000).chain(&b"\n"[..]), &kept, &over);
        assert_eq!(kept.lock().unwrap().pop_front().unwrap().0.len(), LONGEST_LINE);
        read_lines(&b"a\n".repeat(1000)[..], &kept, &over);
        assert_eq!(kept.lock().unwrap().len(), MOST_LINES);
    }
}
