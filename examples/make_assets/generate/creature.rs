//! The hero: a dragonling that sits and looks at you. About 2 units tall, on y = 0, facing +z.

use super::Triangles;
use super::remesh::{Fineness, mesh_body};
use super::sdf::Body;
use glam::DVec3;

/// About 6,000 faces.
pub(crate) fn coarse() -> Triangles {
    mesh(Detail::Plain, Fineness { cell: 0.042, longest: 0.17, shortest: 0.048, bend: 0.45 })
}

/// About 25,000 faces.
pub(crate) fn fine() -> Triangles {
    mesh(Detail::Full, Fineness { cell: 0.026, longest: 0.064, shortest: 0.019, bend: 0.37 })
}

fn mesh(detail: Detail, fineness: Fineness) -> Triangles {
    mesh_body(&dragonling(detail), DVec3::new(-1.3, -0.15, -1.4), DVec3::new(1.3, 2.4, 1.1), fineness)
}

/// How much of the small print to model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Detail {
    /// Only what a coarse mesh can show.
    Plain,
    /// Claws, nostrils and thin skins too.
    Full,
}

fn dragonling(detail: Detail) -> Body {
    let mut body = Body::default();
    trunk(&mut body);
    head(&mut body, detail);
    legs(&mut body, detail);
    wings(&mut body, detail);
    tail_and_crest(&mut body);
    body
}

fn trunk(body: &mut Body) {
    body.join(0.22, false).egg([0.0, 0.48, -0.1], [0.43, 0.43, 0.42]);
    body.egg([0.0, 0.62, 0.08], [0.37, 0.4, 0.36]);
    body.egg([0.0, 0.95, 0.05], [0.275, 0.33, 0.265]);
    body.limb(&[[0.0, 1.1, 0.03, 0.2], [0.0, 1.42, 0.1, 0.17]]);
}

fn head(body: &mut Body, detail: Detail) {
    body.join(0.1, false).egg([0.0, 1.6, 0.12], [0.37, 0.32, 0.34]);
    // Snout, cheeks, chin.
    body.join(0.12, false).egg([0.0, 1.49, 0.42], [0.235, 0.155, 0.27]);
    body.join(0.1, true).ball([0.2, 1.47, 0.24], 0.17);
    // Nostrils on small bumps.
    body.join(0.05, true).ball([0.085, 1.575, 0.62], 0.05);
    if detail == Detail::Full {
        body.carve(0.025, true).ball([0.1, 1.6, 0.67], 0.024);
    }
    // A smile along the snout.
    body.carve(0.03, true).limb(&[
        [0.0, 1.43, 0.7, 0.016],
        [0.12, 1.432, 0.655, 0.017],
        [0.215, 1.445, 0.5, 0.017],
        [0.28, 1.5, 0.38, 0.014],
    ]);
    // Eyes below brows.
    body.join(0.012, true).ball([0.208, 1.665, 0.345], 0.126);
    body.join(0.05, true).limb(&[[0.11, 1.81, 0.35, 0.03], [0.215, 1.84, 0.32, 0.042], [0.335, 1.77, 0.22, 0.03]]);
    // Horns.
    body.join(0.05, true).limb(&[
        [0.17, 1.82, 0.02, 0.09],
        [0.22, 1.99, -0.08, 0.07],
        [0.25, 2.12, -0.24, 0.045],
        [0.24, 2.17, -0.4, 0.024],
    ]);
    // Ears: leaves that open to the front.
    body.join(0.06, true).ellipsoid([0.48, 1.66, -0.04], [0.24, 0.125, 0.05], [1.0, 0.55, -0.35], [-0.4, 1.0, 0.2]);
    body.carve(0.03, true).ellipsoid([0.52, 1.68, 0.035], [0.15, 0.065, 0.05], [1.0, 0.55, -0.35], [-0.4, 1.0, 0.2]);
}

fn legs(body: &mut Body, detail: Detail) {
    // Hind legs: thigh, shank, foot, toes.
    body.join(0.08, true).ellipsoid([0.4, 0.36, 0.06], [0.19, 0.33, 0.3], [1.0, 0.0, -0.25], [0.25, 1.0, 0.35]);
    body.join(0.06, true).egg([0.49, 0.1, 0.34], [0.125, 0.1, 0.24]);
    body.join(0.035, true);
    for (x, z) in [(0.40, 0.55), (0.49, 0.585), (0.58, 0.545)] {
        body.ball([x, 0.07, z], 0.06);
    }
    body.join(0.012, true);
    let claws = |places: [(f64, f64); 3]| places.into_iter().filter(move |_| detail == Detail::Full);
    for (x, z) in claws([(0.40, 0.6), (0.49, 0.635), (0.58, 0.595)]) {
        body.limb(&[[x, 0.068, z, 0.036], [x, 0.04, z + 0.055, 0.02]]);
    }
    // Fore legs.
    body.join(0.09, true).limb(&[
        [0.24, 0.95, 0.1, 0.14],
        [0.275, 0.68, 0.29, 0.108],
        [0.23, 0.4, 0.41, 0.084],
        [0.195, 0.14, 0.45, 0.085],
    ]);
    body.join(0.05, true).egg([0.185, 0.085, 0.48], [0.115, 0.085, 0.13]);
    body.join(0.03, true);
    for (x, z) in [(0.11, 0.585), (0.185, 0.61), (0.26, 0.585)] {
        body.ball([x, 0.058, z], 0.048);
    }
    body.join(0.012, true);
    for (x, z) in claws([(0.11, 0.62), (0.185, 0.645), (0.26, 0.62)]) {
        body.limb(&[[x, 0.056, z, 0.032], [x, 0.034, z + 0.045, 0.018]]);
    }
}

