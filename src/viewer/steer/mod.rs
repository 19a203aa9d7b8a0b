//! Steering: the field combed by strokes on the surface, and its constraints as handles (LT 3.2).
//!
//! [`Combing`] is a state machine that knows neither window nor pointer: it is told where on the surface a gesture begins, goes and
//! ends, and says what has become of the constraints. [`handles`] finds what of a constraint lies under the pointer and paints it;
//! [`panel`] holds the comb's settings.

pub mod handles;
pub mod panel;
pub mod room;

pub use handles::{Grip, Handle};

use crate::field::{Anchor, Comb, Constraint, Constraints, FieldError, Mirror, Wish, overrule, stroke};
use crate::mesh::clean::UserFace;
use crate::mesh::nearest::Nearest;
use crate::mesh::transport::{projected, turned};
use crate::mesh::{Mesh, SurfacePoint};
use glam::DVec3;

/// A handle's twin stands within this share of its extent of its mirror image.
const TWIN: f64 = 0.1;

/// Nearer to the plane of symmetry than this share of the comb's radius there is one constraint instead of two.
const ON_PLANE: f64 = 0.5;

/// The least extent that a handle can be given, as a share of the mesh's diagonal.
const LEAST_EXTENT: f64 = 1e-3;

/// The largest weight that a handle can be given; the least is its inverse.
pub const MOST_WEIGHT: f64 = 16.0;

/// What gestures take place on.
#[derive(Debug, Clone, Copy)]
pub struct Ground<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// The tree over it.
    pub tree: &'a Nearest<'a>,
    /// From the user's face numbers to the mesh's.
    pub user_faces: Option<&'a [UserFace]>,
    /// What angles are measured against.
    pub axis: DVec3,
    /// World length of one exemplar width.
    pub scale: f64,
}

impl Ground<'_> {
    fn diagonal(&self) -> f64 {
        let (low, high) = self.mesh.bounds();
        high.as_dvec3().distance(low.as_dvec3())
    }
}

/// What a stroke does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tool {
    /// Combs the direction.
    #[default]
    Direction,
    /// Sets the scale.
    Scale,
    /// Takes away what was asked for.
    Erase,
}

/// The comb's settings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CombSettings {
    /// What a stroke does without a modifier.
    pub tool: Tool,
    /// Radius as a share of the mesh's diagonal.
    pub radius: f64,
    /// Weight of what it leaves.
    pub weight: f64,
    /// Relative scale that it sets.
    pub scale: f64,
    /// Axis square to the plane of symmetry through the mesh's middle, if strokes are mirrored: 0, 1, 2 for x, y, z.
    pub symmetry: Option<usize>,
}

impl Default for CombSettings {
    fn default() -> Self {
        Self { tool: Tool::Direction, radius: 0.08, weight: 1.0, scale: 1.5, symmetry: None }
    }
}

/// A change of the constraints. Its inverse is the same with its ends exchanged.
#[derive(Debug, Clone, PartialEq)]
pub struct Edit {
    /// What was done, in words for a menu.
    pub what: &'static str,
    /// Before.
    pub before: Constraints,
    /// After.
    pub after: Constraints,
}

#[derive(Debug, Clone)]
enum Doing {
    Stroke { tool: Tool, way: Vec<SurfacePoint> },
    Handle { index: usize, twin: Option<usize>, grip: Grip, pulled: bool },
}

#[derive(Debug, Clone)]
struct Gesture {
    before: Constraints,
    doing: Doing,
}

/// Constraints being combed.
#[derive(Debug, Clone, Default)]
pub struct Combing {
    /// The comb.
    pub settings: CombSettings,
    constraints: Constraints,
    /// Tied to the mesh, in the same order.
    anchors: Vec<Anchor>,
    selected: Option<usize>,
    gesture: Option<Gesture>,
}

