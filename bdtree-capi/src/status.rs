//! What functions return, and the words to it.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, c_char};
use std::fmt;

use bdtree_dynamics::DynamicsError;
use bdtree_runtime::{FormatError, LoadError, PoseError, QueryError, SampleError, SkeletonError};

use crate::border::{Out, call};
use crate::sink::put_text;

/// What a function returns: 0 when all went well, above 0 when the answer is not whole, below 0 when there is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(i32)]
pub enum BdtStatus {
    /// All went well.
    Ok = 0,
    /// The array is too short: it holds as many items as fit, and the count says how many there are.
    Truncated = 1,
    /// A callback has ended the query.
    Stopped = 2,
    /// A pointer is NULL that must not be.
    ErrorNull = -1,
    /// A handle of another kind, one that was freed, or an address that is none.
    ErrorHandle = -2,
    /// The handle is used by a call under way: the function was called from a callback, by two threads at a time, or
    /// with the same handle twice.
    ErrorBusy = -3,
    /// An argument is NaN, infinite, too large, negative where it must not be, not aligned, not UTF-8, or unknown.
    ErrorArgument = -4,
    /// Another number of values than the model, body or clip has.
    ErrorLength = -5,
    /// There is no such triangle, vertex, mode, bone, clip, frame, name, body or model.
    ErrorIndex = -6,
    /// A file cannot be opened or read.
    ErrorIo = -7,
    /// Bytes that break a rule of the format: no .bdt file, or a damaged one.
    ErrorFormat = -8,
    /// A q that is not finite or beyond the limit, a placement or matrix that is not allowed.
    ErrorPose = -9,
    /// The model has no skin, so neither bones nor clips.
    ErrorNoSkin = -10,
    /// The model has no animation, or one without times.
    ErrorNoAnimation = -11,
    /// A world, model or body cannot be made or moved like this.
    ErrorDynamics = -12,
    /// The step is too long for the speed of bodies: the world is not to be stepped on.
    ErrorStep = -13,
    /// Bytes that are not a saved state of this world.
    ErrorState = -14,
    /// A mistake of the library's own, which ended the call. Please report it. Free the handles of the call.
    ErrorPanic = -15,
}

impl BdtStatus {
    /// All of them.
    pub const ALL: [Self; 18] = [
        Self::Ok,
        Self::Truncated,
        Self::Stopped,
        Self::ErrorNull,
        Self::ErrorHandle,
        Self::ErrorBusy,
        Self::ErrorArgument,
        Self::ErrorLength,
        Self::ErrorIndex,
        Self::ErrorIo,
        Self::ErrorFormat,
        Self::ErrorPose,
        Self::ErrorNoSkin,
        Self::ErrorNoAnimation,
        Self::ErrorDynamics,
        Self::ErrorStep,
        Self::ErrorState,
        Self::ErrorPanic,
    ];

    fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"ok",
            Self::Truncated => c"the array is too short for the answer",
            Self::Stopped => c"a callback has ended the query",
            Self::ErrorNull => c"a pointer is NULL",
            Self::ErrorHandle => c"not a handle of this kind, or one that was freed",
            Self::ErrorBusy => c"the handle is used by a call under way",
            Self::ErrorArgument => c"an argument is not allowed",
            Self::ErrorLength => c"another number of values is needed",
            Self::ErrorIndex => c"there is no such item",
            Self::ErrorIo => c"a file cannot be read",
            Self::ErrorFormat => c"not a .bdt file, or a damaged one",
            Self::ErrorPose => c"a q, placement or matrix is not allowed",
            Self::ErrorNoSkin => c"the model has no skin",
            Self::ErrorNoAnimation => c"the model has no animation with times",
            Self::ErrorDynamics => c"the world or body cannot be made or moved like this",
            Self::ErrorStep => c"the step is too long for the speed of bodies",
            Self::ErrorState => c"not a saved state of this world",
            Self::ErrorPanic => c"a mistake of the library's own",
        }
    }
}

