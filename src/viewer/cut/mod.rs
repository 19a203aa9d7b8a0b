//! Cutting texture patches: outlines drawn on the exemplar, snapping to its edges (LT 3.1, without a drawing program).
//!
//! [`Cutter`] is a state machine over pixels of the exemplar that knows neither window nor zoom: clicks set anchors, between which a
//! live wire follows the edges; a click on the first anchor closes the outline. [`editor`] shows it; [`preview`] shows the alpha
//! that pasting will make of it.

pub mod editor;
pub mod preview;
pub mod room;

use crate::exemplar::{Edges, OUTLINE_TOLERANCE, Outline, Wire};
use glam::Vec2;
use std::sync::Arc;

/// A wire looks at no more than so many pixels in a frame; what takes longer shows as a straight line meanwhile.
const WORK: usize = 40_000;

/// Anchors snap to the clearest edge within so many pixels.
const SNAP: f32 = 6.0;

/// A line drawn free gets a point where it has come so far, pixels.
const FREE_STEP: f32 = 2.0;

/// Outlines drawn here have no fewer anchors.
const FEWEST: usize = 2;

/// The most changes that can be taken back.
const MOST_STEPS: usize = 100;

/// How an outline goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Line {
    /// Along the exemplar's edges.
    #[default]
    Snapped,
    /// Straight.
    Straight,
}

/// An outline as it was drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drawn {
    /// Where it was clicked, pixels.
    pub anchors: Vec<Vec2>,
    /// From each anchor to the next, both included; of a closed outline the last leads to the first anchor.
    pub pieces: Vec<Vec<Vec2>>,
}

impl Drawn {
    /// A polygon drawn before, pixels.
    fn of(outline: &Outline) -> Self {
        let n = outline.points.len();
        let piece = |i: usize| vec![outline.points[i], outline.points[(i + 1) % n]];
        Self { anchors: outline.points.clone(), pieces: (0..n).map(piece).collect() }
    }

    /// All of its points in turn.
    pub fn line(&self) -> impl Iterator<Item = Vec2> + '_ {
        self.pieces.iter().flatten().copied()
    }

    /// The outline that pasting takes.
    #[must_use]
    pub fn outline(&self) -> Outline {
        Outline::untangled(&self.line().collect::<Vec<_>>(), OUTLINE_TOLERANCE)
    }
}

/// The outline that is being drawn.
#[derive(Debug, Clone)]
struct Drawing {
    drawn: Drawn,
    wire: Option<Wire>,
    /// From the last anchor to the pointer.
    live: Vec<Vec2>,
    /// Where the button went down.
    pressed: Vec2,
    /// The button is held: the line is drawn free.
    free: bool,
}

/// An anchor that is being dragged.
#[derive(Debug, Clone)]
struct Dragging {
    outline: usize,
    anchor: usize,
    /// From the anchors before and after it.
    wires: Option<Box<[Wire; 2]>>,
    before: Vec<Drawn>,
}

/// What lies under the pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Under {
    /// An anchor of a finished outline.
    Anchor {
        /// The outline.
        outline: usize,
        /// The anchor.
        anchor: usize,
    },
    /// The first anchor of the outline being drawn: a click closes it.
    Close,
    /// The inside of a finished outline.
    Inside(usize),
    /// Nothing.
    Nothing,
}

/// Outlines being drawn on an exemplar.
#[derive(Debug, Clone, Default)]
pub struct Cutter {
    /// How outlines go on.
    pub line: Line,
    edges: Option<Arc<Edges>>,
    outlines: Vec<Drawn>,
    selected: Option<usize>,
    drawing: Option<Drawing>,
    dragging: Option<Dragging>,
    past: Vec<Vec<Drawn>>,
    future: Vec<Vec<Drawn>>,
    /// Counts up with every change of the finished outlines.
    revision: u64,
}

impl Cutter {
    /// With outlines drawn before, pixels.
    #[must_use]
    pub fn new(outlines: &[Outline]) -> Self {
        Self { outlines: outlines.iter().map(Drawn::of).collect(), ..Self::default() }
    }

    /// Gives it the exemplar's edges; until then lines are straight.
    pub fn set_edges(&mut self, edges: Arc<Edges>) {
        self.edges = Some(edges);
    }

