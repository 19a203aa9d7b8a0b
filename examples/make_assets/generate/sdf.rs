//! Signed distance fields of soft bodies: simple shapes joined one after the other by smooth unions.

use glam::{DMat3, DVec3};

/// A cone with a sphere at either end.
#[derive(Debug, Clone, Copy)]
struct RoundCone {
    a: DVec3,
    b: DVec3,
    ra: f64,
    rb: f64,
}

impl RoundCone {
    fn distance(&self, p: DVec3) -> f64 {
        let axis = self.b - self.a;
        let length = axis.length();
        let sine = (self.ra - self.rb) / length;
        if sine.abs() >= 1.0 {
            // One sphere holds the other.
            return if sine > 0.0 { p.distance(self.a) - self.ra } else { p.distance(self.b) - self.rb };
        }
        let cosine = (1.0 - sine * sine).sqrt();
        let along = (p - self.a).dot(axis) / length;
        let away = ((p - self.a).length_squared() - along * along).max(0.0).sqrt();
        // Position along the slanted side, from the one tangent circle to the other.
        let side = along * cosine - away * sine;
        if side <= 0.0 {
            p.distance(self.a) - self.ra
        } else if side >= length * cosine {
            p.distance(self.b) - self.rb
        } else {
            along * sine + away * cosine - self.ra
        }
    }
}

/// A shape of its own.
#[derive(Debug, Clone)]
enum Shape {
    /// Centre, radii, and the rotation into its axes. Its distance is the usual first-order estimate.
    Ellipsoid(DVec3, DVec3, DMat3),
    /// A chain of round cones.
    Tube(Vec<RoundCone>),
    /// A triangle grown by a radius.
    Web([DVec3; 3], f64),
}

impl Shape {
    fn distance(&self, p: DVec3) -> f64 {
        match self {
            Self::Ellipsoid(centre, radii, turn) => {
                let q = *turn * (p - *centre);
                let (k0, k1) = ((q / *radii).length(), (q / (*radii * *radii)).length());
                if k1 > 0.0 { k0 * (k0 - 1.0) / k1 } else { -radii.min_element() }
            }
            Self::Tube(cones) => cones.iter().map(|c| c.distance(p)).fold(f64::INFINITY, f64::min),
            Self::Web(corners, radius) => triangle_distance(*corners, p) - radius,
        }
    }

    /// A sphere around it.
    fn bound(&self) -> (DVec3, f64) {
        match self {
            Self::Ellipsoid(centre, radii, _) => (*centre, radii.max_element()),
            Self::Tube(cones) => {
                let balls = cones.iter().flat_map(|c| [(c.a, c.ra), (c.b, c.rb)]);
                let centre = balls.clone().map(|(c, _)| c).sum::<DVec3>() / (2 * cones.len()) as f64;
                (centre, balls.map(|(c, r)| c.distance(centre) + r).fold(0.0, f64::max))
            }
            Self::Web(corners, radius) => {
                let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
                (centre, corners.map(|c| c.distance(centre)).into_iter().fold(0.0, f64::max) + radius)
            }
        }
    }
}

