//! The viewer without its window: what is shown, and what is known of it.

mod clips;
mod clock;
mod playback;
mod probe;
mod view;

pub use bdtree_render::Place;
pub use clips::{ClipName, Clips};
pub use clock::Clock;
pub use playback::Playback;
pub use probe::{Answer, Asker, Probe};
pub use view::{Grab, View};

use bdtree_render::tightness::{Scale, growth, mean_and_max};
use bdtree_render::{Framing, Level, NodeSphere};
use bdtree_runtime::{
    Asset, CacheSize, Instance, JointMatrix, Pose, PoseError, StoredToWorld, Transform,
};
use bdtree_tools::deform::deformed;
use bdtree_tools::info::Info;
use bdtree_tools::{AssetFile, Posture, ToolError};

/// Moments of a clip or an animation that the first camera sees all of, besides the first; and how much farther away it
/// stands for them at most.
const MOMENTS: usize = 32;
const FAR: f32 = 4.0;

/// Radius of the first probe over the object's size.
const PROBE_SIZE: f64 = 0.15;

/// How far q's sliders go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// To `q_range`: what is typical.
    Range,
    /// To `q_limit`: what the file allows.
    Limit,
}

/// The spheres of a level, the leaves above it, and their growth.
#[derive(Debug, Clone, Default)]
pub struct Spheres {
    /// Those that bound something.
    pub spheres: Vec<NodeSphere>,
    /// R′/R of each.
    pub growths: Vec<f64>,
    /// Mean and largest, `None` of none.
    pub mean_and_max: Option<[f64; 2]>,
}

/// The state of the viewer.
pub struct App<'a> {
    /// The file.
    pub file: &'a AssetFile,
    /// As the view wants it to be, from the last [`App::refresh`] or [`App::fit`] on.
    body: Instance,
    /// What the file holds.
    pub info: Info,
    /// Where things are drawn.
    pub place: Place,
    /// What points up in the picture of the first camera, unit.
    pub up: [f32; 3],
    /// What is shown.
    pub view: View,
    /// The animation.
    pub playback: Playback,
    /// The clips of the skeleton.
    pub clips: Clips,
    /// How far sliders go.
    pub reach: Reach,
    /// What the mouse holds.
    pub grab: Option<Grab>,
    /// Spheres of the level.
    pub spheres: Result<Spheres, String>,
    /// Lines from joints to those above them (world), if they are shown.
    pub bones: Vec<[[f64; 3]; 2]>,
    /// What the probe found.
    pub answer: Option<Result<Answer, String>>,
    asker: Asker,
    known: Option<View>,
}

impl<'a> App<'a> {
    /// A file's asset in a posture.
    ///
    /// # Errors
    /// A posture that the asset refuses, a corrupt asset.
    pub fn new(file: &'a AssetFile, posture: Posture) -> Result<Self, ToolError> {
        let asset = file.asset();
        let body = Instance::with_cache(file.model(), CacheSize::NONE);
        let mut body = body.map_err(|error| refused(file, error))?;
        let posed = body.set_pose_with_bones(&posture.q, posture.bones(), posture.transform);
        posed.map_err(|error| refused(file, error))?;
        let place = Place::around(positions(file, &body.pose())?);
        let mut center = place.middle;
        // Beside the middle, where of most objects the surface is.
        center[1] += 0.5 * place.size;
        Ok(Self {
            file,
            body,
            info: Info::of(file)?,
            place,
            up: [0.0, 1.0, 0.0],
            view: View {
                q: posture.q,
                joints: posture.joints.unwrap_or_default(),
                transform: posture.transform,
                has_mesh: true,
                has_bones: false,
                level: None,
                scale: Scale::Paper,
                opacity: 0.35,
                has_probe: false,
                probe: Probe {
                    center,
                    radius: PROBE_SIZE * place.size,
                },
                has_ends: true,
                camera: None,
            },
            playback: Playback::new(asset),
            clips: Clips::new(asset),
            reach: Reach::Range,
            grab: None,
            spheres: Ok(Spheres::default()),
            bones: Vec::new(),
            answer: None,
            asker: Asker::new(asset),
            known: None,
        })
    }

    /// Its view.
    pub fn asset(&self) -> &'a Asset<'a> {
        self.file.asset()
    }

    /// The largest |q_j| of a slider.
    pub fn slider_end(&self, mode: usize) -> f32 {
        let Some(record) = self.asset().modes().get(mode) else {
            return 0.0;
        };
        match self.reach {
            Reach::Range => record.q_range.get(),
            Reach::Limit => record.q_limit.get(),
        }
    }

    /// Undeformed, where the mesh stands; a clip goes on carrying it.
    pub fn zero(&mut self) {
        self.view.q.fill(0.0);
        if self.clips.chosen.is_none() {
            self.view.joints.clear();
        }
        self.view.transform = Transform::IDENTITY;
        self.playback.clock.is_playing = false;
        self.clips.clock.is_playing = false;
    }