impl Combing {
    /// The constraints as they are now, in the middle of a gesture too.
    #[must_use]
    pub const fn constraints(&self) -> &Constraints {
        &self.constraints
    }

    /// The handle selected.
    #[must_use]
    pub const fn selected(&self) -> Option<usize> {
        self.selected
    }

    /// Selects a handle.
    pub fn select(&mut self, index: Option<usize>) {
        self.selected = index.filter(|&i| i < self.constraints.constraints.len());
    }

    /// True between the beginning of a gesture and its end.
    #[must_use]
    pub const fn busy(&self) -> bool {
        self.gesture.is_some()
    }

    /// The stroke so far.
    #[must_use]
    pub fn way(&self) -> &[SurfacePoint] {
        match &self.gesture {
            Some(Gesture { doing: Doing::Stroke { way, .. }, .. }) => way,
            _ => &[],
        }
    }

    /// The comb as it would be on a mesh, for a tool.
    #[must_use]
    pub fn comb(&self, ground: &Ground<'_>, tool: Tool) -> Comb {
        let wish = if tool == Tool::Scale { Wish::Scale(self.settings.scale) } else { Wish::Direction };
        Comb { radius: self.settings.radius * ground.diagonal(), weight: self.settings.weight, wish }
    }

    /// Takes other constraints: a file's, or an undone edit's. Ends any gesture.
    ///
    /// # Errors
    /// The first constraint that cannot be used on this mesh; nothing is changed then.
    pub fn set(&mut self, ground: &Ground<'_>, constraints: Constraints) -> Result<(), FieldError> {
        let anchors = tie(ground, &constraints)?;
        let kept = self.selected.filter(|&i| constraints.constraints.get(i) == self.constraints.constraints.get(i));
        (self.constraints, self.anchors, self.gesture) = (constraints, anchors, None);
        self.select(kept);
        Ok(())
    }

    /// The handles of the constraints, in their order.
    #[must_use]
    pub fn handles(&self, mesh: &Mesh) -> Vec<Handle> {
        self.anchors.iter().map(|anchor| Handle::new(mesh, anchor)).collect()
    }

    /// The pointer goes down on the surface: a stroke begins.
    pub fn begin_stroke(&mut self, at: SurfacePoint, tool: Tool) {
        self.selected = None;
        self.gesture = Some(Gesture { before: self.constraints.clone(), doing: Doing::Stroke { tool, way: vec![at] } });
    }

    /// The pointer goes down on a handle.
    pub fn begin_handle(&mut self, ground: &Ground<'_>, index: usize, grip: Grip) {
        let Some(anchor) = self.anchors.get(index) else { return };
        let before = self.constraints.clone();
        let twin = self.mirror(ground).and_then(|mirror| self.twin(ground, &mirror, index));
        self.selected = Some(index);
        self.constraints.constraints[index] = Constraint::explicit(ground.mesh, anchor);
        if let Some(twin) = twin {
            self.constraints.constraints[twin] = Constraint::explicit(ground.mesh, &self.anchors[twin]);
        }
        self.gesture = Some(Gesture { before, doing: Doing::Handle { index, twin, grip, pulled: false } });
    }

    /// The pointer has moved to another place of the surface. True if constraints have changed already.
    pub fn drag(&mut self, ground: &Ground<'_>, to: SurfacePoint) -> bool {
        match &mut self.gesture {
            None => false,
            Some(Gesture { doing: Doing::Stroke { way, .. }, .. }) => {
                way.push(to);
                false
            }
            Some(Gesture { doing: Doing::Handle { index, twin, grip, pulled }, .. }) => {
                *pulled = true;
                let (index, twin, grip) = (*index, *twin, *grip);
                self.pull(ground, index, twin, grip, to)
            }
        }
    }

