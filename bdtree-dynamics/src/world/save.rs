//! The state of a world as bytes, and back: what goes on from there is the same to the bit.
//!
//! Little-endian: magic, version, numbers of bodies, modal numbers, contacts and touches (u64 each), steps, then the bodies,
//! modal numbers, contact forces and touches. Models, planes and options are not in it: the world that restores it has the
//! same.

use alloc::vec::Vec;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::World;
use super::contact::Side;
use super::events::Touch;
use super::sleep::{Change, Rest};
use super::snapshot::Snapshot;
use super::solve::Warm;
use crate::error::DynamicsError;
use crate::frame::FrameState;

const MAGIC: [u8; 8] = *b"BDTWORLD";
const VERSION: u64 = 4;

impl World {
    /// Appends the whole state to `out`.
    pub fn save(&self, out: &mut Vec<u8>) {
        out.extend(MAGIC);
        let counts = [
            VERSION,
            self.bodies.len() as u64,
            self.modal.s.len() as u64,
            self.sorted_warm().count() as u64,
            self.touches.len() as u64,
            self.warm_asleep.len() as u64,
            self.touches_asleep.len() as u64,
            self.steps,
        ];
        for count in counts {
            out.extend(count.to_le_bytes());
        }
        for body in &self.bodies {
            for state in [&body.state, &body.end] {
                put(out, state.position.iter());
                put(out, state.orientation.coords.iter());
                put(out, state.velocity.iter());
                put(out, state.angular_momentum.iter());
            }
            put(out, body.force.iter());
            put(out, body.torque.iter());
            let snapshot = &body.snapshot;
            put(out, snapshot.position.iter());
            put(out, snapshot.orientation.coords.iter());
            put(out, [snapshot.allowance].iter());
            out.extend(u32::from(snapshot.is_brief).to_le_bytes());
            let Rest {
                quiet,
                is_asleep,
                island,
                change,
            } = body.rest;
            for number in [quiet, u32::from(is_asleep), island, change as u32] {
                out.extend(number.to_le_bytes());
            }
        }
        for all in [
            &self.modal.s,
            &self.modal.rate,
            &self.modal.force,
            &self.modal.end_s,
            &self.modal.snapshot_q,
            &self.modal.moved,
        ] {
            put(out, all.iter());
        }
        for warm in self.sorted_warm().chain(&self.warm_asleep) {
            for side in warm.sides {
                out.extend(side.body.to_le_bytes());
                out.extend(side.sphere.to_le_bytes());
            }
            put(out, [warm.normal, warm.late, warm.stiffness].iter());
            put(out, warm.across.iter());
            put(out, warm.along.iter());
        }
        for touch in self.touches.iter().chain(&self.touches_asleep) {
            for side in touch.sides {
                out.extend(side.to_le_bytes());
            }
            put(out, touch.impulse.iter());
        }
    }

    /// Puts the world into a saved state.
    ///
    /// # Errors
    /// Bytes that [`World::save`] has not written, or of a world with other bodies; the world then is as it was.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), DynamicsError> {
        let mut from = Bytes(bytes);
        if from.take::<8>()? != MAGIC {
            return Err(wrong("it does not begin with BDTWORLD"));
        }
        if from.count()? != VERSION {
            return Err(wrong("its version is not 4"));
        }
        if from.count()? != self.bodies.len() as u64 {
            return Err(wrong("it has another number of bodies"));
        }
        if from.count()? != self.modal.s.len() as u64 {
            return Err(wrong("its bodies have another number of modes"));
        }
        let (warm_count, touch_count) = (from.count()?, from.count()?);
        let (warm_asleep_count, touch_asleep_count) = (from.count()?, from.count()?);
        let steps = from.count()?;
        // Everything is read before anything is changed.
        let mut bodies = self.bodies.clone();
        for body in &mut bodies {
            body.state = from.state()?;
            body.end = from.state()?;
            body.force = from.vector()?;
            body.torque = from.vector()?;
            body.snapshot = from.snapshot()?;
            body.rest = from.rest()?;
        }
        let mut modal = self.modal.clone();
        for all in [
            &mut modal.s,
            &mut modal.rate,
            &mut modal.force,
            &mut modal.end_s,
            &mut modal.snapshot_q,
            &mut modal.moved,
        ] {
            for value in all {
                *value = from.number()?;
            }
        }
        let mut warm = from.warm(warm_count)?;
        let mut warm_asleep = from.warm(warm_asleep_count)?;
        let mut touches = from.touches(touch_count)?;
        let mut touches_asleep = from.touches(touch_asleep_count)?;
        if !from.0.is_empty() {
            return Err(wrong("bytes follow its end"));
        }
        (self.bodies, self.modal, self.steps) = (bodies, modal, steps);
        // What has grown stays, so that later steps allocate nothing.
        self.pairs.clear();
        self.memory.clear();
        self.memory.loose.append(&mut warm);
        self.warm_asleep.clear();
        self.warm_asleep.append(&mut warm_asleep);
        for (old, new) in [
            (&mut self.touches, &mut touches),
            (&mut self.touches_asleep, &mut touches_asleep),
        ] {
            old.clear();
            old.append(new);
        }
        self.touches_before.clear();
        self.part_s = self.options.step_s;
        self.return_to_snapshots()?;
        for index in 0..self.bodies.len() {
            if self.bodies[index].rest.is_asleep {
                self.lie(index);
                self.follow(index)?;
            }
        }
        self.is_posed = false;
        Ok(())
    }
}

