//! What can be wrong, and what would work.

use bdtree_runtime::{FormatError, PoseError, QueryError};
use core::fmt;

/// Why bodies cannot be made or moved.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum DynamicsError {
    /// A step that is not positive and finite.
    Step {
        /// It, seconds.
        step_s: f64,
    },
    /// An oscillator that no step moves: a frequency or decay that is negative, not finite or far too high.
    Oscillator {
        /// ω, rad/s.
        omega_rad_s: f64,
        /// γ, 1/s.
        decay_per_s: f64,
        /// Seconds.
        step_s: f64,
    },
    /// A contact stiffness that the step does not resolve.
    TooStiff {
        /// It, N/m.
        newton_per_m: f64,
        /// Seconds.
        step_s: f64,
        /// The longest step for it.
        step_max_s: f64,
        /// The highest stiffness for the step.
        newton_per_m_max: f64,
    },
    /// A setting outside 0 … limit.
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The largest value.
        limit: f64,
    },
    /// A mode without frequency or modal mass.
    NoFrequency {
        /// The mode.
        mode: usize,
    },
    /// An asset with a skin: its bones move it.
    Skin,
    /// A body without mass properties.
    NoMass,
    /// Mass properties that no body has.
    Mass,
    /// A free body with a mode of a held one: it moves the center of mass or turns the body.
    HeldMode {
        /// The mode.
        mode: usize,
    },
    /// A placement with another scale than the body model's.
    Scale {
        /// The placement's.
        scale: f64,
        /// The model's.
        expected: f64,
    },
    /// A force, an impulse or a state that is not finite.
    NotFinite {
        /// What.
        what: &'static str,
    },
    /// A q that is not below the strain limit.
    Limit {
        /// The mode.
        mode: usize,
        /// q.
        q: f64,
        /// The limit.
        limit: f64,
    },
    /// Another number of values than the asset has modes.
    ModeCount {
        /// As many as the asset has.
        expected: usize,
        /// As many as were given.
        found: usize,
    },
    /// Two spheres overlap by more than the larger one's radius, a sphere and a triangle by more than the diameter, or two exact
    /// surfaces by more than the thinner wall: the step is too long for their speed.
    Penetration {
        /// The bodies; the second is `None` for a plane.
        bodies: [Option<usize>; 2],
        /// Overlap, world units.
        depth: f64,
        /// The most that they may overlap by.
        limit: f64,
        /// About the step that would do, seconds.
        step_max_s: f64,
    },
    /// A triangle with nothing behind it, or another one at no distance, of a body whose contact regions need an inside.
    NoInside {
        /// The triangle.
        triangle: usize,
    },
    /// Bodies so fast for their walls that a step would need too many parts.
    Parts {
        /// Thickness of the thinnest wall, world units.
        wall: f64,
        /// The most parts of a step.
        limit: u32,
        /// About the step that would do, seconds.
        step_max_s: f64,
    },
    /// A level that the tree does not have.
    Level {
        /// It.
        level: usize,
        /// Number of levels.
        depth: usize,
    },
    /// A body or model that the world does not have.
    Unknown {
        /// What it is: `body`, `model`.
        what: &'static str,
        /// Its number.
        index: usize,
    },
    /// Bytes that are not a saved state of this world.
    State {
        /// What is wrong.
        what: &'static str,
    },
    /// A damaged asset.
    Format(FormatError),
    /// A pose that the asset refuses.
    Pose(PoseError),
    /// A query that failed.
    Query(QueryError),
}