    /// True once it snaps.
    #[must_use]
    pub const fn has_edges(&self) -> bool {
        self.edges.is_some()
    }

    /// The finished outlines.
    #[must_use]
    pub fn outlines(&self) -> &[Drawn] {
        &self.outlines
    }

    /// What pasting takes.
    #[must_use]
    pub fn result(&self) -> Vec<Outline> {
        self.outlines.iter().map(Drawn::outline).collect()
    }

    /// Counts up with every change of the finished outlines.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// The outline selected.
    #[must_use]
    pub const fn selected(&self) -> Option<usize> {
        self.selected
    }

    /// The outline being drawn, and the way from its last anchor to the pointer.
    #[must_use]
    pub fn drawing(&self) -> Option<(&Drawn, &[Vec2])> {
        self.drawing.as_ref().map(|d| (&d.drawn, &d.live[..]))
    }

    /// What lies under the pointer; `reach` is how near an anchor must be, pixels.
    #[must_use]
    pub fn under(&self, at: Vec2, reach: f32) -> Under {
        if let Some(Drawing { drawn, .. }) = &self.drawing {
            let closes = drawn.anchors.len() > FEWEST && drawn.anchors[0].distance(at) < reach;
            return if closes { Under::Close } else { Under::Nothing };
        }
        let anchors = self.outlines.iter().enumerate();
        let anchors =
            anchors.flat_map(|(outline, drawn)| drawn.anchors.iter().enumerate().map(move |(a, p)| (outline, a, p.distance(at))));
        if let Some((outline, anchor, _)) = anchors.filter(|a| a.2 < reach).min_by(|a, b| a.2.total_cmp(&b.2)) {
            return Under::Anchor { outline, anchor };
        }
        let inside = |drawn: &Drawn| winds(drawn.line().collect::<Vec<_>>().as_slice(), at);
        self.outlines.iter().rposition(inside).map_or(Under::Nothing, Under::Inside)
    }

    /// The button goes down on something.
    pub fn press(&mut self, at: Vec2, under: Under) {
        match under {
            Under::Close => self.close(),
            Under::Anchor { outline, anchor } => self.take_hold(outline, anchor),
            Under::Inside(outline) if self.selected != Some(outline) => self.selected = Some(outline),
            Under::Inside(_) | Under::Nothing => self.add_anchor(at),
        }
    }

    /// The pointer has moved, with the button up or down. True if it should be told again next frame: a wire is being looked for.
    pub fn moved(&mut self, at: Vec2, down: bool) -> bool {
        let edges = self.edges.clone().filter(|_| self.line == Line::Snapped);
        if let Some(dragging) = &mut self.dragging {
            return drag(&mut self.outlines, dragging, edges.as_deref(), at);
        }
        let Some(Drawing { drawn, wire, live, pressed, free }) = &mut self.drawing else { return false };
        let Some(&last) = drawn.anchors.last() else { return false };
        if down && (*free || pressed.distance(at) > 2.0 * FREE_STEP) {
            if !*free {
                (*free, *live) = (true, vec![last]);
            }
            if live.last().is_none_or(|p| p.distance(at) >= FREE_STEP) {
                live.push(at);
            }
            return false;
        }
        let found = match (edges, wire) {
            (Some(edges), Some(wire)) => wire.to(&edges, edges.snap(at, SNAP), WORK),
            _ => Some(vec![last, at]),
        };
        let searching = found.is_none();
        *live = found.unwrap_or_else(|| vec![last, at]);
        searching
    }

    /// The button goes up.
    pub fn release(&mut self) {
        if let Some(Dragging { before, .. }) = self.dragging.take() {
            self.changed_from(before);
        }
        if let Some(drawing) = self.drawing.as_mut().filter(|d| d.free) {
            drawing.free = false;
            let piece = std::mem::take(&mut drawing.live);
            if let Some(&end) = piece.last().filter(|_| piece.len() > 1) {
                drawing.drawn.pieces.push(piece);
                drawing.drawn.anchors.push(end);
                drawing.wire = self.edges.as_ref().map(|edges| Wire::new(edges, end));
            }
        }
    }

