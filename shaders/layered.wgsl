// Pass: the pastes in paint order, each blended over what is below it, where its face is the one seen (LT 4). What is blended
// is the material, not light, so that the sum is lit once, as it is in the single pass.

// Entries in paint order.
@group(1) @binding(4) var<storage, read> order: array<u32>;

struct PasteCorner {
    @invariant @builtin(position) position: vec4f,
    @location(0) bary: vec3f,
    @location(1) @interpolate(flat) entry: u32,
}

// Every part is multiplied by the paste's alpha, which stands last.
struct Blended {
    @location(0) base_color: vec4f,
    @location(1) normal: vec4f,
    @location(2) gloss: vec4f,
    @location(3) emissive: vec4f,
    @location(4) opacity: vec4f,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> PasteCorner {
    let entry = order[index / 3u];
    let of_face = corner(entries[entry].face, index % 3u);
    return PasteCorner(of_face.position, of_face.bary, entry);
}

@fragment
fn fragment(in: PasteCorner) -> Blended {
    let across = dpdx(in.bary);
    let down = dpdy(in.bary);
    let entry = entries[in.entry];
    let g = ground(entry.face, in.bary, in.position.xy);
    let layer = show(entry, in.bary, across, down, g);
    var a = layer.alpha;
    var gain = vec3f(1.0);
    if has(LAYERS) && a > 0.0 && entry.paste != TINT {
        let share = share_of_below(in.entry, a, in.bary, across, down, g);
        a = share.weight;
        gain = share.gain;
    }
    if a <= 0.0 {
        discard;
    }
    var out: Blended;
    out.base_color = vec4f(gain * layer.base_color * a, a);
    out.normal = vec4f(layer.normal * a, a);
    out.gloss = vec4f(vec3f(layer.roughness, layer.metallic, layer.occlusion) * a, a);
    out.emissive = vec4f(layer.emissive * a, a);
    out.opacity = vec4f(layer.opacity * a, 0.0, 0.0, a);
    return out;
}

// The share that a paste of a weighted layer has in what lies below the pastes above it: blended over in paint order, shares
// add up to the layer mixed by its weight as a whole. With it what the layer's base colours are multiplied by.
fn share_of_below(index: u32, alpha: f32, bary: vec3f, across: vec3f, down: vec3f, g: Ground) -> OfLayer {
    var inside = 1.0;
    var layer = OfLayer(1.0, vec3f(1.0));
    // The layer's marker stands on top of it.
    for (var i = index + 1u; i < arrayLength(&entries); i++) {
        let entry = entries[i];
        if entry.paste == MARKER {
            layer = of_layer(entry, bary);
            break;
        }
        inside *= 1.0 - place_on(entry, bary, across, down, g).alpha;
    }
    let weight = layer.weight;
    return OfLayer(weight * inside * alpha / max(1.0 - weight * (1.0 - inside), 1e-6), layer.gain);
}
