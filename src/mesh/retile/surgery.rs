//! A mesh whose connectivity changes: flips, collapses, splits, and what must hold for each.
//!
//! The table is that of [`Mesh`]: half-edges are corners, paired by `opposite`. No operation changes the topology of the
//! surface; one that would is not possible, and says so. Dead faces and vertices stay in place until [`Surgery::compact`].

use crate::mesh::{Mesh, NONE, next, prev};
use glam::DVec3;

/// A mesh under change.
#[derive(Debug, Clone)]
pub(super) struct Surgery {
    /// Corners of each face; [`NONE`] in dead ones.
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) opposite: Vec<u32>,
    /// Per half-edge: it lies on a feature line, a boundary or a crease to be kept.
    pub(super) feature: Vec<bool>,
    /// One half-edge that starts at each vertex; [`NONE`] at dead ones.
    pub(super) start: Vec<u32>,
    pub(super) positions: Vec<DVec3>,
}

/// The half-edges that start at a vertex, counter-clockwise.
#[derive(Debug, Clone, Default)]
pub(super) struct Fan {
    pub(super) spokes: Vec<u32>,
    /// The faces go all round the vertex.
    pub(super) closed: bool,
}

impl Surgery {
    pub(super) fn new(positions: Vec<DVec3>, faces: Vec<[u32; 3]>, opposite: Vec<u32>, feature: Vec<bool>) -> Self {
        let mut start = vec![NONE; positions.len()];
        for (h, &v) in faces.as_flattened().iter().enumerate() {
            start[v as usize] = h as u32;
        }
        Self { faces, opposite, feature, start, positions }
    }

    #[inline]
    pub(super) fn origin(&self, h: u32) -> u32 {
        self.faces[(h / 3) as usize][(h % 3) as usize]
    }

    #[inline]
    pub(super) fn target(&self, h: u32) -> u32 {
        self.origin(next(h))
    }

    #[inline]
    pub(super) fn is_alive(&self, vertex: u32) -> bool {
        self.start[vertex as usize] != NONE
    }

    #[inline]
    pub(super) fn face_alive(&self, face: u32) -> bool {
        self.faces[face as usize][0] != NONE
    }

