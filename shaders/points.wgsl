// Pass: the surface point under each pixel, for ambient occlusion: view coordinates in units of the occlusion's radius, and
// the smooth normal.

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    return corner(index / 3u, index % 3u);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4u {
    let g = ground(in.face, in.bary, in.position.xy);
    let offset = ray(in.position.xy);
    let at = (offset.start - frame.eye + offset.direction * g.depth) / frame.radius;
    let view = vec3f(dot(at, frame.right), dot(at, frame.up), dot(at, frame.forward));
    var n = in.normal;
    if !g.front {
        n = -n;
    }
    n = normalize(vec3f(dot(n, frame.right), dot(n, frame.up), dot(n, frame.forward)));
    let share = abs(n.x) + abs(n.y) + abs(n.z);
    var p = n.xy / share;
    if n.z < 0.0 {
        p = (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
    }
    return vec4u(bitcast<vec3u>(view), pack2x16snorm(p));
}