fn triangle_distance([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let n = (b - a).cross(c - a);
    let inside = |u: DVec3, v: DVec3| (v - u).cross(n).dot(p - u) <= 0.0;
    if inside(a, b) && inside(b, c) && inside(c, a) {
        return (p - a).dot(n).abs() / n.length();
    }
    let edge = |u: DVec3, v: DVec3| {
        let t = ((p - u).dot(v - u) / (v - u).length_squared()).clamp(0.0, 1.0);
        p.distance(u + (v - u) * t)
    };
    edge(a, b).min(edge(b, c)).min(edge(c, a))
}

#[derive(Debug, Clone)]
struct Part {
    shape: Shape,
    blend: f64,
    mirrored: bool,
    carve: bool,
    bound: (DVec3, f64),
}

/// A body: parts joined in order.
#[derive(Debug, Clone, Default)]
pub(crate) struct Body {
    parts: Vec<Part>,
    mirrored: bool,
    blend: f64,
    carve: bool,
}

impl Body {
    /// How the parts that follow are joined: the width of the smooth union, and whether they come twice, mirrored in the
    /// plane x = 0.
    pub(crate) fn join(&mut self, blend: f64, mirrored: bool) -> &mut Self {
        (self.blend, self.mirrored, self.carve) = (blend, mirrored, false);
        self
    }

    /// The parts that follow are cut away instead.
    pub(crate) fn carve(&mut self, blend: f64, mirrored: bool) -> &mut Self {
        (self.blend, self.mirrored, self.carve) = (blend, mirrored, true);
        self
    }

    /// A ball.
    pub(crate) fn ball(&mut self, centre: [f64; 3], radius: f64) -> &mut Self {
        self.ellipsoid(centre, [radius; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    }

    /// An ellipsoid along the axes.
    pub(crate) fn egg(&mut self, centre: [f64; 3], radii: [f64; 3]) -> &mut Self {
        self.ellipsoid(centre, radii, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    }

    /// An ellipsoid whose first radius lies along `first`, the second nearest to `second`.
    pub(crate) fn ellipsoid(&mut self, centre: [f64; 3], radii: [f64; 3], first: [f64; 3], second: [f64; 3]) -> &mut Self {
        let x = DVec3::from(first).normalize();
        let z = x.cross(DVec3::from(second)).normalize();
        let turn = DMat3::from_cols(x, z.cross(x), z).transpose();
        self.push(Shape::Ellipsoid(centre.into(), radii.into(), turn))
    }

    /// A limb through points with radii `[x, y, z, r]`, curved (Catmull-Rom) where there are more than two.
    pub(crate) fn limb(&mut self, points: &[[f64; 4]]) -> &mut Self {
        /// Straight pieces for each span of a curved limb.
        const PIECES: usize = 6;
        let at = |i: i64| points[i.clamp(0, points.len() as i64 - 1) as usize];
        let pieces = if points.len() > 2 { PIECES } else { 1 };
        let mut line = vec![points[0]];
        for span in 0..points.len() as i64 - 1 {
            let (p0, p1, p2, p3) = (at(span - 1), at(span), at(span + 1), at(span + 2));
            for step in 1..=pieces {
                let t = step as f64 / pieces as f64;
                line.push(std::array::from_fn(|k| {
                    let (a, b) = (0.5 * (p2[k] - p0[k]), 0.5 * (p3[k] - p1[k]));
                    let (d, e) = (3.0 * (p2[k] - p1[k]) - 2.0 * a - b, 2.0 * (p1[k] - p2[k]) + a + b);
                    if pieces == 1 { p1[k] + t * (p2[k] - p1[k]) } else { p1[k] + t * (a + t * (d + t * e)) }
                }));
            }
        }
        let point = |q: [f64; 4]| DVec3::new(q[0], q[1], q[2]);
        let cones = line.windows(2).map(|w| RoundCone { a: point(w[0]), b: point(w[1]), ra: w[0][3], rb: w[1][3] }).collect();
        self.push(Shape::Tube(cones))
    }

    /// A triangular skin of a thickness of twice `radius`.
    pub(crate) fn web(&mut self, corners: [[f64; 3]; 3], radius: f64) -> &mut Self {
        self.push(Shape::Web(corners.map(DVec3::from), radius))
    }

    fn push(&mut self, shape: Shape) -> &mut Self {
        let bound = shape.bound();
        self.parts.push(Part { shape, blend: self.blend, mirrored: self.mirrored, carve: self.carve, bound });
        self
    }

    /// Signed distance, negative inside: close to the surface nearly Euclidean.
    pub(crate) fn distance(&self, p: DVec3) -> f64 {
        let folded = DVec3::new(p.x.abs(), p.y, p.z);
        let mut all = f64::INFINITY;
        for part in &self.parts {
            let q = if part.mirrored { folded } else { p };
            // What is out of reach of the union, or of the cut, changes nothing.
            let least = q.distance(part.bound.0) - part.bound.1;
            if least > part.blend + if part.carve { -all } else { all } {
                continue;
            }
            let d = part.shape.distance(q);
            all = if part.carve { -smooth_min(-all, d, part.blend) } else { smooth_min(all, d, part.blend) };
        }
        all
    }

    /// Unit outward direction of steepest ascent.
    pub(crate) fn normal(&self, p: DVec3) -> DVec3 {
        /// Half the width of the central differences: far below any feature, far above rounding.
        const STEP: f64 = 1e-4;
        let along = |axis: DVec3| self.distance(p + axis * STEP) - self.distance(p - axis * STEP);
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)).normalize_or_zero()
    }

    /// The point of the surface reached by walking along the gradient.
    pub(crate) fn project(&self, mut p: DVec3) -> DVec3 {
        /// Newton steps; each squares the error.
        const STEPS: usize = 4;
        for _ in 0..STEPS {
            let d = self.distance(p);
            if d.abs() < 1e-7 {
                break;
            }
            p -= self.normal(p) * d;
        }
        p
    }
}

/// Quadratic smooth minimum: the plain minimum where the two differ by more than `k`.
fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    if k <= 0.0 || (a - b).abs() >= k || a.is_infinite() {
        return a.min(b);
    }
    let h = (k - (a - b).abs()) / k;
    a.min(b) - h * h * k * 0.25
}
