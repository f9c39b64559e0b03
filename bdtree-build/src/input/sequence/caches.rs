//! Sequences in one file: PC2, MDD (point caches) and NPY.
//!
//! PC2, little-endian: `POINTCACHE2\0`, i32 version 1, i32 points, f32 start frame, f32 frames per
//! sample, i32 samples. MDD, big-endian: i32 frames, i32 points, f32 seconds of every frame. Then
//! x y z of every point of every frame, in f32.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Mutex;

use bdtree_npy::Number;
use sha2::{Digest, Sha256};

use super::data::{FrameData, Order};
use super::{FrameSequence, Places, SUPPORTED, check_vertex_count};
use crate::error::{BakeError, Problems};
use crate::input::{RawMesh, load};
use crate::progress::Progress;

/// Bytes of a .npy file in which its header must end.
const NPY_HEADER_MAX: u64 = 1 << 20;

/// What a header says: where the coordinates are, the frames' seconds, and what is odd.
type Header = (FrameData, Option<Vec<f64>>, Vec<String>);

/// The sequence in the file at `path`, by its extension.
pub(super) fn open(
    path: &Path,
    input: Option<&RawMesh>,
    fps: Option<f64>,
    progress: &dyn Progress,
) -> Result<FrameSequence, BakeError> {
    let place = path.display().to_string();
    let fail = |message: String| BakeError::one("input", path, message);
    let extension = path
        .extension()
        .map(|extension| extension.to_string_lossy().to_lowercase());
    type ReadHeader = fn(File, u64, Option<f64>) -> Result<Header, String>;
    let read_header: ReadHeader = match extension.as_deref() {
        Some("pc2") => pc2,
        Some("mdd") => mdd,
        Some("npy") => npy,
        Some(other) => return Err(fail(format!(".{other} is no animation: {SUPPORTED}"))),
        None => return Err(fail(format!("no file extension: {SUPPORTED}"))),
    };
    let file = File::open(path).map_err(|e| load::unreadable(&place, &e))?;
    let file_bytes = match file.metadata() {
        Ok(meta) if meta.is_file() => meta.len(),
        Ok(_) => return Err(fail("is not a plain file".to_string())),
        Err(error) => return Err(load::unreadable(&place, &error)),
    };
    let (data, times_s, warnings) = read_header(file, file_bytes, fps).map_err(fail)?;
    check_vertex_count(&place, input, data.vertex_count)?;
    if input.is_none() {
        let message = "holds positions but no faces: name the mesh they belong to as INPUT";
        return Err(fail(message.to_string()));
    }
    let mut hash = Sha256::new();
    let mut problems = Problems::new("input");
    let places = Places::File(place.clone());
    data.scan(&mut hash, |t| places.of(t), &mut problems, progress)
        .map_err(|e| load::unreadable(&place, &e))?;
    problems.into_result(path)?;
    let warn = |warning| format!("{place}: {warning}");
    Ok(FrameSequence {
        name: String::new(), // with the path
        hash: hash.finalize().into(),
        times_s,
        first_mesh: None,
        warnings: warnings.into_iter().map(warn).collect(),
        places,
        data,
    })
}

/// `N` bytes at the file's cursor.
fn take<const N: usize>(file: &mut File) -> Result<[u8; N], String> {
    let mut bytes = [0; N];
    match file.read_exact(&mut bytes) {
        Ok(()) => Ok(bytes),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            Err("truncated in the header".to_string())
        }
        Err(error) => Err(format!("cannot be read: {error}")),
    }
}

fn count(what: &str, count: i32) -> Result<usize, String> {
    usize::try_from(count).map_err(|_| format!("the header says {count} {what}"))
}

/// Nothing, if frames of `vertices` points in float32 behind `offset` bytes end where the file
/// does, and there are some.
fn check_size(frames: usize, vertices: usize, offset: u64, file_bytes: u64) -> Result<(), String> {
    // No overflow: both counts were i32.
    let frame = 12 * vertices as u64;
    let need = (frame as u128) * (frames as u128) + u128::from(offset);
    if need == u128::from(file_bytes) {
        return check_some(frames, vertices);
    }
    let says = format!(
        "{frames} frames of {vertices} points need {need} bytes, the file has {file_bytes}"
    );
    if need < u128::from(file_bytes) {
        return Err(format!("has bytes after its last frame: {says}"));
    }
    let whole = file_bytes.saturating_sub(offset) / frame.max(1);
    Err(format!("truncated: {says}, which is {whole} whole frames"))
}

/// Nothing, if there are frames and vertices. In a file of the right size their numbers are then
/// below that of its bytes.
fn check_some(frames: usize, vertices: usize) -> Result<(), String> {
    if frames == 0 || vertices == 0 {
        return Err(format!("holds {frames} frames of {vertices} points"));
    }
    Ok(())
}

