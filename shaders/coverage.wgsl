// Compute pass: which samples of the surface become opaque under texture patches (LT 3.6); the twin of `Tile::cover` in
// src/paste/coverage.rs. One invocation has one run: up to eight samples next to each other in a row of a face's lattice.
//
// Lengths are in units of the face's longest edge, which runs from (0, 0) to (1, 0).

struct Face {
    apex: vec2f,
    rows: u32,
    // The patches over it: the first, and how many.
    first: u32,
    overlays: u32,
    unused: u32,
}

// Mask pixels are `origin + along x + up y`.
struct Overlay {
    origin: vec2f,
    along: vec2f,
    up: vec2f,
    mask: u32,
    // A sample counts the least alpha this near, and which of the eroded alphas that is.
    radius: f32,
    level: u32,
    unused: u32,
}

struct Mask {
    first: u32,
    width: u32,
    height: u32,
    unused: u32,
}

struct Run {
    face: u32,
    row: u32,
    // Its first cell.
    first: u32,
    // Its cells, and sixteen times those of the whole row.
    cells: u32,
}

@group(0) @binding(0) var<storage, read> runs: array<Run>;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> overlays: array<Overlay>;
@group(0) @binding(3) var<storage, read> masks: array<Mask>;
// Depth (16 bits with sign, sixteenths of a pixel), alpha, and five eroded alphas a pixel.
@group(0) @binding(4) var<storage, read> pixels: array<vec2u>;
// Transparency of a run's samples, of 255, a byte each.
@group(0) @binding(5) var<storage, read_write> samples: array<vec2u>;

const DEPTH_STEPS = 16.0;
const OPAQUE_BYTE = 254u;
// Transparency at or below this counts as opaque.
const OPAQUE = 1u;
// Runs of no more cells than this are not tried together.
const SHORT_RUN = 2u;
const LEVELS = 5u;
const GROUP = 64u;
// Groups along the first side of a dispatch.
const ACROSS = 32768u;

fn cell(mask: Mask, at: vec2f) -> vec2u {
    let x = min(u32(max(at.x, 0.0)), mask.width - 1u);
    let y = min(u32(max(at.y, 0.0)), mask.height - 1u);
    return pixels[mask.first + y * mask.width + x];
}

fn inside(pixel: vec2u) -> f32 {
    return f32(bitcast<i32>(pixel.x << 16u) >> 16u) / DEPTH_STEPS;
}

fn depth(mask: Mask, at: vec2f) -> f32 {
    let own = inside(cell(mask, at));
    let outside = at - clamp(at, vec2f(0.0), vec2f(f32(mask.width), f32(mask.height)));
    return select(-length(vec3f(own, outside)), own, all(outside == vec2f(0.0)));
}

fn eroded_alpha(mask: Mask, at: vec2f, radius: f32, level: u32) -> u32 {
    let pixel = cell(mask, at);
    var eroded = 0u;
    if level == 0u {
        eroded = pixel.x >> 24u;
    } else if level < LEVELS {
        eroded = (pixel.y >> (8u * (level - 1u))) & 255u;
    }
    return select(eroded, OPAQUE_BYTE, eroded < OPAQUE_BYTE && inside(pixel) >= radius);
}

fn nearest_on_segment(a: vec2f, b: vec2f, p: vec2f) -> vec2f {
    let way = b - a;
    return a + way * clamp(dot(p - a, way) / dot(way, way), 0.0, 1.0);
}

// The point of the triangle nearest to the middle of a cell.
fn sample_point(face: Face, middle: vec2f) -> vec2f {
    let up = middle.y / face.apex.y;
    if middle.x < face.apex.x * up {
        return nearest_on_segment(vec2f(0.0), face.apex, middle);
    }
    if middle.x > 1.0 + (face.apex.x - 1.0) * up {
        return nearest_on_segment(vec2f(1.0, 0.0), face.apex, middle);
    }
    return middle;
}

@compute @workgroup_size(GROUP)
fn cover(@builtin(global_invocation_id) id: vec3u) {
    let index = id.x + id.y * ACROSS * GROUP;
    if index >= arrayLength(&runs) {
        return;
    }
    let run = runs[index];
    let face = faces[run.face];
    let count = run.cells & 15u;
    let all_cells = run.cells >> 4u;
    let up = f32(run.row) / f32(face.rows);
    let left = face.apex.x * up;
    let width = (1.0 - up) / f32(all_cells);
    let half_height = 0.5 * face.apex.y / f32(face.rows);
    let y = (2.0 * f32(run.row) + 1.0) * half_height;
    let packed = samples[index];
    var clear: array<u32, 8>;
    for (var k = 0u; k < 8u; k++) {
        clear[k] = (select(packed.x, packed.y, k >= 4u) >> (8u * (k & 3u))) & 255u;
    }
    for (var o = face.first; o < face.first + face.overlays; o++) {
        let overlay = overlays[o];
        let mask = masks[overlay.mask];
        if count > SHORT_RUN {
            let middle = vec2f(left + (f32(run.first) + 0.5 * f32(count)) * width, y);
            let a = overlay.along * (0.5 * f32(count) * width);
            let b = overlay.up * half_height;
            let reach = max(length(a + b), length(a - b));
            let deep = depth(mask, overlay.origin + overlay.along * middle.x + overlay.up * middle.y);
            if deep <= -reach {
                continue;
            }
            if deep >= reach {
                for (var k = 0u; k < count; k++) {
                    clear[k] = 0u;
                }
                break;
            }
        }
        for (var k = 0u; k < count; k++) {
            if clear[k] == 0u {
                continue;
            }
            let p = sample_point(face, vec2f(left + (f32(run.first + k) + 0.5) * width, y));
            let at = overlay.origin + overlay.along * p.x + overlay.up * p.y;
            // Rounded up: a sample never counts as more opaque than it is.
            let rest = (clear[k] * (255u - eroded_alpha(mask, at, overlay.radius, overlay.level)) + 254u) / 255u;
            clear[k] = select(rest, 0u, rest <= OPAQUE);
        }
    }
    var out = vec2u(0u);
    for (var k = 0u; k < 4u; k++) {
        out.x |= clear[k] << (8u * k);
        out.y |= clear[k + 4u] << (8u * k);
    }
    samples[index] = out;
}