    /// Takes the last anchor of the outline being drawn back.
    pub fn back(&mut self) {
        let Some(Drawing { drawn, wire, live, .. }) = &mut self.drawing else { return };
        drawn.anchors.pop();
        drawn.pieces.pop();
        live.clear();
        match drawn.anchors.last() {
            None => self.drawing = None,
            Some(&last) => *wire = self.edges.as_ref().map(|edges| Wire::new(edges, last)),
        }
    }

    /// Gives the outline being drawn up, or the selection.
    pub fn escape(&mut self) {
        if self.drawing.take().is_none() {
            self.selected = None;
        }
    }

    /// Deletes the selected outline.
    pub fn delete(&mut self) {
        if let Some(i) = self.selected.take().filter(|&i| i < self.outlines.len()) {
            let before = self.outlines.clone();
            self.outlines.remove(i);
            self.changed_from(before);
        }
    }

    /// Deletes all outlines.
    pub fn clear(&mut self) {
        let before = std::mem::take(&mut self.outlines);
        (self.selected, self.drawing) = (None, None);
        self.changed_from(before);
    }

    /// Takes the last change of the finished outlines back, or the last anchor of the one being drawn.
    pub fn undo(&mut self) {
        if self.drawing.is_some() {
            return self.back();
        }
        if let Some(before) = self.past.pop() {
            self.future.push(std::mem::replace(&mut self.outlines, before));
            self.selected = None;
            self.revision += 1;
        }
    }

    /// Makes the change that was taken back last again.
    pub fn redo(&mut self) {
        if let Some(after) = self.future.pop() {
            self.past.push(std::mem::replace(&mut self.outlines, after));
            self.selected = None;
            self.revision += 1;
        }
    }

    /// Takes outlines that were changed elsewhere. If they are, within `same` pixels, what was here before or would be here after
    /// what was taken back, their anchors come back with them.
    pub fn follow(&mut self, outlines: &[Outline], same: f32) {
        let near = |a: &Outline, b: &Outline| {
            a.points.len() == b.points.len() && a.points.iter().zip(&b.points).all(|(p, q)| p.distance(*q) < same)
        };
        let is = |drawn: &[Drawn]| {
            drawn.len() == outlines.len() && drawn.iter().zip(outlines).all(|(drawn, outline)| near(&drawn.outline(), outline))
        };
        if is(&self.outlines) {
            return;
        }
        let steps = self.past.iter().rposition(|drawn| is(drawn)).map(|i| self.past.len() - i);
        let ahead = self.future.iter().rposition(|drawn| is(drawn)).map(|i| self.future.len() - i);
        match (steps, ahead) {
            (Some(n), _) => (0..n).for_each(|_| self.undo()),
            (None, Some(n)) => (0..n).for_each(|_| self.redo()),
            (None, None) => {
                let before = std::mem::replace(&mut self.outlines, outlines.iter().map(Drawn::of).collect());
                self.changed_from(before);
            }
        }
    }

    /// Closes the outline being drawn, if it has anchors enough.
    pub fn close(&mut self) {
        let Some(Drawing { mut drawn, wire, .. }) = self.drawing.take_if(|d| d.drawn.anchors.len() > FEWEST) else { return };
        let (first, last) = (drawn.anchors[0], drawn.anchors[drawn.anchors.len() - 1]);
        let way = match (&self.edges, wire) {
            (Some(edges), Some(mut wire)) if self.line == Line::Snapped => wire.to(edges, first, 8 * WORK),
            _ => None,
        };
        drawn.pieces.push(way.unwrap_or_else(|| vec![last, first]));
        let before = self.outlines.clone();
        self.outlines.push(drawn);
        self.selected = Some(self.outlines.len() - 1);
        self.changed_from(before);
    }

