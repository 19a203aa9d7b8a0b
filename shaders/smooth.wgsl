// Pass: ambient occlusion averaged over one pattern of pixels, among those on the same surface.

@group(3) @binding(0) var points: texture_2d<u32>;
@group(3) @binding(1) var raw: texture_2d<f32>;

const HALF = 2;

@fragment
fn fragment(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let found = textureLoad(points, pixel, 0);
    if found.z == 0u {
        return vec4f(1.0);
    }
    let here = bitcast<vec3f>(found.xyz);
    let normal = octahedral(found.w);
    let size = vec2i(textureDimensions(points));
    var sum = 0.0;
    var count = 0.0;
    for (var y = -HALF; y < HALF; y++) {
        for (var x = -HALF; x < HALF; x++) {
            let at = pixel + vec2i(x, y);
            if any(at < vec2i(0)) || any(at >= size) {
                continue;
            }
            let other = textureLoad(points, at, 0);
            // Off the tangent plane by less than a small part of the radius: the same surface.
            if other.z != 0u && abs(dot(bitcast<vec3f>(other.xyz) - here, normal)) < 0.1 {
                sum += textureLoad(raw, at, 0).x;
                count += 1.0;
            }
        }
    }
    return vec4f(sum / max(count, 1.0));
}
