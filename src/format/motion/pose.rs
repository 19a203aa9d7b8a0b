//! A motion at a moment: where the vertices are.

use super::{Motion, MotionError, Placement, Property};
use glam::{DMat4, DQuat, DVec3, Vec3};
use rayon::prelude::*;

impl Motion {
    /// The positions of vertices that at rest are at `rest`, `time` seconds into an animation; before its first key and after
    /// its last it stands still. Without an animation: as the file shows the model when nothing is played.
    ///
    /// The motion must pass [`Motion::check`] for that many vertices.
    ///
    /// # Errors
    /// If there is no such animation, or a position is too large for a number.
    pub fn positions(&self, rest: &[Vec3], animation: Option<usize>, time: f64) -> Result<Vec<Vec3>, MotionError> {
        self.check(rest.len())?;
        let mut places: Vec<(DVec3, DQuat, DVec3)> = self.nodes.iter().map(|n| n.rest.parts()).collect();
        let mut moved = vec![false; self.nodes.len()];
        let mut weights: Vec<f64> = self.targets.iter().map(|t| f64::from(t.weight)).collect();
        let channels = match animation {
            None => &[][..],
            Some(k) => match self.animations.get(k) {
                Some(animation) => &animation.channels,
                None => return Err(self.missing(&k.to_string())),
            },
        };
        for channel in channels {
            let turns = matches!(channel.of, Property::Rotation(_));
            let value = channel.track.at(time, turns);
            if let Some(node) = channel.of.node() {
                moved[node as usize] = true;
            }
            match channel.of {
                Property::Translation(node) => places[node as usize].0 = DVec3::from_slice(&value),
                Property::Scale(node) => places[node as usize].2 = DVec3::from_slice(&value),
                Property::Rotation(node) => {
                    let turn = DQuat::from_slice(&value);
                    let unit = turn.length() > 0.0 && turn.length().is_finite();
                    places[node as usize].1 = if unit { turn.normalize() } else { DQuat::IDENTITY };
                }
                Property::Weights => weights = value,
            }
        }
        // Parents stand before their children.
        let mut world: Vec<DMat4> = Vec::with_capacity(self.nodes.len());
        for (k, node) in self.nodes.iter().enumerate() {
            let (translation, rotation, scale) = places[k];
            let own = if moved[k] { Placement::Parts { translation, rotation, scale } } else { node.rest };
            world.push(node.parent.map_or(DMat4::IDENTITY, |p| world[p as usize]) * own.matrix());
        }
        let joints: Vec<DMat4> = self.joints.iter().map(|j| world[j.node as usize] * j.inverse_bind).collect();
        let mut points: Vec<DVec3> = rest.iter().map(|p| p.as_dvec3()).collect();
        for (target, &weight) in self.targets.iter().zip(&weights).filter(|(_, w)| **w != 0.0) {
            for (&v, shift) in target.vertices.iter().zip(&target.shifts) {
                points[v as usize] += shift.as_dvec3() * weight;
            }
        }
        let carried = |(v, &p): (usize, &DVec3)| {
            let mut sum = DVec3::ZERO;
            for set in &self.influences {
                for (&joint, &weight) in set.joints[v].iter().zip(&set.weights[v]) {
                    if weight > 0.0 {
                        sum += joints[usize::from(joint)].transform_point3(p) * f64::from(weight);
                    }
                }
            }
            sum.as_vec3()
        };
        let positions: Vec<Vec3> = points.par_iter().enumerate().map(carried).collect();
        match positions.iter().position(|p| !p.is_finite()) {
            Some(vertex) => Err(MotionError::NotFinite { time, vertex }),
            None => Ok(positions),
        }
    }
}