    fn add_anchor(&mut self, at: Vec2) {
        let pressed = at;
        let edges = self.edges.as_ref().filter(|_| self.line == Line::Snapped);
        match &mut self.drawing {
            None => {
                self.selected = None;
                let at = edges.map_or(at, |edges| edges.snap(at, SNAP));
                let drawn = Drawn { anchors: vec![at], pieces: Vec::new() };
                self.drawing = Some(Drawing { drawn, wire: None, live: Vec::new(), pressed, free: false });
            }
            Some(Drawing { drawn, wire, live, free, .. }) => {
                // A click that comes before the wire is found waits for it, but not for long; else what was shown is what is kept.
                let found = edges.zip(wire.as_mut()).filter(|_| !*free);
                if let Some(way) = found.and_then(|(edges, wire)| wire.to(edges, edges.snap(at, SNAP), 4 * WORK)) {
                    *live = way;
                }
                let last = drawn.anchors[drawn.anchors.len() - 1];
                let piece = if live.len() > 1 { std::mem::take(live) } else { vec![last, at] };
                let end = piece[piece.len() - 1];
                if end == last {
                    return;
                }
                drawn.pieces.push(piece);
                drawn.anchors.push(end);
            }
        }
        if let Some(drawing) = &mut self.drawing {
            let last = drawing.drawn.anchors[drawing.drawn.anchors.len() - 1];
            drawing.live.clear();
            drawing.pressed = pressed;
            drawing.wire = self.edges.as_ref().map(|edges| Wire::new(edges, last));
        }
    }

    fn take_hold(&mut self, outline: usize, anchor: usize) {
        let Some(drawn) = self.outlines.get(outline) else { return };
        let n = drawn.anchors.len();
        let beside = [drawn.anchors[(anchor + n - 1) % n], drawn.anchors[(anchor + 1) % n]];
        let wires = self.edges.as_ref().map(|edges| Box::new(beside.map(|p| Wire::new(edges, p))));
        self.selected = Some(outline);
        self.dragging = Some(Dragging { outline, anchor, wires, before: self.outlines.clone() });
    }

    fn changed_from(&mut self, before: Vec<Drawn>) {
        if before != self.outlines {
            self.past.push(before);
            if self.past.len() > MOST_STEPS {
                self.past.remove(0);
            }
            self.future.clear();
            self.revision += 1;
        }
    }
}

/// Moves an anchor and the pieces that meet in it. True if wires are still being looked for.
fn drag(outlines: &mut [Drawn], dragging: &mut Dragging, edges: Option<&Edges>, at: Vec2) -> bool {
    let Dragging { outline, anchor, wires, .. } = dragging;
    let Some(drawn) = outlines.get_mut(*outline) else { return false };
    let n = drawn.anchors.len();
    let at = edges.map_or(at, |edges| edges.snap(at, SNAP));
    drawn.anchors[*anchor] = at;
    let beside = [(*anchor + n - 1) % n, (*anchor + 1) % n].map(|i| drawn.anchors[i]);
    let mut searching = false;
    let mut way = |k: usize| {
        let found = edges.zip(wires.as_mut()).map(|(edges, wires)| wires[k].to(edges, at, WORK));
        searching |= found == Some(None);
        found.flatten().unwrap_or_else(|| vec![beside[k], at])
    };
    let (to, mut from) = (way(0), way(1));
    from.reverse();
    drawn.pieces[(*anchor + n - 1) % n] = to;
    drawn.pieces[*anchor] = from;
    searching
}

