// Pass: samples averaged to pixels, as displayed light, over the background; encoded as sRGB with straight alpha.

@group(3) @binding(0) var samples: texture_2d<f32>;
// The share of the sky that the mesh hides from the ground.
@group(3) @binding(1) var hidden: texture_2d<f32>;

// How much of the background's light the shadow takes where no sky is left.
const SHADOW = 0.75;
const WALL_MIDDLE = vec3f(0.80, 0.80, 0.81);
const WALL_CORNER = vec3f(0.50, 0.505, 0.52);

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let n = frame.samples;
    let first = vec2u(position.xy) * n;
    var sum = vec4f(0.0);
    for (var y = 0u; y < n; y++) {
        for (var x = 0u; x < n; x++) {
            sum += textureLoad(samples, first + vec2u(x, y), 0);
        }
    }
    sum /= f32(n * n);
    let through = 1.0 - sum.w;
    var behind = vec4f(0.0);
    if through > 0.0 && frame.backdrop == 1u {
        behind = vec4f(frame.backdrop_colour, 1.0);
    }
    let pixel = position.xy + frame.origin / f32(n);
    if through > 0.0 && frame.backdrop == 2u {
        let sight = ray(position.xy * f32(n));
        behind = vec4f(wall(pixel) * (1.0 - SHADOW * shadow(sight)), 1.0);
    }
    let total = 1.0 - through * (1.0 - behind.w);
    if total <= 0.0 {
        return vec4f(0.0);
    }
    let mixed = encoded((sum.xyz + behind.xyz * (through * behind.w)) / total);
    // A step of eight bits is seen on the wall; half a step up or down, in a pattern, is not.
    let bytes = floor(clamp(mixed, vec3f(0.0), vec3f(1.0)) * 255.0 + 0.5 + through * behind.w * dither(vec2u(pixel)));
    return vec4f(clamp(bytes, vec3f(0.0), vec3f(255.0)) / 255.0, total);
}

// -1/2 to 1/2: the 8x8 pattern of ordered dithering.
fn dither(at: vec2u) -> f32 {
    var v = 0u;
    for (var i = 0u; i < 3u; i++) {
        v |= ((((at.x ^ at.y) >> i) & 1u) << (5u - 2u * i)) | (((at.y >> i) & 1u) << (4u - 2u * i));
    }
    return (f32(v) + 0.5) / 64.0 - 0.5;
}

fn encoded(linear: vec3f) -> vec3f {
    let light = max(linear, vec3f(0.0));
    return select(1.055 * pow(light, vec3f(1.0 / 2.4)) - 0.055, light * 12.92, light <= vec3f(0.0031308));
}

fn wall(pixel: vec2f) -> vec3f {
    let place = pixel / frame.size - vec2f(0.5, 0.42);
    return mix(WALL_MIDDLE, WALL_CORNER, min(dot(place, place) / 0.55, 1.0));
}

fn shadow(sight: Ray) -> f32 {
    let height = dot(sight.start - frame.shadow_middle, frame.world_up);
    let fall = -dot(sight.direction, frame.world_up);
    if frame.shadow_half <= 0.0 || height <= 0.0 || fall <= 0.0 {
        return 0.0;
    }
    let at = sight.start - frame.shadow_middle + sight.direction * (height / fall);
    let place = vec2f(dot(at, frame.shadow_across), dot(at, frame.shadow_down)) / frame.shadow_half;
    let t = clamp((length(place) - 0.6) / 0.4, 0.0, 1.0);
    let fade = 1.0 - t * t * (3.0 - 2.0 * t);
    if fade <= 0.0 {
        return 0.0;
    }
    let cells = vec2f(textureDimensions(hidden));
    let cell = (place * vec2f(0.5, -0.5) + 0.5) * cells - 0.5;
    let base = floor(cell);
    let w = cell - base;
    let top = mix(cell_at(base, 0.0, 0.0), cell_at(base, 1.0, 0.0), w.x);
    let bottom = mix(cell_at(base, 0.0, 1.0), cell_at(base, 1.0, 1.0), w.x);
    return fade * mix(top, bottom, w.y);
}

fn cell_at(base: vec2f, x: f32, y: f32) -> f32 {
    let last = vec2f(textureDimensions(hidden)) - 1.0;
    return textureLoad(hidden, vec2u(clamp(base + vec2f(x, y), vec2f(0.0), last)), 0).x;
}
