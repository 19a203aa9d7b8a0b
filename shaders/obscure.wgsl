// Pass: how much of its surroundings each pixel's surface hides from itself; the twin of src/render/occlusion.rs.

@group(3) @binding(0) var points: texture_2d<u32>;

const DIRECTIONS = 6;
const STEPS = 5;
const PATTERN = 4u;
const LONGEST = 0.15;
const LEVEL = 0.12;
const STRENGTH = 1.5;
const TAU = 6.28318530717959;
const TURN = array<f32, 16>(0.0, 8.0, 2.0, 10.0, 12.0, 4.0, 14.0, 6.0, 3.0, 11.0, 1.0, 9.0, 15.0, 7.0, 13.0, 5.0);

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let found = textureLoad(points, pixel, 0);
    if found.z == 0u {
        return vec4f(1.0);
    }
    let here = bitcast<vec3f>(found.xyz);
    let normal = octahedral(found.w);
    let size = vec2f(textureDimensions(points));
    // The radius in pixels.
    var reach = frame.scale * frame.radius;
    if frame.perspective > 0.5 {
        reach = frame.scale / here.z;
    }
    reach = min(reach, LONGEST * size.y);
    var turns = TURN;
    let turn = turns[(pixel.y % PATTERN) * PATTERN + pixel.x % PATTERN] / f32(PATTERN * PATTERN);
    var hidden = 0.0;
    for (var d = 0; d < DIRECTIONS; d++) {
        let angle = TAU * (f32(d) + turn) / f32(DIRECTIONS);
        let direction = vec2f(cos(angle), sin(angle));
        for (var s = 0; s < STEPS; s++) {
            let share = (f32(s) + 0.5 + 0.5 * turn) / f32(STEPS);
            let at = vec2f(pixel) + direction * (1.0 + reach * share * share);
            if any(at < vec2f(0.0)) || any(at >= size - 0.5) {
                continue;
            }
            let other = textureLoad(points, vec2u(at + 0.5), 0);
            if other.z == 0u {
                continue;
            }
            let v = bitcast<vec3f>(other.xyz) - here;
            let far = length(v);
            if far > 0.0 && far < 1.0 {
                hidden += max(dot(v, normal) / far - LEVEL, 0.0) * (1.0 - far * far);
            }
        }
    }
    return vec4f(max(1.0 - STRENGTH * hidden / f32(DIRECTIONS * STEPS), 0.0));
}