    /// Shows the animation's moment.
    pub fn show_moment(&mut self) {
        if let Some((q, transform)) = self.playback.posture(self.asset()) {
            self.view.q = q;
            self.view.transform = transform;
        }
    }

    /// Whether what is shown is the animation's moment, and not q of the sliders or of the command line.
    pub fn shows_moment(&self) -> bool {
        let moment = self.playback.posture(self.asset());
        moment.is_some_and(|(q, at)| (&q, at) == (&self.view.q, self.view.transform))
    }

    /// Goes to a moment of a clip, which begins and ends with its keys.
    pub fn begin_clip(&mut self, clip: usize, time_s: f64, is_playing: bool) {
        self.clips.choose(Some(clip));
        self.clips.clock.time_s = time_s.clamp(0.0, self.clips.duration_s());
        self.clips.clock.is_playing = is_playing;
    }

    /// True if joints carry the mesh that are no clip's.
    pub fn has_given_joints(&self) -> bool {
        self.clips.chosen.is_none() && !self.view.joints.is_empty()
    }

    /// Shows the clip's moment: its joints, and of q what it moves; the rest of q stays as sliders have it. One that
    /// cannot be shown changes nothing.
    pub fn show_clip(&mut self) {
        let mut q = self.view.q.clone();
        self.clips.problem = match self.clips.moment(self.file.asset(), &mut q) {
            Ok(joints) => {
                (self.view.q, self.view.joints) = (q, joints);
                None
            }
            Err(error) => Some(error.to_string()),
        };
    }

    /// Plays or halts: the chosen clip, or else the animation.
    pub fn toggle(&mut self) {
        match self.clips.chosen {
            Some(_) => self.clips.clock.is_playing = !self.clips.clock.is_playing,
            None => {
                let was_playing = self.playback.clock.is_playing;
                self.playback.clock.is_playing = !was_playing && self.playback.frame_count() > 1;
            }
        }
    }

    /// Whether something moves by itself.
    pub fn is_playing(&self) -> bool {
        self.playback.clock.is_playing || self.clips.clock.is_playing
    }

    /// Lets time pass.
    pub fn advance(&mut self, dt_s: f64) {
        if self.clips.advance(dt_s) {
            self.show_clip();
        }
        if self.playback.advance(dt_s) {
            self.show_moment();
        }
    }

    /// Puts the camera where all of the mesh, the level's spheres, the probe and the spheres in which its query ended are
    /// seen in a picture of `aspect`; mesh and level also at the moments that can be played, if they are not far away.
    ///
    /// # Errors
    /// q that the asset refuses, a corrupt asset.
    pub fn fit(&mut self, aspect: f32) -> Result<(), ToolError> {
        self.pose()?;
        let mut framing = View::framing(aspect, self.up);
        self.hold(&mut framing)?;
        let probe = self.view.probe;
        if self.view.has_probe {
            framing.hold(probe.center, probe.radius);
        }
        // What is known of them may be of another q.
        if self.view.has_probe
            && self.view.has_ends
            && let Ok(answer) = self.asker.ask(&self.body.pose(), probe)
        {
            let ends = answer.ends.iter();
            ends.for_each(|s| framing.hold(s.center, s.radius));
        }
        let alone = framing.camera(&self.place);
        for moment in self.moments() {
            let Posture { q, transform, .. } = &moment;
            let posed = self.body.set_pose_with_bones(q, moment.bones(), *transform);
            // What the asset refuses is not shown either.
            if posed.is_ok() {
                self.hold(&mut framing)?;
            }
        }
        self.pose()?;
        let all = framing.camera(&self.place);
        // Of a mesh that flies away nothing would be seen.
        let is_far = all.distance() > FAR * alone.distance();
        self.view.camera = Some(if is_far { alone } else { all });
        Ok(())
    }

    /// Makes the body be as the view wants it.
    fn pose(&mut self) -> Result<(), ToolError> {
        let View { q, transform, .. } = &self.view;
        let bones = self.view.bones();
        let posed = self.body.set_pose_with_bones(q, bones, *transform);
        posed.map_err(|error| refused(self.file, error))
    }

    /// Makes a picture hold the mesh as it is posed, and the level's spheres.
    fn hold(&self, framing: &mut Framing) -> Result<(), ToolError> {
        for p in positions(self.file, &self.body.pose())? {
            framing.hold(p, 0.0);
        }
        if let Some(level) = self.view.level
            && let Ok(found) = Spheres::of(&self.body.pose(), level)
        {
            let spheres = found.spheres.iter();
            spheres.for_each(|s| framing.hold(s.center, s.radius));
        }
        Ok(())
    }