fn wings(body: &mut Body, detail: Detail) {
    let (shoulder, wrist) = ([0.17, 1.04, -0.17], [0.5, 1.42, -0.42]);
    let tips = [[0.98, 1.3, -0.6], [0.9, 0.98, -0.62], [0.62, 0.78, -0.52]];
    let point = |p: [f64; 3], r: f64| [p[0], p[1], p[2], r];
    body.join(0.05, true).limb(&[point(shoulder, 0.085), [0.34, 1.3, -0.34, 0.06], point(wrist, 0.055)]);
    for tip in tips {
        let middle = std::array::from_fn(|k| 0.5 * (wrist[k] + tip[k]) + [0.05, 0.05, -0.03][k]);
        body.limb(&[point(wrist, 0.05), point(middle, 0.042), point(tip, 0.026)]);
    }
    // Skin between the fingers, drawn in at its hem.
    let hem = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| 0.42 * (a[k] + b[k]) + 0.16 * wrist[k]);
    let root = [0.2, 0.8, -0.28];
    let skin = if detail == Detail::Full { 0.028 } else { 0.036 };
    body.join(0.04, true);
    let spread = [tips[0], tips[1], tips[2], root];
    for pair in spread.windows(2) {
        let fold = hem(pair[0], pair[1]);
        body.web([wrist, pair[0], fold], skin);
        body.web([wrist, fold, pair[1]], skin);
    }
    body.web([wrist, root, shoulder], skin);
}

fn tail_and_crest(body: &mut Body) {
    let tail = [
        [0.0, 0.36, -0.36, 0.26],
        [0.06, 0.2, -0.68, 0.19],
        [0.34, 0.14, -0.92, 0.145],
        [0.7, 0.115, -0.84, 0.115],
        [0.93, 0.1, -0.48, 0.092],
        [0.97, 0.12, -0.1, 0.07],
        [0.93, 0.25, 0.17, 0.05],
        [0.9, 0.42, 0.24, 0.04],
        [0.885, 0.58, 0.22, 0.04],
    ];
    body.join(0.1, false).limb(&tail);
    // The tail ends in a spade.
    body.join(0.05, false).web([[0.74, 0.5, 0.16], [0.9, 0.56, 0.23], [0.86, 0.76, 0.16]], 0.04);
    body.web([[1.04, 0.5, 0.29], [0.9, 0.56, 0.23], [0.86, 0.76, 0.16]], 0.04);
    // Crest: rounded spikes from the crown down the back and along the tail.
    let spikes = [
        ([0.0, 1.9, -0.02], [0.0, 2.03, -0.12], 0.07),
        ([0.0, 1.78, -0.2], [0.0, 1.9, -0.36], 0.075),
        ([0.0, 1.54, -0.2], [0.0, 1.6, -0.42], 0.08),
        ([0.0, 1.28, -0.14], [0.0, 1.3, -0.38], 0.08),
        ([0.0, 1.03, -0.2], [0.0, 1.06, -0.44], 0.085),
        ([0.0, 0.8, -0.4], [0.0, 0.88, -0.62], 0.085),
        ([0.0, 0.58, -0.54], [0.01, 0.69, -0.74], 0.08),
        ([0.05, 0.36, -0.72], [0.04, 0.52, -0.83], 0.07),
        ([0.24, 0.25, -0.9], [0.24, 0.42, -0.96], 0.062),
        ([0.48, 0.22, -0.93], [0.5, 0.38, -0.98], 0.055),
        ([0.71, 0.2, -0.84], [0.75, 0.345, -0.88], 0.048),
        ([0.87, 0.17, -0.65], [0.93, 0.3, -0.68], 0.042),
        ([0.95, 0.15, -0.42], [1.01, 0.26, -0.43], 0.036),
    ];
    body.join(0.045, false);
    for (base, tip, radius) in spikes {
        body.limb(&[[base[0], base[1], base[2], radius], [tip[0], tip[1], tip[2], 0.025]]);
    }
}
