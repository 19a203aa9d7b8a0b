//! Parametric surfaces: a torus knot, a vase, a hilly island.

use super::Triangles;
use super::noise::fractal3;
use super::portable::{cos, exp, sin};
use glam::DVec3;
use std::f64::consts::TAU;

/// The (2, 3) torus knot as a tube of about 5,000 faces, 2 units tall, standing on y = 0.
pub(crate) fn knot() -> Triangles {
    /// Samples of the curve from which arc length and frames are taken.
    const SAMPLES: usize = 4000;
    /// Vertices around the tube.
    const AROUND: usize = 18;
    /// Radius of the tube.
    const RADIUS: f64 = 0.2;
    let curve = |t: f64| {
        let a = TAU * t;
        let r = 0.56 + 0.235 * cos(3.0 * a);
        DVec3::new(r * sin(2.0 * a), r * cos(2.0 * a), 0.3 * sin(3.0 * a))
    };
    let points: Vec<DVec3> = (0..=SAMPLES).map(|i| curve(i as f64 / SAMPLES as f64)).collect();
    let tangent = |i: usize| (points[(i + 1) % SAMPLES] - points[(i + SAMPLES - 1) % SAMPLES]).normalize();
    let mut length = vec![0.0];
    let mut frame = vec![tangent(0).any_orthonormal_vector()];
    for i in 1..=SAMPLES {
        length.push(length[i - 1] + points[i].distance(points[i - 1]));
        // Carried along without turning about the tangent.
        let t = tangent(i % SAMPLES);
        let carried = frame[i - 1] - t * t.dot(frame[i - 1]);
        frame.push(carried.normalize());
    }
    // What the frame has turned by after one round is given back evenly, so that it closes.
    let (t, end) = (tangent(0), frame[SAMPLES]);
    let (side, front) = (end.dot(t.cross(frame[0])), end.dot(frame[0]));
    let around = TAU * RADIUS / AROUND as f64;
    // Rows of equilateral triangles, each row half a step on; an even number of them closes.
    let rows = 2 * (length[SAMPLES] / (around * 0.75_f64.sqrt()) / 2.0).round() as usize;
    let twist = angle_of(front, side);
    let mut out = Triangles::default();
    for row in 0..rows {
        let s = length[SAMPLES] * row as f64 / rows as f64;
        let i = length.partition_point(|&l| l <= s).min(SAMPLES) - 1;
        let part = (s - length[i]) / (length[i + 1] - length[i]);
        let (centre, t) = (points[i].lerp(points[i + 1], part), tangent(i).lerp(tangent((i + 1) % SAMPLES), part).normalize());
        let u = frame[i].lerp(frame[i + 1], part);
        let u = (u - t * t.dot(u)).normalize();
        let v = t.cross(u);
        for k in 0..AROUND {
            let a = TAU * (k as f64 + 0.5 * (row % 2) as f64) / AROUND as f64 - twist * s / length[SAMPLES];
            out.positions.push(centre + RADIUS * (u * cos(a) + v * sin(a)));
        }
    }
    for row in 0..rows {
        let at = |r: usize, k: usize| ((r % rows) * AROUND + k % AROUND) as u32;
        for k in 0..AROUND {
            let (a, b, c, d) = (at(row, k), at(row, k + 1), at(row + 1, k), at(row + 1, k + 1));
            // The next row lies half a step ahead of an even row and half a step behind an odd one's next vertex.
            if row % 2 == 0 {
                out.faces.extend([[a, b, c], [b, d, c]]);
            } else {
                out.faces.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    rest(out)
}

/// Angle of (x, y) by bisection on our own cosine, so that it rounds alike everywhere.
fn angle_of(x: f64, y: f64) -> f64 {
    let target = x / (x * x + y * y).sqrt();
    let (mut low, mut high) = (0.0, std::f64::consts::PI);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if cos(middle) > target { low = middle } else { high = middle }
    }
    if y < 0.0 { -low } else { low }
}

/// Lifts or lowers a mesh to stand on y = 0.
pub(crate) fn rest(mut mesh: Triangles) -> Triangles {
    let low = mesh.positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    for p in &mut mesh.positions {
        p.y -= low;
    }
    mesh
}

/// A vase with a curled lip and soft flutes, open at the top, 2 units tall, about 5,000 faces.
pub(crate) fn vase() -> Triangles {
    /// Edge length.
    const EDGE: f64 = 0.0585;
    /// Radius and height along the wall, from the middle of the foot to the lip.
    const PROFILE: [[f64; 2]; 13] = [
        [0.0, 0.03],
        [0.2, 0.02],
        [0.34, 0.0],
        [0.385, 0.05],
        [0.33, 0.14],
        [0.4, 0.3],
        [0.62, 0.62],
        [0.71, 0.95],
        [0.6, 1.27],
        [0.36, 1.5],
        [0.27, 1.69],
        [0.33, 1.88],
        [0.47, 2.0],
    ];
    let at = |i: i64| PROFILE[i.clamp(0, PROFILE.len() as i64 - 1) as usize];
    let mut line: Vec<[f64; 2]> = vec![PROFILE[0]];
    for span in 0..PROFILE.len() as i64 - 1 {
        for step in 1..=40 {
            let t = f64::from(step) / 40.0;
            let (p0, p1, p2, p3) = (at(span - 1), at(span), at(span + 1), at(span + 2));
            line.push(std::array::from_fn(|k| {
                let (a, b) = (0.5 * (p2[k] - p0[k]), 0.5 * (p3[k] - p1[k]));
                p1[k] + t * (a + t * (3.0 * (p2[k] - p1[k]) - 2.0 * a - b + t * (2.0 * (p1[k] - p2[k]) + a + b)))
            }));
        }
    }
    let mut mesh = disc(&line, EDGE);
    for p in &mut mesh.positions {
        let r = (p.x * p.x + p.z * p.z).sqrt();
        // Flutes on the belly, fading towards foot and neck.
        let fade = exp(-(p.y - 0.88) * (p.y - 0.88) / 0.13);
        let (c, s) = (p.x / r.max(1e-9), p.z / r.max(1e-9));
        let wave = cos(10.0 * angle_of(c, s));
        let scale = 1.0 + 0.045 * fade * wave;
        (p.x, p.z) = (p.x * scale, p.z * scale);
    }
    mesh
}

/// A round patch of hills, 2.4 units across and 0.9 high, open all around, about 5,000 faces.
pub(crate) fn terrain() -> Triangles {
    /// Edge length in plan.
    const EDGE: f64 = 0.046;
    let plan: Vec<[f64; 2]> = (0..=400).map(|i| [1.2 * f64::from(i) / 400.0, 0.0]).collect();
    let mut mesh = disc(&plan, EDGE);
    // The disc's outward side is below; hills look up.
    for face in &mut mesh.faces {
        face.swap(1, 2);
    }
    for p in &mut mesh.positions {
        let q = DVec3::new(p.x, 0.37, p.z);
        let warp = DVec3::new(fractal3(q * 1.3, 2, 11), 0.0, fractal3(q * 1.3, 2, 12)) * 0.12;
        let ridge = (1.0 - fractal3((q + warp) * 1.5, 3, 5).abs() * 1.5).max(0.0);
        let broad = fractal3(q * 0.9 + 3.1, 2, 7);
        let detail = fractal3(q * 5.0, 2, 9);
        // One mountain off the middle, foothills around.
        let (dx, dz) = (p.x + 0.15, p.z + 0.2);
        let mountain = exp(-(dx * dx + dz * dz) / 0.42);
        p.y = mountain * (0.42 + 0.42 * ridge) + 0.14 * ridge + 0.12 * broad + 0.025 * detail;
    }
    rest(mesh)
}

/// A surface of revolution about y, closed at its first point (on the axis), open at its last: rings of evenly spaced
/// vertices, stitched. Outward is to the right of the profile as it runs.
fn disc(line: &[[f64; 2]], edge: f64) -> Triangles {
    let mut length = vec![0.0];
    for w in line.windows(2) {
        let (dx, dy) = (w[1][0] - w[0][0], w[1][1] - w[0][1]);
        length.push(length[length.len() - 1] + (dx * dx + dy * dy).sqrt());
    }
    let whole = length[length.len() - 1];
    let rows = (whole / (edge * 0.75_f64.sqrt())).round() as usize;
    let mut out = Triangles::default();
    let mut rings: Vec<(u32, u32, f64)> = Vec::new();
    for row in 0..=rows {
        let s = whole * row as f64 / rows as f64;
        let i = (length.partition_point(|&l| l <= s)).clamp(1, line.len() - 1) - 1;
        let t = ((s - length[i]) / (length[i + 1] - length[i])).min(1.0);
        let (r, y) = (line[i][0] + t * (line[i + 1][0] - line[i][0]), line[i][1] + t * (line[i + 1][1] - line[i][1]));
        let count = if row == 0 { 1 } else { ((TAU * r / edge).round() as u32).max(5) };
        // Neighbouring rings are turned against each other by half a step.
        let phase = if row % 2 == 0 { 0.0 } else { 0.5 / f64::from(count) };
        rings.push((out.positions.len() as u32, count, phase));
        for k in 0..count {
            let a = TAU * (f64::from(k) / f64::from(count) + phase);
            out.positions.push(DVec3::new(r * cos(a), y, r * sin(a)));
        }
    }
    for pair in rings.windows(2) {
        let ((start, count, phase), (start2, count2, phase2)) = (pair[0], pair[1]);
        if count == 1 {
            out.faces.extend((0..count2).map(|k| [start, start2 + k, start2 + (k + 1) % count2]));
            continue;
        }
        // Walk both rings at once, stepping on the one whose next vertex comes first.
        let (mut i, mut j) = (0, 0);
        while i < count || j < count2 {
            let next = (f64::from(i) + 1.0) / f64::from(count) + phase;
            let next2 = (f64::from(j) + 1.0) / f64::from(count2) + phase2;
            let (a, b) = (start + i % count, start2 + j % count2);
            if j == count2 || (i < count && next <= next2) {
                out.faces.push([a, b, start + (i + 1) % count]);
                i += 1;
            } else {
                out.faces.push([a, b, start2 + (j + 1) % count2]);
                j += 1;
            }
        }
    }
    out
}