    /// The pointer goes up. What has changed, if anything.
    pub fn end(&mut self, ground: &Ground<'_>) -> Option<Edit> {
        let Gesture { before, doing } = self.gesture.take()?;
        let what = match doing {
            Doing::Stroke { tool, way } => self.finish_stroke(ground, tool, &way),
            Doing::Handle { pulled: false, .. } => {
                // A click selects and changes nothing, not even how the constraint is written.
                self.restore(ground, before);
                return None;
            }
            Doing::Handle { grip, .. } => grip.what(),
        };
        self.edited(what, before)
    }

    /// Gives the gesture up: everything is as it was before it.
    pub fn cancel(&mut self, ground: &Ground<'_>) {
        if let Some(Gesture { before, .. }) = self.gesture.take() {
            self.restore(ground, before);
        }
    }

    /// Deletes the selected handle, and its twin.
    pub fn delete(&mut self, ground: &Ground<'_>) -> Option<Edit> {
        let index = self.selected.take()?;
        let before = self.constraints.clone();
        let twin = self.mirror(ground).and_then(|mirror| self.twin(ground, &mirror, index));
        let mut at = 0;
        self.constraints.constraints.retain(|_| {
            at += 1;
            at - 1 != index && Some(at - 1) != twin
        });
        self.retie(ground);
        self.edited("Delete handle", before)
    }

    /// Gives the selected handle, and its twin, another weight.
    pub fn weigh(&mut self, ground: &Ground<'_>, weight: f64) -> Option<Edit> {
        let weight = weight.clamp(1.0 / MOST_WEIGHT, MOST_WEIGHT);
        self.change(ground, "Weigh handle", |c| c.weight = Some(weight))
    }

    /// Gives the selected handle, and its twin, another extent, world units.
    pub fn widen(&mut self, ground: &Ground<'_>, extent: f64) -> Option<Edit> {
        let extent = extent.max(LEAST_EXTENT * ground.diagonal());
        self.change(ground, "Widen handle", |c| (c.extent, c.extent_share) = (Some(extent), None))
    }

    /// Gives the selected handle, and its twin, another relative scale; `None` takes away what it says about scale.
    pub fn rescale(&mut self, ground: &Ground<'_>, scale: Option<f64>) -> Option<Edit> {
        self.change(ground, "Scale handle", |c| c.scale = scale)
    }

    /// Takes all constraints away; the axis and its weight stay.
    pub fn clear(&mut self, ground: &Ground<'_>) -> Option<Edit> {
        let before = self.constraints.clone();
        self.constraints.constraints.clear();
        self.retie(ground);
        self.edited("Clear combing", before)
    }

    fn change(&mut self, ground: &Ground<'_>, what: &'static str, change: impl Fn(&mut Constraint)) -> Option<Edit> {
        let index = self.selected?;
        let before = self.constraints.clone();
        let twin = self.mirror(ground).and_then(|mirror| self.twin(ground, &mirror, index));
        for i in [Some(index), twin].into_iter().flatten() {
            change(&mut self.constraints.constraints[i]);
        }
        self.retie(ground);
        self.edited(what, before)
    }

    fn edited(&mut self, what: &'static str, before: Constraints) -> Option<Edit> {
        self.select(self.selected);
        (before != self.constraints).then(|| Edit { what, before, after: self.constraints.clone() })
    }

    /// Ties the constraints to the mesh anew. What was made here can always be tied; should it not, the last state that could is
    /// kept.
    fn retie(&mut self, ground: &Ground<'_>) {
        match tie(ground, &self.constraints) {
            Ok(anchors) => self.anchors = anchors,
            Err(_) => self.constraints.constraints.truncate(self.anchors.len()),
        }
    }

    fn restore(&mut self, ground: &Ground<'_>, constraints: Constraints) {
        self.constraints = constraints;
        self.retie(ground);
        self.select(self.selected);
    }

    fn mirror(&self, ground: &Ground<'_>) -> Option<Mirror> {
        self.settings.symmetry.map(|axis| Mirror::middle(ground.mesh, axis))
    }

