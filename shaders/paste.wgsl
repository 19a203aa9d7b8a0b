// What one paste shows at a sample (LT 4): alpha of its mask, and the exemplar's channels under the mask's pixel.
//
// All exemplars lie in array layers, whose sides are powers of two; the last pixels are repeated to a layer's end at every
// level, so clamping is exact. Masks lie in squares whose sides are powers of two, several to a layer, each with its own
// levels and their transparent borders.

struct Paste {
    piece: u32,
    // Where its cut begins in `pastes`; 0: it has none.
    cut: u32,
    offset: vec2f,
    // How far it is from agreeing with what lies below, 0 to 2 (src/paste/contrast.rs).
    apart: f32,
    // Cosine and sine of its content's turn about the mask's middle.
    turn: vec2f,
}

// A face under a paste: texture coordinates of its corners over the mask, as bits. Where layers are mixed by weights or have
// bases, one entry more stands on top of each layer: its paste is `MARKER`, its face 1 if there is a base, and the rest holds in 16 bits
// each the layer's weights at the corners and the base's colours there.
// Where a face has colours of its own, one entry more stands on top of all: its paste is `TINT`, and each corner has red, green,
// blue and alpha in 16 bits each.
struct Entry {
    paste: u32,
    face: u32,
    at0: vec2u,
    at1: vec2u,
    at2: vec2u,
}

struct Patch {
    // Pixels of the mask.
    size: vec2f,
    // The mask's place in its layer, pixels.
    place: vec2f,
    // The mask's top left corner, pixels of the exemplar.
    origin: vec2f,
    layer: u32,
    exemplar: u32,
    // The coarsest level with a transparent border.
    coarsest: f32,
    // Mask pixels to stored ones: less than 1 where fine levels did not fit.
    shrink: f32,
}

struct Exemplar {
    size: vec2f,
    // Exemplar pixels to stored ones.
    shrink: f32,
    // `REPEATS`, whether it has heights: `HEIGHTS`, what its frames change with: `BY_VIEW`, `BY_LIGHT`; and above `FRAMES` how many
    // frames follow it.
    flags: u32,
    // Layers of base colour, normal with height, roughness with metallic and occlusion, emission; -1: it has none.
    layers: vec4i,
}

// The pastes, and after them their cuts: for each of `CUT_STEPS` ways out of the mask's middle two bytes, the distance at which alpha
// is one half and the width over which it falls (src/paste/cut.rs).
@group(0) @binding(2) var<storage, read> pastes: array<vec4u>;
// Where each face's list begins in `entries`, and one more; bottom first.
@group(1) @binding(2) var<storage, read> starts: array<u32>;
@group(1) @binding(3) var<storage, read> entries: array<Entry>;
@group(2) @binding(0) var<storage, read> patches: array<Patch>;
@group(2) @binding(1) var<storage, read> exemplars: array<Exemplar>;
@group(2) @binding(2) var masks: texture_2d_array<f32>;
@group(2) @binding(3) var base_colors: texture_2d_array<f32>;
@group(2) @binding(4) var normal_maps: texture_2d_array<f32>;
@group(2) @binding(5) var gloss_maps: texture_2d_array<f32>;
@group(2) @binding(6) var emissions: texture_2d_array<f32>;
@group(2) @binding(7) var filtered: sampler;

const MARKER = 0xffffffffu;
const TINT = 0xfffffffeu;
const REPEATS = 1u;
const HEIGHTS = 2u;
const BY_VIEW = 4u;
const BY_LIGHT = 8u;
const FRAMES = 8u;

// Detail that leaves its base as it is (src/exemplar/detail.rs).
const DETAIL = 0.25;

// What a marker says of the layer below it: its weight, and what its base colours are multiplied by.
struct OfLayer {
    weight: f32,
    gain: vec3f,
}

fn of_layer(entry: Entry, bary: vec3f) -> OfLayer {
    let middle = unpack2x16unorm(entry.at0.y);
    let weights = vec3f(unpack2x16unorm(entry.at0.x), middle.x);
    let weight = clamp(dot(weights, bary), 0.0, 1.0);
    if entry.face == 0u {
        return OfLayer(weight, vec3f(1.0));
    }
    let split = unpack2x16unorm(entry.at2.x);
    let first = vec3f(middle.y, unpack2x16unorm(entry.at1.x));
    let second = vec3f(unpack2x16unorm(entry.at1.y), split.x);
    let third = vec3f(split.y, unpack2x16unorm(entry.at2.y));
    return OfLayer(weight, (first * bary.x + second * bary.y + third * bary.z) / DETAIL);
}

