// Pass: the material that the layered pass has blended is lit.

@group(3) @binding(0) var openness: texture_2d<f32>;
@group(3) @binding(1) var base_color: texture_2d<f32>;
@group(3) @binding(2) var normal: texture_2d<f32>;
@group(3) @binding(3) var gloss: texture_2d<f32>;
@group(3) @binding(4) var emissive: texture_2d<f32>;
@group(3) @binding(5) var opacity: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    return corner(index / 3u, index % 3u);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4f {
    let at = vec2u(in.position.xy);
    let base = textureLoad(base_color, at, 0);
    var sum: Material;
    sum.total = base.w;
    sum.base_color = base.xyz;
    if has(NORMAL) {
        sum.normal = textureLoad(normal, at, 0).xyz;
    }
    let described = textureLoad(gloss, min(at, textureDimensions(gloss) - 1u), 0).xyz;
    sum.roughness = described.x;
    sum.metallic = described.y;
    sum.occlusion = described.z;
    sum.emissive = textureLoad(emissive, min(at, textureDimensions(emissive) - 1u), 0).xyz;
    sum.opacity = textureLoad(opacity, min(at, textureDimensions(opacity) - 1u), 0).x;
    let pixel = vec2u(in.position.xy + frame.origin) / frame.samples;
    let open = textureLoad(openness, min(pixel, textureDimensions(openness) - 1u), 0).x;
    return lit(sum, ground(in.face, in.bary, in.position.xy), in.normal, open);
}
