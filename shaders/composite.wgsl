// The pastes at a sample composited: the face's list is walked from the top down, each paste weighted by what the ones above
// let through, until nothing more shows. The twin of `Composite` in src/paste/composite.rs.

// `across` and `down` are the steps of `bary` to the next sample.
fn composited(face: u32, bary: vec3f, across: vec3f, down: vec3f, g: Ground) -> Material {
    var sum: Material;
    var left = 1.0;
    // What the layers above let through, what the pastes of this one do, and its weight here.
    var above = 1.0;
    var inside = 1.0;
    var weight = 1.0;
    // What base colours are multiplied by in this layer.
    var gain = vec3f(1.0);
    let first = starts[face];
    for (var i = starts[face + 1u]; i > first; i--) {
        let entry = entries[i - 1u];
        if entry.paste == MARKER {
            above = left;
            inside = 1.0;
            let layer = of_layer(entry, bary);
            weight = layer.weight;
            gain = layer.gain;
            continue;
        }
        let layer = show(entry, bary, across, down, g);
        let share = above * weight * inside * layer.alpha;
        if share > 0.0 {
            sum.base_color += share * gain * layer.base_color;
            sum.normal += share * layer.normal;
            sum.height += share * layer.height;
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
    return sum;
}
