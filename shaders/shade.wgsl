// How light meets the surface: the twin of src/render/shade.rs and of the reference renderer's way from texel to light.

const SHOULDER = 0.72;
const WRAP = 0.22;
const LAMP_SIZE = 0.08;
const DIELECTRIC = 0.04;
const PLAIN = 0.012;
const LAMP_IN_CREVICE = 0.55;
const PLAIN_ROUGHNESS = 0.7;
const PI = 3.14159265358979;
// What is left to see through below this cannot change an 8-bit picture.
const NOTHING_LEFT = 1.0 / 512.0;

// All pastes at a sample, each weighted by what shows of it.
struct Material {
    // Share of the sample that is covered.
    total: f32,
    base_color: vec3f,
    normal: vec3f,
    height: f32,
    roughness: f32,
    metallic: f32,
    occlusion: f32,
    emissive: vec3f,
    opacity: f32,
}

fn lamp_share(occlusion: f32) -> f32 {
    return LAMP_IN_CREVICE + (1.0 - LAMP_IN_CREVICE) * occlusion;
}

fn ambient(rise: f32, roughness: f32) -> vec3f {
    let width = 0.25 + 0.75 * roughness;
    return mix(frame.ground, frame.sky, 0.5 + 0.5 * clamp(rise / width, -1.0, 1.0));
}

fn diffuse(normal: vec3f, occlusion: f32) -> vec3f {
    var light = vec3f(0.0);
    for (var i = 0; i < 3; i++) {
        light += frame.lamps[i].light * max((dot(normal, frame.lamps[i].towards) + WRAP) / (1.0 + WRAP), 0.0);
    }
    return light * lamp_share(occlusion) + ambient(dot(normal, frame.world_up), 1.0) * occlusion;
}

fn fifth(x: f32) -> f32 {
    return x * x * x * x * x;
}

fn highlight(alpha: f32, half: f32, lit: f32, facing: f32) -> f32 {
    let a2 = alpha * alpha;
    let d = half * half * (a2 - 1.0) + 1.0;
    let distribution = a2 / (PI * d * d);
    let masking = lit * sqrt(facing * facing * (1.0 - a2) + a2) + facing * sqrt(lit * lit * (1.0 - a2) + a2);
    return distribution * 0.5 / max(masking, 1e-6);
}

fn shade(base_color: vec3f, roughness: f32, metallic: f32, reflectance: f32, occlusion: f32, normal: vec3f, smoothed: vec3f, to_eye: vec3f) -> vec3f {
    let facing = clamp(dot(normal, to_eye), 1e-3, 1.0);
    let grazing = fifth(1.0 - facing);
    let bare = vec3f(reflectance);
    let at_normal = mix(bare, base_color, metallic);
    let limit = vec3f(1.0 - roughness);
    let glaze = bare + (max(limit, bare) - bare) * grazing;
    let gilt = base_color + (max(limit, base_color) - base_color) * grazing;
    let mirrored = mix(glaze, gilt, metallic);
    var light = base_color * (1.0 - metallic) * (1.0 - glaze) * diffuse(normal, occlusion);
    let reflected = 2.0 * dot(normal, to_eye) * normal - to_eye;
    let above = clamp(1.0 + dot(reflected, smoothed), 0.0, 1.0);
    light += mirrored * ambient(dot(reflected, frame.world_up), roughness) * (occlusion * above * above);
    let alpha = min(roughness * roughness + LAMP_SIZE, 1.0);
    for (var i = 0; i < 3; i++) {
        let towards = frame.lamps[i].towards;
        let lit = dot(normal, towards);
        if lit > 0.0 && dot(smoothed, towards) > 0.0 {
            let between = towards + to_eye;
            let half = between / max(length(between), 1e-20);
            let fresnel = at_normal + (1.0 - at_normal) * fifth(1.0 - clamp(dot(half, to_eye), 0.0, 1.0));
            let strength = PI * highlight(alpha, dot(normal, half), lit, facing) * lit;
            light += fresnel * frame.lamps[i].light * strength * lamp_share(occlusion);
        }
    }
    return light;
}

fn tone(given: vec3f) -> vec3f {
    let light = max(given, vec3f(0.0));
    let most = max(light.x, max(light.y, light.z));
    if most <= SHOULDER {
        return light;
    }
    let room = 1.0 - SHOULDER;
    return light * ((SHOULDER + room * (1.0 - exp(-(most - SHOULDER) / room))) / most);
}

// `v` turned by the rotation that takes unit vector `one` to unit vector `other` the short way.
fn turned(v: vec3f, one: vec3f, other: vec3f) -> vec3f {
    let axis = cross(one, other);
    let cosine = dot(one, other);
    if cosine < -0.9999 {
        return -v;
    }
    return v * cosine + cross(axis, v) + axis * (dot(axis, v) / (1.0 + cosine));
}

// Displayed light times opacity, and opacity. `corner_normal` is the smooth normal, `open` the openness to the sky.
fn lit(sum: Material, g: Ground, corner_normal: vec3f, open: f32) -> vec4f {
    let cover = select(sum.total, 1.0, 1.0 - sum.total < NOTHING_LEFT);
    let part = 1.0 / max(sum.total, 1e-6);
    var smoothed = corner_normal;
    let size = length(smoothed);
    smoothed = select(g.normal, smoothed / size, size > 0.0);
    var normal = smoothed;
    let slope = length(sum.normal);
    if has(NORMAL) && cover > 0.0 && slope > 0.0 {
        normal = normalize(mix(smoothed, turned(sum.normal / slope, g.normal, smoothed), cover));
    }
    if !g.front {
        smoothed = -smoothed;
        normal = -normal;
    }
    let roughness = select(PLAIN_ROUGHNESS, sum.roughness * part, has(ROUGHNESS));
    let metallic = select(0.0, sum.metallic * part, has(METALLIC));
    let occlusion = select(1.0, sum.occlusion * part, has(OCCLUSION));
    let reflectance = select(PLAIN, DIELECTRIC, has(ROUGHNESS) || has(METALLIC));
    let light = shade(
        mix(frame.bare, clamp(sum.base_color * part, vec3f(0.0), vec3f(1.0)), cover),
        clamp(mix(PLAIN_ROUGHNESS, roughness, cover), 0.0, 1.0),
        clamp(metallic * cover, 0.0, 1.0),
        reflectance,
        open * clamp(mix(1.0, occlusion, cover), 0.0, 1.0),
        normal,
        smoothed,
        g.to_eye,
    );
    let emitted = select(vec3f(0.0), clamp(sum.emissive * part, vec3f(0.0), vec3f(1.0)) * cover, has(EMISSIVE));
    let opacity = select(1.0, 1.0 - cover * (1.0 - clamp(sum.opacity * part, 0.0, 1.0)), has(OPACITY));
    return vec4f(tone(light + emitted) * opacity, opacity);
}
