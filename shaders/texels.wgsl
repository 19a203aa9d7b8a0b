// Compute pass: what the pastes show at points of the surface, for baking; the twin of `Composite::texel`. One invocation has
// one point, and its answer takes the point's place.
//
// Asked: face, two barycentric coordinates (of the second and third corner), width of the sample. Answered, two numbers of 16
// bits a word: base colour, coverage; normal, height; roughness, metallic; occlusion, opacity; emission.

@group(3) @binding(0) var<storage, read_write> points: array<array<u32, 8>>;

const GROUP = 64;

@compute @workgroup_size(GROUP)
fn composite(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&points) {
        return;
    }
    let asked = points[id.x];
    let face = asked[0];
    let inner = bitcast<vec2f>(vec2u(asked[1], asked[2]));
    let bary = vec3f(1.0 - inner.x - inner.y, inner);
    let width = bitcast<f32>(asked[3]);
    let corners = 3u * face;
    var g = spanned(position(faces[corners]), position(faces[corners + 1u]), position(faces[corners + 2u]));
    g.footprint = width * width;
    let sum = composited(face, bary, vec3f(0.0), vec3f(0.0), g);
    let part = 1.0 / max(sum.total, 1e-6);
    let alpha = select(sum.total, 1.0, 1.0 - sum.total < NOTHING_LEFT);
    let slope = length(sum.normal);
    let normal = select(g.normal, sum.normal / slope, slope > 0.0);
    let color = sum.base_color * part;
    let light = sum.emissive * part;
    var out: array<u32, 8>;
    out[0] = pack2x16unorm(color.xy);
    out[1] = pack2x16unorm(vec2f(color.z, alpha));
    out[2] = pack2x16snorm(normal.xy);
    out[3] = pack2x16snorm(vec2f(normal.z, sum.height * part));
    out[4] = pack2x16unorm(vec2f(sum.roughness, sum.metallic) * part);
    out[5] = pack2x16unorm(vec2f(sum.occlusion, sum.opacity) * part);
    out[6] = pack2x16unorm(light.xy);
    out[7] = pack2x16unorm(vec2f(light.z, 0.0));
    points[id.x] = out;
}