// Roughness, metallic and occlusion of an exemplar that does not say.
const DEFAULT_GLOSS = vec3f(0.8, 0.0, 1.0);

// True: filtered along the sample's own shape on the surface. False: over a square of the same area, as the reference
// renderer does.
override ANISOTROPIC: bool = false;

// Texture patch, mask and exemplar under a paste; weights are those of the paste's alpha.
struct Layer {
    alpha: f32,
    base_color: vec3f,
    opacity: f32,
    normal: vec3f,
    height: f32,
    roughness: f32,
    metallic: f32,
    occlusion: f32,
    emissive: vec3f,
}

// How a texture is read: the finest level's pixels a sample steps over, right and down.
struct Footprint {
    lod: f32,
    dx: vec2f,
    dy: vec2f,
}

fn fetch(image: texture_2d_array<f32>, layer: i32, pixel: vec2f, shrink: f32, over: Footprint) -> vec4f {
    let size = vec2f(textureDimensions(image));
    if ANISOTROPIC {
        return textureSampleGrad(image, filtered, pixel * shrink / size, layer, over.dx * shrink / size, over.dy * shrink / size);
    }
    return textureSampleLevel(image, filtered, pixel * shrink / size, layer, over.lod + log2(shrink));
}

// The two frames of an exemplar that are mixed at a sample, and the share of the second.
struct Shown {
    low: Exemplar,
    high: Exemplar,
    part: f32,
}

// The twin of `Ground::frames` in src/paste/composite.rs.
fn shown(index: u32, g: Ground) -> Shown {
    let first = exemplars[index];
    if (first.flags & (BY_VIEW | BY_LIGHT)) == 0u {
        return Shown(first, first, 0.0);
    }
    let towards_eye = dot(g.to_eye, g.normal);
    let lit = dot(g.to_light, g.normal) * select(-1.0, 1.0, towards_eye >= 0.0);
    let cosine = select(abs(towards_eye), lit, (first.flags & BY_LIGHT) != 0u);
    let steps = first.flags >> FRAMES;
    let place = acos(clamp(cosine, 0.0, 1.0)) / 1.5707964 * f32(steps);
    let low = min(u32(place), steps - 1u);
    return Shown(exemplars[index + low], exemplars[index + low + 1u], clamp(place - f32(low), 0.0, 1.0));
}

// A channel group of one frame, its deviation from the frame's mean lifted.
fn lifted(image: texture_2d_array<f32>, layer: i32, pixel: vec2f, exemplar: Exemplar, over: Footprint, lift: f32) -> vec4f {
    let value = fetch(image, layer, pixel, exemplar.shrink, over);
    if lift == 1.0 {
        return value;
    }
    // The coarsest level has one pixel.
    let coarsest = i32(ceil(log2(max(exemplar.size.x, exemplar.size.y) * exemplar.shrink) - 1e-3));
    let mean = textureLoad(image, vec2i(0), layer, max(coarsest, 0));
    return mean + lift * (value - mean);
}

// The same of the frames that show. All frames have the same groups.
fn mixed(image: texture_2d_array<f32>, group: u32, pixel: vec2f, frames: Shown, over: Footprint, lift: f32) -> vec4f {
    let value = lifted(image, frames.low.layers[group], pixel, frames.low, over, lift);
    if frames.part <= 0.0 {
        return value;
    }
    return mix(value, lifted(image, frames.high.layers[group], pixel, frames.high, over, lift), frames.part);
}

fn mask_alpha(piece: Patch, pixel: vec2f, over: Footprint) -> f32 {
    let size = vec2f(textureDimensions(masks));
    let uv = (piece.place + pixel * piece.shrink) / size;
    if ANISOTROPIC {
        // The hardware may go no coarser than the last level with a border.
        let longest = max(length(over.dx), length(over.dy)) * piece.shrink;
        let ease = piece.shrink * min(1.0, exp2(piece.coarsest) / max(longest, 1e-6));
        return textureSampleGrad(masks, filtered, uv, piece.layer, over.dx * ease / size, over.dy * ease / size).x;
    }
    let lod = clamp(over.lod + log2(piece.shrink), 0.0, piece.coarsest);
    return textureSampleLevel(masks, filtered, uv, piece.layer, lod).x;
}

// Steps of the search for the relief that a ray meets.
const RELIEF_STEPS = 16;