/// Why a function gives no answer.
#[derive(Debug)]
pub(crate) enum Fault {
    /// An argument that is NULL.
    Null(&'static str),
    Handle(&'static str),
    Busy(&'static str),
    Unaligned(&'static str),
    /// More values than memory can hold.
    Count(&'static str),
    /// Not UTF-8.
    Text(&'static str),
    Argument(&'static str),
    Length {
        what: &'static str,
        expected: usize,
        found: usize,
    },
    /// No such item.
    Index {
        what: &'static str,
        count: usize,
        found: usize,
    },
    /// No item of this name.
    Name(&'static str),
    NoSkin,
    Load(LoadError),
    Format(FormatError),
    Pose(PoseError),
    Query(QueryError),
    Sample(SampleError),
    Skeleton(SkeletonError),
    Dynamics(DynamicsError),
    Panic(String),
}

macro_rules! fault_from {
    ($($variant:ident: $type:ty),+) => {$(
        impl From<$type> for Fault {
            fn from(error: $type) -> Self {
                Self::$variant(error)
            }
        }
    )+};
}
fault_from!(
    Load: LoadError,
    Format: FormatError,
    Pose: PoseError,
    Query: QueryError,
    Sample: SampleError,
    Skeleton: SkeletonError,
    Dynamics: DynamicsError
);

impl Fault {
    /// What a panic says.
    pub(crate) fn of_panic(payload: &(dyn Any + Send)) -> Self {
        let text = (payload.downcast_ref::<&str>().copied())
            .or_else(|| payload.downcast_ref::<String>().map(String::as_str));
        Self::Panic(text.unwrap_or("without a text").to_string())
    }

    fn status(&self) -> BdtStatus {
        match self {
            Self::Null(_) => BdtStatus::ErrorNull,
            Self::Handle(_) => BdtStatus::ErrorHandle,
            Self::Busy(_) => BdtStatus::ErrorBusy,
            Self::Unaligned(_) | Self::Count(_) | Self::Text(_) | Self::Argument(_) => {
                BdtStatus::ErrorArgument
            }
            Self::Length { .. } => BdtStatus::ErrorLength,
            Self::Index { .. } | Self::Name(_) => BdtStatus::ErrorIndex,
            Self::NoSkin => BdtStatus::ErrorNoSkin,
            Self::Load(LoadError::Io { .. }) => BdtStatus::ErrorIo,
            Self::Load(_) | Self::Format(_) => BdtStatus::ErrorFormat,
            Self::Pose(error) => of_pose(error),
            Self::Query(error) => of_query(error),
            Self::Sample(error) => match error {
                SampleError::NoFrames | SampleError::NoTimes => BdtStatus::ErrorNoAnimation,
                SampleError::NoFrame { .. } => BdtStatus::ErrorIndex,
                SampleError::ModeCount { .. } => BdtStatus::ErrorLength,
                _ => BdtStatus::ErrorArgument,
            },
            Self::Skeleton(error) => match error {
                SkeletonError::NoSkin => BdtStatus::ErrorNoSkin,
                SkeletonError::NoClip { .. } => BdtStatus::ErrorIndex,
                SkeletonError::Length { .. } => BdtStatus::ErrorLength,
                SkeletonError::Corrupt(_) => BdtStatus::ErrorFormat,
                _ => BdtStatus::ErrorArgument,
            },
            Self::Dynamics(error) => match error {
                DynamicsError::ModeCount { .. } => BdtStatus::ErrorLength,
                DynamicsError::Unknown { .. } => BdtStatus::ErrorIndex,
                DynamicsError::State { .. } => BdtStatus::ErrorState,
                DynamicsError::Penetration { .. } | DynamicsError::Parts { .. } => {
                    BdtStatus::ErrorStep
                }
                DynamicsError::Format(_) => BdtStatus::ErrorFormat,
                DynamicsError::Pose(error) => of_pose(error),
                DynamicsError::Query(error) => of_query(error),
                _ => BdtStatus::ErrorDynamics,
            },
            Self::Panic(_) => BdtStatus::ErrorPanic,
        }
    }
}

fn of_pose(error: &PoseError) -> BdtStatus {
    match error {
        PoseError::ModeCount { .. }
        | PoseError::JointCount { .. }
        | PoseError::BoneCount { .. } => BdtStatus::ErrorLength,
        PoseError::NoSkin => BdtStatus::ErrorNoSkin,
        _ => BdtStatus::ErrorPose,
    }
}

fn of_query(error: &QueryError) -> BdtStatus {
    match error {
        QueryError::Corrupt(_) => BdtStatus::ErrorFormat,
        _ => BdtStatus::ErrorArgument,
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null(what) => write!(f, "{what} is NULL"),
            Self::Handle(what) => write!(
                f,
                "{what}: not a handle of this kind, or one that was freed"
            ),
            Self::Busy(what) => write!(
                f,
                "{what}: in use by a call under way (a callback, another thread, or the same handle twice)"
            ),
            Self::Unaligned(what) => write!(f, "{what}: the address is not aligned"),
            Self::Count(what) => write!(f, "{what}: more than memory can hold"),
            Self::Text(what) => write!(f, "{what}: not UTF-8"),
            Self::Argument(what) => f.write_str(what),
            Self::Length {
                what,
                expected,
                found,
            } => write!(f, "{found} {what} are given, {expected} are needed"),
            Self::Index { what, count, found } => {
                write!(f, "there is no {what} {found}: there are {count}")
            }
            Self::Name(what) => write!(f, "there is no {what} of this name"),
            Self::NoSkin => f.write_str("the model has no skin"),
            Self::Load(error) => error.fmt(f),
            Self::Format(error) => error.fmt(f),
            Self::Pose(error) => error.fmt(f),
            Self::Query(error) => error.fmt(f),
            Self::Sample(error) => error.fmt(f),
            Self::Skeleton(error) => error.fmt(f),
            Self::Dynamics(error) => error.fmt(f),
            Self::Panic(text) => write!(f, "a mistake of the library's own: {text}"),
        }
    }
}

thread_local! {
    static LAST: RefCell<Option<Fault>> = const { RefCell::new(None) };
}

/// Keeps what went wrong for `bdt_last_error`; what to return.
#[cold]
pub(crate) fn remember(fault: Fault) -> BdtStatus {
    let status = fault.status();
    // A thread that ends has nobody who would ask.
    let _ = LAST.try_with(|last| last.replace(Some(fault)));
    status
}

/// Returns what a status means, in a few words: a static text, never NULL, also for numbers that are no status.
/// Thread-safety: any thread, any time.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_status_text(status: i32) -> *const c_char {
    let known = BdtStatus::ALL
        .into_iter()
        .find(|known| *known as i32 == status);
    known
        .map_or(c"not a status of this library", BdtStatus::text)
        .as_ptr()
}

/// Writes what went wrong in this thread's last call that returned an error: one line of UTF-8 that names the argument,
/// or file, rule and place. `buffer` gets at most `capacity` bytes, the closing 0 included; `length` (may be NULL) the
/// bytes of the whole text without the 0. The text is empty before the first error; calls that succeed leave it.
/// Ownership: `buffer` is yours. Errors: `BDT_STATUS_TRUNCATED` (the text was cut), `BDT_STATUS_ERROR_NULL`.
/// Thread-safety: any thread; each has its own text.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_last_error(
    mut buffer: Out<c_char>,
    capacity: usize,
    mut length: Out<usize>,
) -> BdtStatus {
    let text = LAST.try_with(|last| last.borrow().as_ref().map(Fault::to_string));
    let text = text.ok().flatten().unwrap_or_default();
    call(|| put_text(&text, &mut buffer, capacity, &mut length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::border::call;

    #[test]
    fn a_panic_is_an_error() {
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let status = call(|| panic!("on purpose"));
        std::panic::set_hook(hook);
        assert_eq!(status, BdtStatus::ErrorPanic);
        let text = LAST.with(|last| last.borrow().as_ref().map(Fault::to_string));
        assert!(text.is_some_and(|text| text.ends_with("on purpose")));
    }
}