    /// The constraint that stands where a constraint's mirror image would.
    fn twin(&self, ground: &Ground<'_>, mirror: &Mirror, index: usize) -> Option<usize> {
        let anchor = self.anchors.get(index)?;
        let image = mirror.point(ground.mesh.position(anchor.at));
        let far = |i: &usize| ground.mesh.position(self.anchors[*i].at).distance(image);
        let nearest = (0..self.anchors.len()).filter(|&i| i != index).min_by(|a, b| far(a).total_cmp(&far(b)))?;
        (far(&nearest) < TWIN * anchor.extent).then_some(nearest)
    }

    fn finish_stroke(&mut self, ground: &Ground<'_>, tool: Tool, way: &[SurfacePoint]) -> &'static str {
        let comb = self.comb(ground, tool);
        let mirror = self.mirror(ground);
        let mut dabs = stroke(ground.mesh, way, &comb);
        if let Some(mirror) = mirror {
            let near = ON_PLANE * comb.radius;
            let twins = dabs.iter().flat_map(|dab| mirror.both(&dab.constraint, near));
            let placed = twins.filter_map(|constraint| {
                let at = ground.tree.nearest(DVec3::from(constraint.position?))?.at;
                Some(crate::field::Dab { at, constraint })
            });
            dabs = placed.collect();
        }
        if tool == Tool::Erase {
            // What is erased is everything, whatever it asks for.
            for wish in [Wish::Direction, Wish::Scale(1.0)] {
                let comb = Comb { wish, radius: 2.0 * comb.radius, ..comb };
                overrule(&mut self.constraints, &self.anchors, ground.mesh, &dabs, &comb);
                self.retie(ground);
            }
            return "Erase combing";
        }
        overrule(&mut self.constraints, &self.anchors, ground.mesh, &dabs, &comb);
        self.constraints.constraints.extend(dabs.into_iter().map(|dab| dab.constraint));
        self.retie(ground);
        if tool == Tool::Scale { "Comb scale" } else { "Comb direction" }
    }

    /// Pulls a handle to a place.
    fn pull(&mut self, ground: &Ground<'_>, index: usize, twin: Option<usize>, grip: Grip, to: SurfacePoint) -> bool {
        let mesh = ground.mesh;
        let (Some(anchor), Some(c)) = (self.anchors.get(index), self.constraints.constraints.get(index)) else { return false };
        let (from, place) = (mesh.normal(anchor.at.face), mesh.position(anchor.at));
        let (normal, target) = (mesh.normal(to.face), mesh.position(to));
        let mut pulled = c.clone();
        match grip {
            Grip::Move => {
                pulled.position = Some(target.to_array());
                pulled.direction = c.direction.map(|d| projected(turned(DVec3::from(d), from, normal), normal).to_array());
            }
            Grip::Turn => match projected(target - place, from).try_normalize() {
                Some(along) => pulled.direction = Some(along.to_array()),
                None => return false,
            },
            Grip::Widen => pulled.extent = Some(target.distance(place).max(LEAST_EXTENT * ground.diagonal())),
        }
        if pulled == *c {
            return false;
        }
        let before = std::mem::replace(&mut self.constraints.constraints[index], pulled.clone());
        if let (Some(twin), Some(mirror)) = (twin, self.mirror(ground)) {
            self.constraints.constraints[twin] = mirror.constraint(&pulled);
        }
        match tie(ground, &self.constraints) {
            Ok(anchors) => self.anchors = anchors,
            // A direction square to the face it came to: the handle waits where it was.
            Err(_) => {
                self.constraints.constraints[index] = before.clone();
                if let (Some(twin), Some(mirror)) = (twin, self.mirror(ground)) {
                    self.constraints.constraints[twin] = mirror.constraint(&before);
                }
                return false;
            }
        }
        true
    }
}

fn tie(ground: &Ground<'_>, constraints: &Constraints) -> Result<Vec<Anchor>, FieldError> {
    constraints.anchors_near(ground.mesh, Some(ground.tree), ground.user_faces, ground.axis, ground.scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{FieldOptions, constrained};
    use crate::mesh::shapes;

    /// The unit sphere with its tree.
    fn on_sphere(test: impl FnOnce(&Ground<'_>)) {
        let mesh = shapes::sphere(4);
        let tree = Nearest::new(&mesh);
        test(&Ground { mesh: &mesh, tree: &tree, user_faces: None, axis: DVec3::Y, scale: 0.3 });
    }

    fn at(ground: &Ground<'_>, p: [f64; 3]) -> SurfacePoint {
        ground.tree.nearest(DVec3::from(p)).expect("finite").at
    }

    /// Strokes around the z axis at a height, from one angle to another.
    fn stroke_at(combing: &mut Combing, ground: &Ground<'_>, z: f64, range: [f64; 2], tool: Tool) -> Option<Edit> {
        let point = |t: f64| {
            let a = range[0] + (range[1] - range[0]) * t;
            at(ground, [a.cos(), a.sin(), z])
        };
        combing.begin_stroke(point(0.0), tool);
        for i in 1..=40 {
            combing.drag(ground, point(f64::from(i) / 40.0));
        }
        combing.end(ground)
    }

    fn place(c: &Constraint) -> DVec3 {
        DVec3::from(c.position.expect("a position"))
    }

    #[test]
    fn a_stroke_is_one_edit_and_its_inverse_takes_it_back() {
        on_sphere(|ground| {
            let mut combing = Combing::default();
            let edit = stroke_at(&mut combing, ground, 0.0, [0.0, 1.2], Tool::Direction).expect("an edit");
            assert_eq!((edit.what, edit.before.constraints.len()), ("Comb direction", 0), "from nothing");
            assert!(edit.after.constraints.len() >= 3, "{:?}", edit.after);
            assert_eq!(combing.handles(ground.mesh).len(), edit.after.constraints.len(), "a handle each");
            assert_eq!(combing.set(ground, edit.before), Ok(()), "taken back");
            assert!(combing.handles(ground.mesh).is_empty(), "nothing is left");
            let click = {
                combing.begin_stroke(at(ground, [1.0, 0.0, 0.0]), Tool::Direction);
                combing.end(ground)
            };
            assert_eq!(click, None, "a click changes nothing");
        });
    }

    #[test]
    fn a_mirrored_stroke_makes_a_mirrored_field() {
        on_sphere(|ground| {
            let mut combing = Combing::default();
            combing.settings.symmetry = Some(0);
            stroke_at(&mut combing, ground, 0.3, [-0.9, 0.9], Tool::Direction).expect("an edit");
            let anchors = tie(ground, combing.constraints()).expect("usable");
            let (field, _) = constrained(ground.mesh, &anchors, &FieldOptions::default()).expect("a field");
            let mirror = Mirror::middle(ground.mesh, 0);
            for f in (0..ground.mesh.face_count() as u32).filter(|&f| ground.mesh.centroid(f).x > 0.25) {
                let twin = ground.tree.nearest(mirror.point(ground.mesh.centroid(f))).expect("finite").at.face;
                let [here, there] = [f, twin].map(|f| field.up[f as usize].as_dvec3());
                assert!(mirror.vector(here).dot(there) > 0.99, "{here} at {} became {there}", ground.mesh.centroid(f));
            }
        });
    }

    #[test]
    fn handles_are_moved_turned_and_widened_with_their_twins() {
        on_sphere(|ground| {
            let mut combing = Combing::default();
            combing.settings.symmetry = Some(0);
            stroke_at(&mut combing, ground, 0.2, [-0.5, 0.5], Tool::Direction).expect("an edit");
            let count = combing.constraints().constraints.len();
            let index = 0;
            let mirror = Mirror::middle(ground.mesh, 0);
            let twin = {
                let image = mirror.point(place(&combing.constraints().constraints[index]));
                let far = |i: &usize| place(&combing.constraints().constraints[*i]).distance(image);
                (0..count).min_by(|a, b| far(a).total_cmp(&far(b))).expect("there are some")
            };
            for (grip, to) in [(Grip::Move, [0.7, -0.5, 0.5]), (Grip::Turn, [0.7, 0.2, 0.7]), (Grip::Widen, [0.9, -0.5, 0.1])] {
                combing.begin_handle(ground, index, grip);
                assert!(combing.drag(ground, at(ground, to)), "{grip:?} changes it at once");
                let edit = combing.end(ground).expect("an edit");
                assert_eq!(edit.what, grip.what(), "named for undo");
                let [a, b] = [index, twin].map(|i| combing.constraints().constraints[i].clone());
                assert!(place(&b).distance(mirror.point(place(&a))) < 1e-6, "{grip:?}: the twin stands opposite");
                let directions = [&a, &b].map(|c| DVec3::from(c.direction.expect("kept")).normalize());
                assert!(mirror.vector(directions[0]).dot(directions[1]) > 0.999, "{grip:?}: and points opposite");
                assert_eq!(a.extent, b.extent, "{grip:?}: and reaches as far");
            }
            let handle = combing.handles(ground.mesh)[index];
            let to_target = (DVec3::new(0.7, 0.2, 0.7) - handle.place).normalize();
            assert!(handle.direction.expect("kept").dot(to_target) > 0.8, "it points where it was turned to");
            combing.weigh(ground, 5.0).expect("an edit");
            let weights = [index, twin].map(|i| combing.constraints().constraints[i].weight);
            assert_eq!(weights, [Some(5.0); 2], "both weigh as much");
            combing.delete(ground).expect("an edit");
            assert_eq!(combing.constraints().constraints.len(), count - 2, "both are gone");
        });
    }

    #[test]
    fn a_click_on_a_handle_selects_it_and_changes_nothing() {
        on_sphere(|ground| {
            let mut combing = Combing::default();
            stroke_at(&mut combing, ground, 0.0, [0.0, 1.2], Tool::Direction).expect("an edit");
            let before = combing.constraints().clone();
            combing.begin_handle(ground, 1, Grip::Move);
            assert_eq!((combing.end(ground), combing.selected()), (None, Some(1)), "no edit");
            assert_eq!(combing.constraints(), &before, "to the last bit");
        });
    }

    #[test]
    fn a_gesture_given_up_leaves_no_trace() {
        on_sphere(|ground| {
            let mut combing = Combing::default();
            stroke_at(&mut combing, ground, 0.0, [0.0, 1.2], Tool::Direction).expect("an edit");
            let before = combing.constraints().clone();
            combing.begin_handle(ground, 1, Grip::Move);
            combing.drag(ground, at(ground, [0.0, 0.0, 1.0]));
            assert_ne!(combing.constraints(), &before, "moved");
            combing.cancel(ground);
            assert_eq!(combing.constraints(), &before, "as it was");
        });
    }

    #[test]
    fn the_eraser_takes_directions_and_scales() {
        on_sphere(|ground| {
            let mut combing = Combing::default();
            stroke_at(&mut combing, ground, 0.0, [0.0, 1.2], Tool::Direction).expect("an edit");
            stroke_at(&mut combing, ground, 0.0, [0.0, 1.2], Tool::Scale).expect("an edit");
            let edit = stroke_at(&mut combing, ground, 0.0, [-0.1, 1.3], Tool::Erase).expect("an edit");
            assert!(edit.after.constraints.is_empty(), "{:?}", edit.after);
            assert_eq!(stroke_at(&mut combing, ground, 0.0, [2.0, 3.0], Tool::Erase), None, "nothing is there");
        });
    }
}