// The pixel whose relief the ray to `pixel` meets: the surface is at height 1, the deepest place `depth` pixels below.
fn relief(exemplar: Exemplar, pixel: vec2f, slope: vec2f, depth: f32, over: Footprint) -> vec2f {
    var before = 0.0;
    var gap_before = 1.0;
    for (var i = 0; i <= RELIEF_STEPS; i++) {
        let down = f32(i) / f32(RELIEF_STEPS);
        let place = wrapped(exemplar, pixel - slope * depth * down);
        let gap = (1.0 - down) - fetch(normal_maps, exemplar.layers.y, place, exemplar.shrink, over).w;
        if gap <= 0.0 {
            let part = select(0.0, gap_before / (gap_before - gap), i > 0);
            return pixel - slope * depth * mix(before, down, part);
        }
        before = down;
        gap_before = gap;
    }
    return pixel - slope * depth;
}

fn wrapped(exemplar: Exemplar, pixel: vec2f) -> vec2f {
    if (exemplar.flags & REPEATS) != 0u {
        return pixel - exemplar.size * floor(pixel / exemplar.size);
    }
    return pixel;
}

const CUT_STEPS = 128u;
const CUT_UNITS = vec2f(1.0 / 204.0, 1.0 / 512.0);

fn paste_at(index: u32) -> Paste {
    let words = pastes[2u * index];
    let turn = bitcast<vec2f>(pastes[2u * index + 1u].xy);
    return Paste(words.x & 0xffffu, words.y, bitcast<vec2f>(words.zw), f32(words.x >> 16u) * (2.0 / 255.0), turn);
}

// A step on a paste's mask as one on its exemplar.
fn on_exemplar(paste: Paste, step: vec2f) -> vec2f {
    return vec2f(step.x * paste.turn.x - step.y * paste.turn.y, step.x * paste.turn.y + step.y * paste.turn.x);
}

// Distance and width of a cut on one of its ways.
fn cut_step(cut: u32, way: u32) -> vec2f {
    let place = way % CUT_STEPS;
    let words = pastes[cut + place / 8u];
    let step = words[place / 2u % 4u] >> (16u * (place % 2u));
    return vec2f(vec2u(step & 255u, (step >> 8u & 255u) + 1u)) * CUT_UNITS;
}

// Alpha that a cut leaves at a place on its mask, 0 to 1.
fn cut_alpha(cut: u32, at: vec2f, blur: f32) -> f32 {
    let d = at * 2.0 - 1.0;
    let a = abs(d);
    let distance = max(a.x, a.y);
    var minor = d.x;
    var side = 3.0;
    if a.x >= a.y {
        minor = select(-d.y, d.y, d.x >= 0.0);
        side = select(2.0, 0.0, d.x >= 0.0);
    } else if d.y >= 0.0 {
        minor = -d.x;
        side = 1.0;
    }
    let way = (side + (1.0 + minor / max(distance, 1e-30)) * 0.5) * f32(CUT_STEPS / 4u);
    let step = mix(cut_step(cut, u32(way)), cut_step(cut, u32(way) + 1u), way - floor(way));
    return clamp((step.x - distance) / max(step.y, blur) + 0.5, 0.0, 1.0);
}

// Where a sample lies on a paste.
struct Place {
    paste: Paste,
    piece: Patch,
    pixel: vec2f,
    // Pixels from the first corner to the second and third, and twice the area they span.
    step1: vec2f,
    step2: vec2f,
    turn: f32,
    over: Footprint,
    alpha: f32,
    // By how much the deviation from the exemplar's mean is multiplied.
    lift: f32,
}

// Alphas below this show nothing.
const LEAST_ALPHA = 1e-6;

// Alpha and lift of a paste that keeps contrast; the twin of `faded` in src/paste/contrast.rs.
fn faded(alpha: f32, apart: f32) -> vec2f {
    if apart == 0.0 || alpha >= 1.0 {
        return vec2f(alpha, 1.0);
    }
    let spread = sqrt(1.0 - apart * alpha * (1.0 - alpha));
    let opaque = 1.0 - (1.0 - alpha) / spread;
    if opaque > LEAST_ALPHA {
        return vec2f(opaque, alpha / (spread * opaque));
    }
    return vec2f(0.0, 1.0);
}

