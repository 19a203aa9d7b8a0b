// Pass: each face drawn once, its pastes composited, then lit.

// True: the target keeps what it is given, so light is encoded as sRGB here.
override ENCODED: bool = false;

// Openness of each pixel; one pixel of 1 if nothing is darkened.
@group(3) @binding(0) var openness: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    return corner(index / 3u, index % 3u);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4f {
    let across = dpdx(in.bary);
    let down = dpdy(in.bary);
    let g = ground(in.face, in.bary, in.position.xy);
    let sum = composited(in.face, in.bary, across, down, g);
    let shown = lit(sum, g, in.normal, open_at(in.position.xy));
    if ENCODED {
        let curve = 1.055 * pow(max(shown.xyz, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
        return vec4f(select(curve, shown.xyz * 12.92, shown.xyz <= vec3f(0.0031308)), shown.w);
    }
    return shown;
}

fn open_at(at: vec2f) -> f32 {
    let pixel = vec2u(at + frame.origin) / frame.samples;
    return textureLoad(openness, min(pixel, textureDimensions(openness) - 1u), 0).x;
}