    /// What the space bar plays, from beginning to end: the chosen clip, or else the animation.
    fn moments(&self) -> Vec<Posture> {
        let asset = self.asset();
        let posture = |q, joints: Vec<JointMatrix>, transform| Posture {
            q,
            joints: (!joints.is_empty()).then_some(joints),
            transform,
        };
        if self.clips.chosen.is_some() {
            let mut clips = self.clips.clone();
            let at = |k: usize| {
                clips.clock.time_s = k as f64 / MOMENTS as f64 * clips.duration_s();
                let mut q = self.view.q.clone();
                let joints = clips.moment(asset, &mut q).ok()?;
                Some(posture(q, joints, self.view.transform))
            };
            return (0..=MOMENTS).filter_map(at).collect();
        }
        let last = self.playback.frame_count().saturating_sub(1);
        let steps = last.clamp(1, MOMENTS);
        let at = |k: usize| {
            let frame = asset.frame(k * last / steps)?;
            let joints = self.view.joints.clone();
            Some(posture(frame.q().to_vec(), joints, frame.transform()))
        };
        (0..=steps).filter_map(at).collect()
    }

    /// Finds anew what has changed since the last call, and returns whether anything has.
    pub fn refresh(&mut self) -> bool {
        let view = &self.view;
        let known = self.known.as_ref();
        let is_posed = known.is_some_and(|k| k.is_posed_as(view));
        let has_bones = is_posed && known.is_some_and(|k| k.has_bones == view.has_bones);
        let has_level = is_posed && known.is_some_and(|k| k.level == view.level);
        let is_asked = is_posed
            && known.is_some_and(|k| (k.has_probe, k.probe) == (view.has_probe, view.probe));
        if has_level && is_asked && has_bones {
            return false;
        }
        let posed = self
            .body
            .set_pose_with_bones(&view.q, view.bones(), view.transform);
        let posed = posed.map_err(|error| error.to_string());
        let pose = self.body.pose();
        if !has_bones {
            let lines = match view.has_bones {
                true => clips::bone_lines(pose.asset(), &view.joints),
                false => Ok(Vec::new()),
            };
            let world = model_to_world(pose.asset(), pose.stored_to_world());
            let lines = lines.map(|lines| lines.into_iter().map(|ends| ends.map(&world)).collect());
            self.bones = lines.unwrap_or_else(|error| {
                self.clips.problem = Some(error.to_string());
                Vec::new()
            });
        }
        if !has_level {
            self.spheres = match view.level {
                Some(level) => posed.clone().and_then(|()| Spheres::of(&pose, level)),
                None => Ok(Spheres::default()),
            };
        }
        if !is_asked {
            let asked = view.has_probe.then_some(view.probe);
            self.answer = asked.map(|probe| posed.and_then(|()| self.asker.ask(&pose, probe)));
        }
        self.known = Some(view.clone());
        true
    }
}

impl Spheres {
    /// Those of a level that bound something.
    fn of(pose: &Pose<'_>, level: usize) -> Result<Self, String> {
        let level = Level::of(pose, level);
        let mut spheres = level.map_err(|error| error.to_string())?.spheres;
        // Others say nothing, and every query looks below them.
        spheres.retain(|s| s.radius.is_finite() && s.center.iter().all(|x| x.is_finite()));
        let growths: Vec<f64> = spheres
            .iter()
            .map(|s| growth(s.radius, s.rest_radius))
            .collect();
        Ok(Self {
            mean_and_max: mean_and_max(&growths),
            spheres,
            growths,
        })
    }
}

/// Where a pose puts points of model space (mesh units).
fn model_to_world(asset: &Asset<'_>, map: StoredToWorld) -> impl Fn([f64; 3]) -> [f64; 3] + use<> {
    let (origin, unit) = (asset.origin(), asset.unit());
    let (linear, offset) = (map.linear(), map.offset());
    move |p| {
        let stored = [0, 1, 2].map(|k| (p[k] - origin[k]) / unit);
        let along = |row: [f64; 3]| (0..3).map(|k| row[k] * stored[k]).sum::<f64>();
        [0, 1, 2].map(|k| offset[k] + along(linear[k]))
    }
}

/// A posture that the asset refuses.
fn refused(file: &AssetFile, error: PoseError) -> ToolError {
    ToolError::input(file.path().display(), error)
}

/// The deformed vertices of triangles (world).
fn positions(
    file: &AssetFile,
    pose: &Pose<'_>,
) -> Result<impl Iterator<Item = [f64; 3]> + use<>, ToolError> {
    let all = deformed(file, pose)?;
    let triangles = pose.asset().triangles().iter();
    let corners = triangles.flat_map(|record| record.corners);
    let mut used: Vec<u32> = corners.collect();
    used.sort_unstable();
    used.dedup();
    let of_triangles = used
        .into_iter()
        .filter_map(move |v| all.get(v as usize).copied());
    Ok(of_triangles)
}

#[cfg(test)]
mod tests;