fn put<'x>(out: &mut Vec<u8>, values: impl Iterator<Item = &'x f64>) {
    for value in values {
        out.extend(value.to_le_bytes());
    }
}

fn wrong(what: &'static str) -> DynamicsError {
    DynamicsError::State { what }
}

/// What is left to read.
struct Bytes<'b>(&'b [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], DynamicsError> {
        let (first, rest) = self
            .0
            .split_first_chunk()
            .ok_or(wrong("it ends too early"))?;
        self.0 = rest;
        Ok(*first)
    }

    fn count(&mut self) -> Result<u64, DynamicsError> {
        Ok(u64::from_le_bytes(self.take()?))
    }

    fn whole(&mut self) -> Result<u32, DynamicsError> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    fn number(&mut self) -> Result<f64, DynamicsError> {
        let value = f64::from_le_bytes(self.take()?);
        if !value.is_finite() {
            return Err(wrong("a number is not finite"));
        }
        Ok(value)
    }

    fn vector(&mut self) -> Result<Vector3<f64>, DynamicsError> {
        Ok(Vector3::new(self.number()?, self.number()?, self.number()?))
    }

    fn side(&mut self) -> Result<Side, DynamicsError> {
        Ok(Side {
            body: self.whole()?,
            sphere: self.whole()?,
        })
    }

    fn rest(&mut self) -> Result<Rest, DynamicsError> {
        let (quiet, is_asleep, island) = (self.whole()?, self.whole()?, self.whole()?);
        let change = match self.whole()? {
            0 => Change::None,
            1 => Change::FallAsleep,
            2 => Change::Wake,
            _ => return Err(wrong("a body neither rests nor wakes")),
        };
        if is_asleep > 1 {
            return Err(wrong("a body neither sleeps nor is awake"));
        }
        Ok(Rest {
            quiet,
            is_asleep: is_asleep == 1,
            island,
            change,
        })
    }

    fn warm(&mut self, count: u64) -> Result<Vec<Warm>, DynamicsError> {
        let mut found = Vec::new();
        for _ in 0..count {
            let warm = Warm {
                sides: [self.side()?, self.side()?],
                normal: self.number()?,
                late: self.number()?,
                stiffness: self.number()?,
                across: self.vector()?,
                along: self.vector()?,
            };
            if warm.late < 0.0 || warm.stiffness < 0.0 {
                return Err(wrong("a contact's spring is negative"));
            }
            found.push(warm);
        }
        Ok(found)
    }

    fn touches(&mut self, count: u64) -> Result<Vec<Touch>, DynamicsError> {
        let mut found = Vec::new();
        for _ in 0..count {
            found.push(Touch {
                sides: [self.whole()?, self.whole()?],
                impulse: self.vector()?,
            });
        }
        Ok(found)
    }

    fn orientation(&mut self) -> Result<UnitQuaternion<f64>, DynamicsError> {
        let [x, y, z, w] = [
            self.number()?,
            self.number()?,
            self.number()?,
            self.number()?,
        ];
        let orientation = Quaternion::new(w, x, y, z);
        if !((orientation.norm() - 1.0).abs() < 1e-6) {
            return Err(wrong("an orientation is not a unit quaternion"));
        }
        // Kept to the bit.
        Ok(UnitQuaternion::new_unchecked(orientation))
    }

    fn snapshot(&mut self) -> Result<Snapshot, DynamicsError> {
        Ok(Snapshot {
            position: self.vector()?,
            orientation: self.orientation()?,
            allowance: self.number()?,
            is_brief: self.whole()? != 0,
            is_new: false,
        })
    }

    fn state(&mut self) -> Result<FrameState, DynamicsError> {
        Ok(FrameState {
            position: self.vector()?,
            orientation: self.orientation()?,
            velocity: self.vector()?,
            angular_momentum: self.vector()?,
        })
    }
}