fn pc2(mut file: File, file_bytes: u64, fps: Option<f64>) -> Result<Header, String> {
    if &take::<12>(&mut file)? != b"POINTCACHE2\0" {
        return Err("is not a PC2 file (it does not begin with POINTCACHE2)".to_string());
    }
    let version = i32::from_le_bytes(take(&mut file)?);
    if version != 1 {
        return Err(format!("PC2 version {version}; version 1 is read"));
    }
    let vertex_count = count("points", i32::from_le_bytes(take(&mut file)?))?;
    let start = f64::from(f32::from_le_bytes(take(&mut file)?));
    let step = f64::from(f32::from_le_bytes(take(&mut file)?));
    let frame_count = count("frames", i32::from_le_bytes(take(&mut file)?))?;
    check_size(frame_count, vertex_count, 32, file_bytes)?;
    let mut warnings = Vec::new();
    let times_s = match fps {
        Some(_) if !(start.is_finite() && step > 0.0 && step.is_finite()) => {
            warnings.push(format!(
                "starts at frame {start} with {step} frames per sample: the times are not known"
            ));
            None
        }
        Some(fps) => Some(
            (0..frame_count)
                .map(|t| (start + t as f64 * step) / fps)
                .collect(),
        ),
        None => None,
    };
    let data = FrameData {
        file: Mutex::new(file),
        offset: 32,
        number: Number::F4Le,
        order: Order::FrameMajor,
        frame_count,
        vertex_count,
    };
    Ok((data, times_s, warnings))
}

fn mdd(mut file: File, file_bytes: u64, fps: Option<f64>) -> Result<Header, String> {
    let frame_count = count("frames", i32::from_be_bytes(take(&mut file)?))?;
    let vertex_count = count("points", i32::from_be_bytes(take(&mut file)?))?;
    let offset = 8 + 4 * frame_count as u64;
    check_size(frame_count, vertex_count, offset, file_bytes)?;
    let mut times = Vec::with_capacity(frame_count);
    for _ in 0..frame_count {
        times.push(f64::from(f32::from_be_bytes(take(&mut file)?)));
    }
    let mut warnings = Vec::new();
    let times_s = match fps {
        Some(fps) => Some(even_times(frame_count, fps)),
        None => match what_is_odd(&times) {
            Some(odd) => {
                warnings.push(format!("{odd}: the times are not used"));
                None
            }
            None => Some(times),
        },
    };
    let data = FrameData {
        file: Mutex::new(file),
        offset,
        number: Number::F4Be,
        order: Order::FrameMajor,
        frame_count,
        vertex_count,
    };
    Ok((data, times_s, warnings))
}

fn npy(mut file: File, file_bytes: u64, fps: Option<f64>) -> Result<Header, String> {
    let mut bytes = Vec::new();
    (&mut file)
        .take(NPY_HEADER_MAX)
        .read_to_end(&mut bytes)
        .map_err(|e| format!("cannot be read: {e}"))?;
    let header = bdtree_npy::Header::parse(&bytes).map_err(|e| e.to_string())?;
    let &[frame_count, vertex_count, 3] = header.shape.as_slice() else {
        let shape = &header.shape;
        return Err(format!(
            "shape {shape:?} is not (T, N, 3): frames, vertices, axes"
        ));
    };
    let offset = header.data_offset as u64;
    header
        .check_size(file_bytes.saturating_sub(offset))
        .map_err(|e| e.to_string())?;
    check_some(frame_count, vertex_count)?;
    let data = FrameData {
        file: Mutex::new(file),
        offset,
        number: header.number,
        order: if header.fortran {
            Order::FrameMinor
        } else {
            Order::FrameMajor
        },
        frame_count,
        vertex_count,
    };
    let times_s = fps.map(|fps| even_times(frame_count, fps));
    Ok((data, times_s, Vec::new()))
}

/// Seconds of frames at a steady rate, from 0.
pub(super) fn even_times(frame_count: usize, fps: f64) -> Vec<f64> {
    (0..frame_count).map(|t| t as f64 / fps).collect()
}

/// Why times cannot be played back; `None` if they can.
fn what_is_odd(times: &[f64]) -> Option<String> {
    if let Some(t) = times.iter().position(|time| !time.is_finite()) {
        return Some(format!("frame {t} is at {} s", times[t]));
    }
    let t = times.windows(2).position(|pair| pair[1] < pair[0])?;
    Some(format!(
        "frame {} is at {} s, before frame {t} at {} s",
        t + 1,
        times[t + 1],
        times[t]
    ))
}
