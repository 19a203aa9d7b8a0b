// What all passes share: the camera and the light of one frame, the mesh, and where a sample's ray meets a face.
//
// Lengths are in units of the mesh's own size, positions relative to its middle (see src/render/gpu/shape.rs). A page is
// a run of faces with their paste lists, small enough for one binding; faces are counted from the page's first.

struct Lamp {
    towards: vec3f,
    light: vec3f,
}

struct Frame {
    right: vec3f,
    // Samples per unit on the picture plane.
    scale: f32,
    up: vec3f,
    // 1: lines meet at the eye; 0: they are parallel.
    perspective: f32,
    forward: vec3f,
    // Depth of relief that parallax shows, in exemplar widths; 0: none.
    parallax: f32,
    eye: vec3f,
    // Bits as in `exemplar::Channel`, and whether layers are mixed by weights.
    channels: u32,
    world_up: vec3f,
    // Samples along each side of a pixel.
    samples: u32,
    bare: vec3f,
    // 0: nothing, 1: one colour, 2: the studio.
    backdrop: u32,
    // Factors and shifts from view coordinates to clip coordinates of this tile.
    clip: vec4f,
    // Factor and shift of depth; then the tile's first sample.
    depth: vec2f,
    origin: vec2f,
    // The picture's middle in samples, and the picture's size in pixels.
    middle: vec2f,
    size: vec2f,
    lamps: array<Lamp, 3>,
    sky: vec3f,
    // Radius of ambient occlusion; 0: none.
    radius: f32,
    ground: vec3f,
    // Half the side of the shadow map; 0: no shadow.
    shadow_half: f32,
    backdrop_colour: vec3f,
    shadow_middle: vec3f,
    shadow_across: vec3f,
    shadow_down: vec3f,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// Three numbers a vertex.
@group(0) @binding(1) var<storage, read> positions: array<f32>;

// Three vertices a face.
@group(1) @binding(0) var<storage, read> faces: array<u32>;
// Three smooth normals a face, octahedral.
@group(1) @binding(1) var<storage, read> normals: array<u32>;

struct Corner {
    @invariant @builtin(position) position: vec4f,
    @location(0) bary: vec3f,
    @location(1) normal: vec3f,
    @location(2) @interpolate(flat) face: u32,
}

fn position(vertex: u32) -> vec3f {
    return vec3f(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

fn octahedral(packed: u32) -> vec3f {
    let p = unpack2x16snorm(packed);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let fold = max(-z, 0.0);
    let side = select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
    return normalize(vec3f(p - side * fold, z));
}

// Corner `k` of a face of this page.
fn corner(face: u32, k: u32) -> Corner {
    let at = position(faces[3u * face + k]) - frame.eye;
    let view = vec3f(dot(at, frame.right), dot(at, frame.up), dot(at, frame.forward));
    let w = select(1.0, view.z, frame.perspective > 0.5);
    var out: Corner;
    out.position = vec4f(view.xy * frame.clip.xy + w * frame.clip.zw, frame.depth.x * view.z + frame.depth.y, w);
    out.bary = vec3f(f32(k == 0u), f32(k == 1u), f32(k == 2u));
    out.normal = octahedral(normals[3u * face + k]);
    out.face = face;
    return out;
}

// A ray; its direction's part along `forward` is 1.
struct Ray {
    start: vec3f,
    direction: vec3f,
}

// The ray through a place of this tile, in samples.
fn ray(at: vec2f) -> Ray {
    let offset = (at + frame.origin - frame.middle) / frame.scale;
    let aside = frame.right * offset.x - frame.up * offset.y;
    if frame.perspective > 0.5 {
        return Ray(frame.eye, frame.forward + aside);
    }
    return Ray(frame.eye + aside, frame.forward);
}

// A face under a sample.
struct Ground {
    // From the first corner to the second and third.
    edge1: vec3f,
    edge2: vec3f,
    // Twice the area.
    area: f32,
    normal: vec3f,
    // Area of the sample on the face.
    footprint: f32,
    to_eye: vec3f,
    to_light: vec3f,
    front: bool,
    // Distance from the eye along `forward`.
    depth: f32,
}

// The smallest cosine between ray and normal that widens the footprint.
const MIN_SLANT = 0.05;

// A face that nothing is known of but how it lies: as if seen and lit straight from above.
fn spanned(a: vec3f, b: vec3f, c: vec3f) -> Ground {
    var g: Ground;
    g.edge1 = b - a;
    g.edge2 = c - a;
    let across = cross(g.edge1, g.edge2);
    g.area = length(across);
    g.normal = across / max(g.area, 1e-37);
    g.to_eye = g.normal;
    g.to_light = g.normal;
    return g;
}

fn ground(face: u32, bary: vec3f, at: vec2f) -> Ground {
    let a = position(faces[3u * face]);
    let b = position(faces[3u * face + 1u]);
    let c = position(faces[3u * face + 2u]);
    var g = spanned(a, b, c);
    let met = a * bary.x + b * bary.y + c * bary.z;
    let direction = ray(at).direction;
    let slant = dot(g.normal, direction);
    g.depth = dot(met - frame.eye, frame.forward);
    let width = select(1.0, g.depth, frame.perspective > 0.5) / frame.scale;
    g.footprint = width * width / max(abs(slant), MIN_SLANT);
    g.to_eye = -normalize(direction);
    g.to_light = frame.lamps[0].towards;
    g.front = slant < 0.0;
    return g;
}

fn has(channel: u32) -> bool {
    return (frame.channels & (1u << channel)) != 0u;
}

const NORMAL = 1u;
const HEIGHT = 2u;
const ROUGHNESS = 3u;
const METALLIC = 4u;
const OCCLUSION = 5u;
const EMISSIVE = 6u;
const OPACITY = 7u;
const LAYERS = 31u;
