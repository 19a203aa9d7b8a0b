// Pass: which face is seen at each sample, before anything is drawn there. With `BEHIND` only what lies behind a former pass
// of the same counts, so that translucent meshes are drawn layer by layer, nearest first.

// Depth and face of the former pass; 0, 0 where nothing was seen.
@group(3) @binding(0) var before: texture_2d<u32>;
// The page's first face.
@group(3) @binding(1) var<uniform> page: vec4u;

override BEHIND: bool = false;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    return corner(index / 3u, index % 3u);
}

// Depth and face, both counted from 1.
@fragment
fn fragment(in: Corner) -> @location(0) vec2u {
    let key = vec2u(bitcast<u32>(in.position.z) + 1u, page.x + in.face + 1u);
    if BEHIND {
        let last = textureLoad(before, vec2u(in.position.xy), 0).xy;
        // Of equal depth, faces follow one another in their order.
        let after = key.x > last.x || (key.x == last.x && key.y > last.y);
        if last.x == 0u || !after {
            discard;
        }
    }
    return key;
}
