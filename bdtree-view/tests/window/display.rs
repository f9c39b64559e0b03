//! A virtual display: Xvfb, whose memory is a file.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// How long anything may take on a machine with much else to do.
pub(crate) const PATIENCE: Duration = Duration::from_secs(180);

/// Width and height of the display.
pub(crate) const DISPLAY: [u32; 2] = [1100, 760];

/// A display of its own, gone when dropped.
pub(crate) struct Display {
    server: Child,
    pub(crate) name: String,
    folder: TempDir,
}

impl Display {
    /// Starts one.
    ///
    /// # Panics
    /// Where Xvfb is missing or does not start.
    pub(crate) fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let [width, height] = DISPLAY;
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0"])
            .arg(format!("{width}x{height}x24"))
            .arg("-fbdir")
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb: scripts/test.sh installs it (Debian: apt-get install xvfb)");
        let mut line = String::new();
        let stdout = server.stdout.take().expect("piped");
        BufReader::new(stdout)
            .read_line(&mut line)
            .expect("Xvfb's display number");
        let number: u32 = line.trim().parse().expect("Xvfb says which display it is");
        Self {
            server,
            name: format!(":{number}"),
            folder,
        }
    }

    /// The viewer on this display.
    pub(crate) fn viewer(&self) -> Command {
        self.program(env!("CARGO_BIN_EXE_bdtree-view"))
    }

    /// The playground on this display.
    pub(crate) fn playground(&self) -> Command {
        self.program(env!("CARGO_BIN_EXE_bdtree-playground"))
    }

    /// A command that runs on this display, with a runtime folder, which Mesa asks for.
    fn program(&self, path: &str) -> Command {
        let mut command = Command::new(path);
        command
            .env("DISPLAY", &self.name)
            .env_remove("WAYLAND_DISPLAY")
            .env("XDG_RUNTIME_DIR", self.folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// What is on the screen now: the framebuffer, in XWD's format.
    pub(crate) fn screen(&self) -> Picture {
        let path: PathBuf = self.folder.path().join("Xvfb_screen0");
        let bytes = fs::read(path).expect("the framebuffer");
        let word = |k: usize| {
            let bytes: [u8; 4] = bytes[4 * k..4 * k + 4].try_into().expect("four bytes");
            u32::from_be_bytes(bytes) as usize
        };
        let (header, width, height) = (word(0), word(4), word(5));
        let (bits, row, colours) = (word(11), word(12), word(19));
        assert_eq!((word(1), bits), (7, 32), "XWD 7 of 32 bits per pixel");
        assert_eq!([width as u32, height as u32], DISPLAY);
        let is_little = word(7) == 0;
        let pixels = &bytes[header + 12 * colours..];
        let pixel = |x: usize, y: usize| {
            let at = y * row + 4 * x;
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| pixels[at + k]);
            if is_little { [c, b, a] } else { [b, c, d] }
        };
        let rows = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Picture {
            size: DISPLAY,
            pixels: rows.map(|(x, y)| pixel(x, y)).collect(),
        }
    }

    /// The screen as soon as `is_ready` says so of it.
    ///
    /// # Panics
    /// When that takes too long or the viewer has ended.
    #[track_caller]
    pub(crate) fn wait_for(
        &self,
        viewer: &mut Running,
        mut is_ready: impl FnMut(&Picture) -> bool,
    ) -> Picture {
        let begin = Instant::now();
        loop {
            let picture = self.screen();
            if is_ready(&picture) {
                return picture;
            }
            if let Some(status) = viewer.0.try_wait().expect("a state") {
                let mut errors = String::new();
                let stderr = viewer.0.stderr.as_mut().expect("piped");
                stderr.read_to_string(&mut errors).expect("UTF-8");
                panic!("the viewer has ended: {status}: {errors}");
            }
            assert!(begin.elapsed() < PATIENCE, "not drawn in {PATIENCE:?}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A viewer that is running, ended when dropped.
pub(crate) struct Running(pub(crate) Child);

impl Running {
    /// What is left of it when it has ended.
    ///
    /// # Panics
    /// When that takes too long.
    pub(crate) fn output(mut self) -> Output {
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = self.0.try_wait().expect("a state") {
                break status;
            }
            assert!(
                begin.elapsed() < PATIENCE,
                "it does not end in {PATIENCE:?}"
            );
            std::thread::sleep(Duration::from_millis(50));
        };
        let mut output = Output {
            status,
            stdout: Vec::new(),
            stderr: Vec::new(),
        };
        let (out, err) = (self.0.stdout.take(), self.0.stderr.take());
        out.expect("piped")
            .read_to_end(&mut output.stdout)
            .expect("read");
        err.expect("piped")
            .read_to_end(&mut output.stderr)
            .expect("read");
        output
    }

    /// Waits until it draws nothing more: controls come to rest, then it uses no time of the processor.
    ///
    /// # Panics
    /// When that takes too long.
    pub(crate) fn wait_for_rest(&self) {
        let begin = Instant::now();
        let mut before = self.cpu_ticks();
        loop {
            std::thread::sleep(Duration::from_secs(1));
            let now = self.cpu_ticks();
            if now - before <= 2 {
                break;
            }
            before = now;
            assert!(begin.elapsed() < PATIENCE, "it never rests");
        }
    }

    /// Time of the processor that it has used, in hundredths of a second.
    fn cpu_ticks(&self) -> u64 {
        let path = format!("/proc/{}/stat", self.0.id());
        let text = fs::read_to_string(path).expect("a process of Linux");
        // After the name in parentheses: state, …; the 14th and 15th fields of all are user and system.
        let (_, fields) = text.rsplit_once(')').expect("a name");
        let fields: Vec<&str> = fields.split_whitespace().collect();
        let ticks = fields[11..13]
            .iter()
            .map(|n| n.parse::<u64>().expect("a number"));
        ticks.sum()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Pixels, row after row.
#[derive(Clone, PartialEq)]
pub(crate) struct Picture {
    pub(crate) size: [u32; 2],
    pub(crate) pixels: Vec<[u8; 3]>,
}

impl Picture {
    /// Of a PNG file.
    pub(crate) fn load(path: &std::path::Path) -> Self {
        let file = fs::File::open(path).expect("the picture");
        let mut reader = png::Decoder::new(BufReader::new(file))
            .read_info()
            .expect("a PNG");
        let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
        let info = reader.next_frame(&mut bytes).expect("a picture");
        assert_eq!(info.color_type, png::ColorType::Rgb, "an opaque picture");
        let pixels = bytes[..info.buffer_size()].as_chunks::<3>().0;
        Self {
            size: [info.width, info.height],
            pixels: pixels.to_vec(),
        }
    }

    pub(crate) fn at(&self, x: u32, y: u32) -> [u8; 3] {
        self.pixels[(y * self.size[0] + x) as usize]
    }

    /// The share of a rectangle's pixels (left, top, right, bottom) that are as asked.
    pub(crate) fn share(
        &self,
        [left, top, right, bottom]: [u32; 4],
        is: impl Fn([u8; 3]) -> bool,
    ) -> f64 {
        let all = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        let count = all.filter(|(x, y)| is(self.at(*x, *y))).count();
        count as f64 / f64::from((right - left) * (bottom - top))
    }

    /// The share of a rectangle's pixels that differ between two pictures.
    pub(crate) fn difference(&self, other: &Self, [left, top, right, bottom]: [u32; 4]) -> f64 {
        let all = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
        let differ = all
            .filter(|(x, y)| self.at(*x, *y) != other.at(*x, *y))
            .count();
        differ as f64 / f64::from((right - left) * (bottom - top))
    }
}