    pub(super) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.faces[face as usize].map(|v| self.positions[v as usize])
    }

    /// Twice the area times the unit normal.
    pub(super) fn area_vector(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a)
    }

    pub(super) fn length(&self, h: u32) -> f64 {
        self.positions[self.origin(h) as usize].distance(self.positions[self.target(h) as usize])
    }

    pub(super) fn fan(&self, vertex: u32, fan: &mut Fan) {
        fan.spokes.clear();
        let first = self.start[vertex as usize];
        let mut at = first;
        while at != NONE {
            fan.spokes.push(at);
            at = self.opposite[prev(at) as usize];
            if at == first {
                fan.closed = true;
                return;
            }
        }
        fan.closed = false;
        // A boundary was met: what lies clockwise of the first comes before it.
        let counter_clockwise = fan.spokes.len();
        let mut at = first;
        while self.opposite[at as usize] != NONE {
            at = next(self.opposite[at as usize]);
            fan.spokes.push(at);
        }
        fan.spokes[counter_clockwise..].reverse();
        fan.spokes.rotate_left(counter_clockwise);
    }

    /// The vertices joined to that of a fan, in its order.
    pub(super) fn rim<'a>(&'a self, fan: &'a Fan) -> impl Iterator<Item = u32> + 'a {
        let last = fan.spokes.last().filter(|_| !fan.closed).map(|&h| self.origin(prev(h)));
        fan.spokes.iter().map(|&h| self.target(h)).chain(last)
    }

    fn link(&mut self, a: u32, b: u32) {
        if a != NONE {
            self.opposite[a as usize] = b;
        }
        if b != NONE {
            self.opposite[b as usize] = a;
        }
    }

    /// The diagonal that [`Surgery::flip`] would make, if the edge may be flipped at all.
    pub(super) fn diagonal(&self, h: u32) -> Option<[u32; 2]> {
        let o = self.opposite[h as usize];
        if o == NONE || self.feature[h as usize] {
            return None;
        }
        Some([self.origin(prev(h)), self.origin(prev(o))])
    }

    pub(super) fn are_joined(&self, a: u32, b: u32, fan: &mut Fan) -> bool {
        self.fan(a, fan);
        self.rim(fan).any(|v| v == b)
    }

    /// Replaces an inner edge a-b between the faces a-b-c and b-a-d by d-c. [`Surgery::diagonal`] must allow it and c and d
    /// not be joined yet.
    pub(super) fn flip(&mut self, h: u32) {
        let o = self.opposite[h as usize];
        let (a, b, c, d) = (self.origin(h), self.origin(o), self.origin(prev(h)), self.origin(prev(o)));
        let outer = [next(o), prev(o), next(h), prev(h)].map(|e| (self.opposite[e as usize], self.feature[e as usize]));
        let (f, g) = (3 * (h / 3), 3 * (o / 3));
        self.faces[(f / 3) as usize] = [a, d, c];
        self.faces[(g / 3) as usize] = [d, b, c];
        for (e, (beyond, feature)) in [f, g, g + 1, f + 2].into_iter().zip(outer) {
            self.link(e, beyond);
            self.feature[e as usize] = feature;
        }
        self.link(f + 1, g + 2);
        self.feature[(f + 1) as usize] = false;
        self.feature[(g + 2) as usize] = false;
        self.start[a as usize] = f;
        self.start[d as usize] = g;
        self.start[b as usize] = g + 1;
        self.start[c as usize] = f + 2;
    }

    /// True if pulling one end of an edge into the other leaves the surface what it is: the two vertices have no common
    /// neighbours but those beside the edge, and no edge closes two boundaries or two sheets upon each other.
    pub(super) fn can_collapse(&self, h: u32, fan: &mut Fan, others: &mut Fan) -> bool {
        let (v, u) = (self.origin(h), self.target(h));
        let o = self.opposite[h as usize];
        self.fan(v, fan);
        self.fan(u, others);
        if !fan.closed && !others.closed && o != NONE {
            return false;
        }
        let apex = self.origin(prev(h));
        let other = if o == NONE { NONE } else { self.origin(prev(o)) };
        let shared = self.rim(fan).filter(|&w| self.rim(others).any(|x| x == w)).count();
        if shared != if o == NONE { 1 } else { 2 } {
            return false;
        }
        // Beside the edge, each triangle's two other sides become one; that one must still have a face, and at the apex
        // enough faces must be left.
        let side = |e: u32, apex: u32, fan: &mut Fan| {
            let bare = self.opposite[next(e) as usize] == NONE && self.opposite[prev(e) as usize] == NONE;
            self.fan(apex, fan);
            !bare && !(fan.closed && fan.spokes.len() <= 3)
        };
        side(h, apex, fan) && (o == NONE || side(o, other, fan))
    }

    /// Pulls `gone`, one end of the edge of `h`, into the other. [`Surgery::can_collapse`] must allow it.
    pub(super) fn collapse(&mut self, h: u32, gone: u32, fan: &mut Fan) {
        let left = if self.origin(h) == gone { self.target(h) } else { self.origin(h) };
        let o = self.opposite[h as usize];
        self.fan(gone, fan);
        for &spoke in &fan.spokes {
            self.faces[(spoke / 3) as usize][(spoke % 3) as usize] = left;
        }
        for e in [h, o] {
            if e == NONE {
                continue;
            }
            let (after, before) = (next(e), prev(e));
            let feature = self.feature[after as usize] || self.feature[before as usize];
            let (x, y) = (self.opposite[after as usize], self.opposite[before as usize]);
            self.link(x, y);
            for side in [x, y] {
                if side != NONE {
                    self.feature[side as usize] = feature;
                    let ends = [self.origin(side), self.target(side)];
                    self.start[ends[0] as usize] = side;
                    self.start[ends[1] as usize] = next(side);
                }
            }
            self.faces[(e / 3) as usize] = [NONE; 3];
        }
        self.start[gone as usize] = NONE;
    }

    /// Cuts an edge at a new vertex.
    pub(super) fn split_edge(&mut self, h: u32, at: DVec3) -> u32 {
        let m = self.positions.len() as u32;
        self.positions.push(at);
        self.start.push(NONE);
        let o = self.opposite[h as usize];
        let feature = self.feature[h as usize];
        let half = |s: &mut Self, e: u32| {
            // The face keeps the half at the origin of `e`; a new one takes the half at its target.
            let (u, apex) = (s.target(e), s.origin(prev(e)));
            let fresh = 3 * s.faces.len() as u32;
            s.faces.push([m, u, apex]);
            s.opposite.extend([NONE; 3]);
            let beyond = next(e);
            s.feature.extend([feature, s.feature[beyond as usize], false]);
            s.link(fresh + 1, s.opposite[beyond as usize]);
            s.link(fresh + 2, beyond);
            s.feature[beyond as usize] = false;
            s.faces[(e / 3) as usize][(beyond % 3) as usize] = m;
            s.start[u as usize] = fresh + 1;
            s.start[apex as usize] = fresh + 2;
            s.start[m as usize] = fresh;
            fresh
        };
        let first = half(self, h);
        if o == NONE {
            self.opposite[first as usize] = NONE;
        } else {
            let second = half(self, o);
            self.link(first, o);
            self.link(h, second);
        }
        m
    }

    /// Cuts a face in three at a new vertex.
    pub(super) fn split_face(&mut self, face: u32, at: DVec3) -> u32 {
        let m = self.positions.len() as u32;
        self.positions.push(at);
        let [a, b, c] = self.faces[face as usize];
        let f = 3 * face;
        let (g, i) = (3 * self.faces.len() as u32, 3 * self.faces.len() as u32 + 3);
        self.faces[face as usize] = [a, b, m];
        self.faces.extend([[b, c, m], [c, a, m]]);
        self.opposite.extend([NONE; 6]);
        let (bc, ca) = (self.feature[f as usize + 1], self.feature[f as usize + 2]);
        self.feature.extend([bc, false, false, ca, false, false]);
        self.link(g, self.opposite[f as usize + 1]);
        self.link(i, self.opposite[f as usize + 2]);
        self.link(f + 1, g + 2);
        self.link(g + 1, i + 2);
        self.link(i + 1, f + 2);
        self.feature[f as usize + 1] = false;
        self.feature[f as usize + 2] = false;
        self.start.push(f + 2);
        self.start[a as usize] = f;
        self.start[b as usize] = g;
        self.start[c as usize] = i;
        m
    }

    pub(super) fn alive_vertices(&self) -> usize {
        self.start.iter().filter(|&&h| h != NONE).count()
    }

    /// Forgets dead vertices and faces. Returns the old number of each vertex that is left, which is also the order asked for if
    /// `order` gives one.
    pub(super) fn compact(&mut self, order: Option<Vec<u32>>) -> Vec<u32> {
        let kept = order.unwrap_or_else(|| self.alive());
        let mut vertex = vec![NONE; self.start.len()];
        kept.iter().enumerate().for_each(|(i, &v)| vertex[v as usize] = i as u32);
        let place = |f: u32| self.faces[f as usize].map(|v| vertex[v as usize]);
        let mut faces: Vec<u32> = (0..self.faces.len() as u32).filter(|&f| self.face_alive(f)).collect();
        if !kept.is_sorted() {
            faces.sort_by_cached_key(|&f| (place(f).into_iter().min(), f));
        }
        let mut face = vec![NONE; self.faces.len()];
        faces.iter().enumerate().for_each(|(i, &f)| face[f as usize] = i as u32);
        let moved = |h: u32| if h == NONE { NONE } else { 3 * face[(h / 3) as usize] + h % 3 };
        let sides = || faces.iter().flat_map(|&f| 3 * f as usize..3 * f as usize + 3);
        let opposite = sides().map(|h| moved(self.opposite[h])).collect();
        let feature = sides().map(|h| self.feature[h]).collect();
        let positions = kept.iter().map(|&v| self.positions[v as usize]).collect();
        let start = kept.iter().map(|&v| moved(self.start[v as usize])).collect();
        let faces = faces.iter().map(|&f| place(f)).collect();
        *self = Self { faces, opposite, feature, start, positions };
        kept
    }

    /// Vertices that are left.
    pub(super) fn alive(&self) -> Vec<u32> {
        (0..self.start.len() as u32).filter(|&v| self.is_alive(v)).collect()
    }

    /// The mesh as it is; nothing in it may be dead.
    pub(super) fn mesh(&self) -> Mesh {
        let positions = self.positions.iter().map(|p| p.as_vec3()).collect();
        Mesh { positions, faces: self.faces.clone(), opposite: self.opposite.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::random::Random;

    fn surgery(mesh: &Mesh) -> Surgery {
        let positions = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        Surgery::new(positions, mesh.faces.clone(), mesh.opposite.clone(), vec![false; mesh.opposite.len()])
    }

    /// The table must be the one that the faces alone give.
    fn check(s: &Surgery, euler: i64) {
        let mut compact = s.clone();
        compact.compact(None);
        let mesh = compact.mesh();
        mesh.check().expect("invariants");
        let twin = Mesh::new(mesh.positions.clone(), mesh.faces.clone()).expect("a manifold");
        assert_eq!(mesh.opposite, twin.opposite, "the table is the one that the faces give");
        assert_eq!(mesh.euler_characteristic(), euler, "Euler characteristic");
        let mut fan = Fan::default();
        for v in (0..s.start.len() as u32).filter(|&v| s.is_alive(v)) {
            assert_eq!(s.origin(s.start[v as usize]), v, "the half-edge of vertex {v} starts there");
            s.fan(v, &mut fan);
            assert!(fan.spokes.iter().all(|&h| s.origin(h) == v), "fan of {v}");
        }
        for (h, &o) in s.opposite.iter().enumerate() {
            if s.face_alive(h as u32 / 3) && o != NONE {
                assert_eq!(s.opposite[o as usize], h as u32, "opposites name each other");
                assert_eq!(s.origin(h as u32), s.target(o), "and run back");
            }
        }
    }

    #[test]
    fn any_sequence_of_operations_keeps_the_topology() {
        for mesh in [shapes::sphere(2), shapes::torus(14, 9, 1.0, 0.4), shapes::uneven_square(7)] {
            let euler = mesh.euler_characteristic();
            let mut s = surgery(&mesh);
            let mut random = Random::new(5, 0);
            let (mut fan, mut others) = (Fan::default(), Fan::default());
            let mut done = [0; 4];
            for round in 0..3000 {
                let h = random.below(3 * s.faces.len() as u64) as u32;
                if !s.face_alive(h / 3) {
                    continue;
                }
                // Growing and shrinking in turns, down to the smallest mesh there is.
                let kind = if round / 500 % 2 == 0 { random.below(4) } else { random.below(2) };
                match kind {
                    0 => {
                        if let Some([a, b]) = s.diagonal(h)
                            && !s.are_joined(a, b, &mut fan)
                        {
                            s.flip(h);
                            done[0] += 1;
                        }
                    }
                    1 => {
                        if s.can_collapse(h, &mut fan, &mut others) {
                            let gone = if random.unit() < 0.5 { s.origin(h) } else { s.target(h) };
                            s.collapse(h, gone, &mut fan);
                            done[1] += 1;
                        }
                    }
                    2 => {
                        s.split_edge(h, DVec3::splat(f64::from(round)));
                        done[2] += 1;
                    }
                    _ => {
                        s.split_face(h / 3, DVec3::splat(f64::from(round)));
                        done[3] += 1;
                    }
                }
                if round % 100 == 0 {
                    check(&s, euler);
                }
            }
            check(&s, euler);
            assert!(done.iter().all(|&n| n > 50), "all four happened: {done:?}");
        }
    }

    #[test]
    fn nothing_smaller_than_a_tetrahedron_is_left() {
        let mesh = shapes::sphere(2);
        let mut s = surgery(&mesh);
        let (mut fan, mut others) = (Fan::default(), Fan::default());
        for _ in 0..40 {
            for h in 0..3 * s.faces.len() as u32 {
                if s.face_alive(h / 3) && s.can_collapse(h, &mut fan, &mut others) {
                    s.collapse(h, s.origin(h), &mut fan);
                }
            }
        }
        assert_eq!(s.alive_vertices(), 4, "a sphere ends as a tetrahedron");
        check(&s, 2);
    }

    #[test]
    fn features_stay_on_their_edges() {
        let mesh = shapes::uneven_square(6);
        let mut s = surgery(&mesh);
        let line = |s: &Surgery| {
            let on = (0..3 * s.faces.len() as u32).filter(|&h| s.face_alive(h / 3) && s.feature[h as usize]);
            on.map(|h| s.length(h)).sum::<f64>()
        };
        for h in 0..s.opposite.len() {
            s.feature[h] = s.opposite[h] == NONE;
        }
        assert!((line(&s) - 4.0).abs() < 1e-6, "the square's outline");
        let mut fan = Fan::default();
        for h in 0..60 {
            let middle = (s.positions[s.origin(h) as usize] + s.positions[s.target(h) as usize]) / 2.0;
            s.split_edge(h, middle);
            let face = h / 3;
            let [a, b, c] = s.corners(face);
            s.split_face(face, (a + b + c) / 3.0);
            if let Some([a, b]) = s.diagonal(h)
                && !s.are_joined(a, b, &mut fan)
            {
                s.flip(h);
            }
        }
        assert!((line(&s) - 4.0).abs() < 1e-6, "still, {}", line(&s));
        check(&s, 1);
    }
}