impl fmt::Display for DynamicsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step { step_s } => {
                write!(
                    f,
                    "a step of {step_s} s is not positive and finite; 1/150 s would do"
                )
            }
            Self::Oscillator {
                omega_rad_s,
                decay_per_s,
                step_s,
            } => write!(
                f,
                "a mode of {omega_rad_s} rad/s that decays at {decay_per_s}/s cannot be moved by steps of {step_s} s: both must \
                 be finite, not negative and, times the step, at most 1e6"
            ),
            Self::TooStiff {
                newton_per_m,
                step_s,
                step_max_s,
                newton_per_m_max,
            } => write!(
                f,
                "steps of {step_s} s are too long for contacts of {newton_per_m} N/m; use steps of at most {step_max_s:.3e} s, or at \
                 most {newton_per_m_max:.3e} N/m"
            ),
            Self::Setting { name, value, limit } => {
                write!(f, "{name}: {value} is not between 0 and {limit}")
            }
            Self::NoFrequency { mode } => write!(
                f,
                "mode {mode} has no frequency and modal mass, so that nothing says how it moves; bake the mesh with elastic modes \
                 (bdtree-build MESH --modes N), or a simulation mesh with --tets, or drive the body (Frame::Driven)"
            ),
            Self::Skin => write!(
                f,
                "the asset has a skin: contact spheres do not follow bones; bake the mesh without one, as OBJ or PLY for example"
            ),
            Self::NoMass => write!(
                f,
                "the asset has no mass properties; bake it from a closed mesh, or an open one with elastic modes and --thickness, \
                 or give the mass properties with the body"
            ),
            Self::Mass => write!(
                f,
                "mass properties: mass and inertia must be finite and positive, the center finite, the inertia symmetric"
            ),
            Self::HeldMode { mode } => write!(
                f,
                "mode {mode} is one of a held body: it moves the center of mass or turns the body; hold the body (Frame::Held), or \
                 bake it without --fix"
            ),
            Self::Scale { scale, expected } => write!(
                f,
                "the placement has the scale {scale}, the body model {expected}; both must be the same"
            ),
            Self::NotFinite { what } => write!(f, "{what}: not finite"),
            Self::Limit { mode, q, limit } => write!(
                f,
                "mode {mode}: q = {q} is not below the strain limit of {limit}"
            ),
            Self::ModeCount { expected, found } => {
                write!(f, "{found} values for the {expected} modes of the asset")
            }
            Self::Penetration {
                bodies,
                depth,
                limit,
                step_max_s,
            } => {
                let [first, second] = bodies;
                match (first, second) {
                    (Some(a), Some(b)) => write!(f, "bodies {a} and {b} overlap")?,
                    (Some(a), None) | (None, Some(a)) => write!(f, "body {a} and a plane overlap")?,
                    (None, None) => write!(f, "two bodies overlap")?,
                }
                write!(
                    f,
                    " by {depth:.3e}, more than the {limit:.3e} that their contact shapes allow; use steps of about {step_max_s:.1e} s, \
                     lower speeds or a lower level"
                )
            }
            Self::NoInside { triangle } => write!(
                f,
                "triangle {triangle} has nothing behind it, or another one at no distance: regions of contact need a closed surface whose triangles are \
                 counterclockwise as seen from outside; ContactShape::Triangles takes open ones too"
            ),
            Self::Parts {
                wall,
                limit,
                step_max_s,
            } => write!(
                f,
                "bodies move so fast that what is left of a step needs more than {limit} parts for the thinnest wall of {wall:.3e}; use steps of \
                 about {step_max_s:.1e} s, lower speeds, or BodyOptions::thinnest_wall where sharp edges are thin"
            ),
            Self::Level { level, depth } => {
                write!(
                    f,
                    "level {level}: the tree has levels 0 to {}",
                    depth.saturating_sub(1)
                )
            }
            Self::Unknown { what, index } => write!(f, "{what} {index}: there is none"),
            Self::State { what } => write!(f, "not a saved state of this world: {what}"),
            Self::Format(error) => error.fmt(f),
            Self::Pose(error) => error.fmt(f),
            Self::Query(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for DynamicsError {}

impl From<FormatError> for DynamicsError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}

impl From<PoseError> for DynamicsError {
    fn from(error: PoseError) -> Self {
        Self::Pose(error)
    }
}

impl From<QueryError> for DynamicsError {
    fn from(error: QueryError) -> Self {
        Self::Query(error)
    }
}
