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
use super::solve::Warm;
use crate::error::DynamicsError;
use crate::frame::FrameState;

const MAGIC: [u8; 8] = *b"BDTWORLD";
const VERSION: u64 = 1;

impl World {
    /// Appends the whole state to `out`.
    pub fn save(&self, out: &mut Vec<u8>) {
        out.extend(MAGIC);
        let counts = [
            VERSION,
            self.bodies.len() as u64,
            self.modal.s.len() as u64,
            self.warm.len() as u64,
            self.touches.len() as u64,
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
        }
        for all in [
            &self.modal.s,
            &self.modal.rate,
            &self.modal.force,
            &self.modal.end_s,
        ] {
            put(out, all.iter());
        }
        for warm in &self.warm {
            for side in warm.sides {
                out.extend(side.body.to_le_bytes());
                out.extend(side.sphere.to_le_bytes());
            }
            put(out, [warm.normal, warm.late].iter());
            put(out, warm.across.iter());
        }
        for touch in &self.touches {
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
            return Err(wrong("its version is not 1"));
        }
        if from.count()? != self.bodies.len() as u64 {
            return Err(wrong("it has another number of bodies"));
        }
        if from.count()? != self.modal.s.len() as u64 {
            return Err(wrong("its bodies have another number of modes"));
        }
        let (warm_count, touch_count, steps) = (from.count()?, from.count()?, from.count()?);
        // Everything is read before anything is changed.
        let mut bodies = self.bodies.clone();
        for body in &mut bodies {
            body.state = from.state()?;
            body.end = from.state()?;
            body.force = from.vector()?;
            body.torque = from.vector()?;
        }
        let mut modal = self.modal.clone();
        for all in [
            &mut modal.s,
            &mut modal.rate,
            &mut modal.force,
            &mut modal.end_s,
        ] {
            for value in all {
                *value = from.number()?;
            }
        }
        let mut warm = Vec::new();
        for _ in 0..warm_count {
            let sides = [from.side()?, from.side()?];
            warm.push(Warm {
                sides,
                normal: from.number()?,
                late: from.number()?,
                across: from.vector()?,
            });
        }
        let mut touches = Vec::new();
        for _ in 0..touch_count {
            touches.push(Touch {
                sides: [from.whole()?, from.whole()?],
                impulse: from.vector()?,
            });
        }
        if !from.0.is_empty() {
            return Err(wrong("bytes follow its end"));
        }
        (self.bodies, self.modal, self.steps) = (bodies, modal, steps);
        // What has grown stays, so that later steps allocate nothing.
        self.warm.clear();
        self.warm.append(&mut warm);
        self.touches.clear();
        self.touches.append(&mut touches);
        self.touches_before.clear();
        self.contacts.clear();
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

    fn state(&mut self) -> Result<FrameState, DynamicsError> {
        let position = self.vector()?;
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
        Ok(FrameState {
            position,
            // Kept to the bit.
            orientation: UnitQuaternion::new_unchecked(orientation),
            velocity: self.vector()?,
            angular_momentum: self.vector()?,
        })
    }
}