// `across` and `down` are the steps of `bary` to the next sample.
fn place_on(entry: Entry, bary: vec3f, across: vec3f, down: vec3f, g: Ground) -> Place {
    var place: Place;
    place.alpha = 0.0;
    let uv0 = bitcast<vec2f>(entry.at0);
    let uv1 = bitcast<vec2f>(entry.at1);
    let uv2 = bitcast<vec2f>(entry.at2);
    let at = uv0 * bary.x + uv1 * bary.y + uv2 * bary.z;
    if any(at <= vec2f(0.0)) || any(at >= vec2f(1.0)) {
        return place;
    }
    place.paste = paste_at(entry.paste);
    place.piece = patches[place.paste.piece];
    let piece = place.piece;
    place.pixel = at * piece.size;
    place.step1 = (uv1 - uv0) * piece.size;
    place.step2 = (uv2 - uv0) * piece.size;
    place.turn = place.step1.x * place.step2.y - place.step1.y * place.step2.x;
    place.over.lod = 0.5 * log2(max(1.0, g.footprint * abs(place.turn) / max(g.area, 1e-37)));
    place.over.dx = across.y * place.step1 + across.z * place.step2;
    place.over.dy = down.y * place.step1 + down.z * place.step2;
    place.alpha = mask_alpha(piece, place.pixel, place.over);
    if place.paste.cut != 0u && place.alpha > 0.0 {
        place.alpha *= cut_alpha(place.paste.cut, at, 2.0 / min(piece.size.x, piece.size.y) * exp2(place.over.lod));
    }
    let fade = faded(place.alpha, place.paste.apart);
    place.alpha = fade.x;
    place.lift = fade.y;
    return place;
}

fn tint(corner: vec2u) -> vec4f {
    return vec4f(unpack2x16unorm(corner.x), unpack2x16unorm(corner.y));
}

// What a paste shows, or a face's own colour.
fn show(entry: Entry, bary: vec3f, across: vec3f, down: vec3f, g: Ground) -> Layer {
    var layer: Layer;
    if entry.paste == TINT {
        let own = tint(entry.at0) * bary.x + tint(entry.at1) * bary.y + tint(entry.at2) * bary.z;
        layer.alpha = clamp(own.w, 0.0, 1.0);
        layer.base_color = own.xyz;
        layer.opacity = 1.0;
        layer.normal = g.normal;
        layer.height = 0.5;
        layer.roughness = DEFAULT_GLOSS.x;
        layer.metallic = DEFAULT_GLOSS.y;
        layer.occlusion = DEFAULT_GLOSS.z;
        return layer;
    }
    let on = place_on(entry, bary, across, down, g);
    layer.alpha = on.alpha;
    if layer.alpha <= 0.0 {
        return layer;
    }
    let piece = on.piece;
    let over = Footprint(on.over.lod, on_exemplar(on.paste, on.over.dx), on_exemplar(on.paste, on.over.dy));
    let step1 = on_exemplar(on.paste, on.step1);
    let step2 = on_exemplar(on.paste, on.step2);

    let frames = shown(piece.exemplar, g);
    let exemplar = exemplars[piece.exemplar];
    // World steps of one pixel right and down.
    let side = sign(on.turn);
    let right = unit((g.edge1 * step2.y - g.edge2 * step1.y) * side);
    let below = unit((g.edge2 * step1.x - g.edge1 * step2.x) * side);
    let middle = 0.5 * piece.size;
    var place = on_exemplar(on.paste, on.pixel - middle) + middle + piece.origin + on.paste.offset;
    if frame.parallax > 0.0 && exemplar.layers.y >= 0 && has(HEIGHT) {
        let slope = vec2f(dot(g.to_eye, right), dot(g.to_eye, below)) / max(abs(dot(g.to_eye, g.normal)), 0.2);
        place = relief(exemplar, place, slope, frame.parallax * exemplar.size.x, over);
    }
    place = wrapped(exemplar, place);
    let base = mixed(base_colors, 0u, place, frames, over, on.lift);
    layer.base_color = base.xyz;
    layer.opacity = base.w;
    layer.normal = g.normal;
    layer.height = 0.5;
    if exemplar.layers.y >= 0 {
        let relief = mixed(normal_maps, 1u, place, frames, over, on.lift);
        layer.height = select(layer.height, relief.w, (exemplar.flags & HEIGHTS) != 0u);
        let n = relief.xyz * 2.0 - 1.0;
        layer.normal = right * n.x - below * n.y + g.normal * n.z;
        let size = length(layer.normal);
        layer.normal = select(g.normal, layer.normal / size, size > 0.0);
    }
    var gloss = DEFAULT_GLOSS;
    if exemplar.layers.z >= 0 {
        gloss = mixed(gloss_maps, 2u, place, frames, over, on.lift).xyz;
    }
    layer.roughness = gloss.x;
    layer.metallic = gloss.y;
    layer.occlusion = gloss.z;
    layer.emissive = vec3f(0.0);
    if exemplar.layers.w >= 0 {
        layer.emissive = mixed(emissions, 3u, place, frames, over, on.lift).xyz;
    }
    return layer;
}

fn unit(v: vec3f) -> vec3f {
    let size = length(v);
    return select(vec3f(0.0), v / size, size > 0.0);
}