/// True if a closed line goes around a point.
fn winds(line: &[Vec2], at: Vec2) -> bool {
    let n = line.len();
    let crosses = |i: usize| {
        let (a, b) = (line[i] - at, line[(i + 1) % n] - at);
        (a.y > 0.0) != (b.y > 0.0) && a.x + (b.x - a.x) * a.y / (a.y - b.y) > 0.0
    };
    (0..n).filter(|&i| crosses(i)).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exemplar::Image;
    use glam::Vec3;

    const MIDDLE: Vec2 = Vec2::new(60.0, 64.0);
    const RADIUS: f32 = 36.0;

    fn edges() -> Arc<Edges> {
        let image = Image::from_fn(128, 128, |x, y| {
            let inside = (RADIUS - Vec2::new(x as f32 + 0.5, y as f32 + 0.5).distance(MIDDLE) + 0.5).clamp(0.0, 1.0);
            Vec3::new(0.2 + 0.5 * inside, 0.3, 0.3)
        });
        Arc::new(Edges::new(&image))
    }

    fn near_edge(angle: f32) -> Vec2 {
        MIDDLE + Vec2::from_angle(angle) * (RADIUS + 3.0 * (7.0 * angle).sin())
    }

    fn click(cutter: &mut Cutter, at: Vec2) {
        while cutter.moved(at, false) {}
        cutter.press(at, cutter.under(at, 4.0));
        cutter.release();
    }

    fn around(cutter: &mut Cutter) {
        for k in [0, 1, 2, 3, 4, 0] {
            click(cutter, near_edge(k as f32 * 1.25));
        }
    }

    #[test]
    fn five_clicks_cut_a_disc_out_along_its_edge() {
        let mut cutter = Cutter::default();
        cutter.set_edges(edges());
        around(&mut cutter);
        assert_eq!((cutter.outlines().len(), cutter.drawing().is_some()), (1, false), "closed by a click on its beginning");
        let outline = &cutter.result()[0];
        assert_eq!(outline.check([128, 128]), Ok(()), "{outline:?}");
        let off = outline.points.iter().map(|p| (p.distance(MIDDLE) - RADIUS).abs()).fold(0.0, f32::max);
        assert!(off < 1.5, "{off} pixels off the disc's edge");
        assert_eq!(cutter.under(MIDDLE, 4.0), Under::Inside(0), "its middle is inside");
    }

    #[test]
    fn an_anchor_dragged_off_and_back_snaps_again() {
        let mut cutter = Cutter::default();
        cutter.set_edges(edges());
        around(&mut cutter);
        let before = cutter.outlines()[0].clone();
        let anchor = before.anchors[2];
        let under = cutter.under(anchor, 3.0);
        assert_eq!(under, Under::Anchor { outline: 0, anchor: 2 }, "it can be taken hold of");
        cutter.press(anchor, under);
        let away = MIDDLE + Vec2::new(-10.0, 10.0);
        while cutter.moved(away, true) {}
        assert!(cutter.outlines()[0].anchors[2].distance(away) < SNAP + 1.0, "it follows the pointer");
        while cutter.moved(anchor, true) {}
        cutter.release();
        let off = cutter.outlines()[0].line().map(|p| (p.distance(MIDDLE) - RADIUS).abs()).fold(0.0, f32::max);
        assert!(off < 1.5, "{off} pixels off the edge after all");
    }

    #[test]
    fn changes_of_outlines_go_back_and_forth() {
        let mut cutter = Cutter::default();
        around(&mut cutter);
        let one = cutter.outlines().to_vec();
        click(&mut cutter, Vec2::new(110.0, 110.0));
        click(&mut cutter, Vec2::new(120.0, 110.0));
        cutter.undo();
        assert_eq!(cutter.drawing().map(|d| d.0.anchors.len()), Some(1), "an anchor is taken back while drawing");
        cutter.undo();
        assert!(cutter.drawing().is_none(), "and the last one with it the drawing");
        cutter.press(MIDDLE, Under::Inside(0));
        assert_eq!(cutter.selected(), Some(0), "selected by a click inside");
        let revision = cutter.revision();
        cutter.delete();
        assert!(cutter.outlines().is_empty() && cutter.revision() > revision, "deleted");
        cutter.undo();
        assert_eq!(cutter.outlines(), one, "there again");
        cutter.undo();
        cutter.redo();
        assert_eq!(cutter.outlines(), one, "back and forth");
    }

    #[test]
    fn a_line_drawn_free_is_kept_as_it_was_drawn() {
        let mut cutter = Cutter::default();
        let at = |k: u32| MIDDLE + Vec2::from_angle(k as f32 * 0.1) * 30.0;
        cutter.press(at(0), Under::Nothing);
        for k in 1..55 {
            cutter.moved(at(k), true);
        }
        cutter.release();
        assert_eq!(cutter.drawing().map(|d| d.0.anchors.len()), Some(2), "its ends are anchors");
        cutter.press(at(58), Under::Nothing);
        cutter.release();
        cutter.close();
        let outline = &cutter.result()[0];
        let off = outline.points.iter().map(|p| (p.distance(MIDDLE) - 30.0).abs()).fold(0.0, f32::max);
        assert!(off < 1.0 && outline.points.len() > 8, "{off} pixels off, {} corners", outline.points.len());
    }
}
