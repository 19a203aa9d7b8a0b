// Pass: each face drawn once. The fragment walks the face's pastes from the top down, each weighted by what the ones above
// let through, until nothing more shows; then it is lit.

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
    var sum: Material;
    var left = 1.0;
    // What the layers above let through, what the pastes of this one do, and its weight here.
    var above = 1.0;
    var inside = 1.0;
    var weight = 1.0;
    let first = starts[in.face];
    for (var i = starts[in.face + 1u]; i > first; i--) {
        let entry = entries[i - 1u];
        if entry.paste == MARKER {
            above = left;
            inside = 1.0;
            weight = layer_weight(entry, in.bary);
            continue;
        }
        let layer = show(entry, in.bary, across, down, g);
        let share = above * weight * inside * layer.alpha;
        if share > 0.0 {
            sum.base_color += share * layer.base_color;
            sum.normal += share * layer.normal;
            sum.roughness += share * layer.roughness;
            sum.metallic += share * layer.metallic;
            sum.occlusion += share * layer.occlusion;
            sum.emissive += share * layer.emissive;
            sum.opacity += share * layer.opacity;
            inside *= 1.0 - layer.alpha;
            left = above * (1.0 - weight * (1.0 - inside));
            if left < NOTHING_LEFT {
                break;
            }
        }
    }
    sum.total = 1.0 - left;
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
