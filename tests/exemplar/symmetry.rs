//! How exemplars look when turned: the program's own, and those of `LAPPED_CORPUS`.

use lapped::assets;
use lapped::exemplar::Exemplar;
use lapped::exemplar::symmetry::{Symmetry, exemplar_symmetry};
use lapped::format::{ExemplarOptions, read_exemplar};

fn of(exemplar: &Exemplar) -> Symmetry {
    exemplar_symmetry(exemplar).expect("a colour image")
}

/// `None` means the same every way.
fn turns(found: &Symmetry) -> Option<u32> {
    (!found.isotropic).then_some(found.n)
}

/// Degrees between the lines found and where they should run.
fn off(found: &Symmetry, degrees: f64) -> f64 {
    let between = found.direction.expect("lines have a direction") - degrees;
    ((between + 90.0).rem_euclid(180.0) - 90.0).abs()
}

#[test]
fn own_exemplars_are_told_apart() {
    let expected: [(&str, &[Option<u32>]); 9] = [
        ("moss", &[None]),
        ("pebbles", &[None]),
        ("rust", &[None]),
        ("leaves", &[None]),
        ("stripes", &[Some(2)]),
        ("wood", &[Some(1), Some(2)]),
        ("fur", &[Some(1), Some(2)]),
        ("weave", &[Some(4)]),
        ("scales", &[Some(1)]),
    ];
    for (name, right) in expected {
        let found = of(&assets::exemplar(name).expect("a demo exemplar"));
        assert!(right.contains(&turns(&found)), "{name}: {found:?}");
    }
    for (name, degrees) in [("stripes", 90.0), ("wood", 90.0), ("bricks", 0.0)] {
        let found = of(&assets::exemplar(name).expect("a demo exemplar"));
        assert!(off(&found, degrees) < 3.0, "{name}: lines at {degrees} degrees: {found:?}");
    }
}

#[test]
fn corpus_exemplars_are_told_apart() {
    let Some(corpus) = crate::folder::corpus() else { return };
    let read = |name: &str| {
        let path = corpus.join("textures").join(name);
        of(&read_exemplar(&path, &ExemplarOptions::default()).expect("a corpus texture").0)
    };
    let expected = [
        ("stripes-128.png", Some(2)),
        ("stripes-alpha-48.png", Some(2)),
        ("tartan_color.jpg", Some(4)),
        ("burlap-96.png", Some(4)),
        ("octagon-tiles.jpg", Some(4)),
        ("gravel.png", None),
        ("pebbles.jpg", None),
        ("stones-128.png", None),
        ("grass.png", None),
        ("caustics.jpg", None),
        ("roughcast.jpg", None),
        ("boxtree.jpg", None),
        ("wood.png", Some(2)),
        ("wood-96.png", Some(2)),
        ("brushed-metal_color.png", Some(2)),
        ("thatch-128.png", Some(2)),
        ("brick.png", Some(2)),
        ("bricks-pbr_color.jpg", Some(2)),
        ("scales-128.png", Some(1)),
        ("rooftiles-128.png", Some(1)),
    ];
    for (name, right) in expected {
        let found = read(name);
        assert_eq!(turns(&found), right, "{name}: {found:?}");
    }
    let lines = [
        ("wood.png", 0.0),
        ("wood-96.png", 0.0),
        ("brushed-metal_color.png", 0.0),
        ("stripes-128.png", 90.0),
        ("bricks-pbr_color.jpg", 0.0),
        ("stained-bricks.png", 0.0),
    ];
    for (name, degrees) in lines {
        let found = read(name);
        assert!(off(&found, degrees) < 3.0, "{name}: lines at {degrees} degrees: {found:?}");
    }
    // Its blades lean a little.
    let thatch = read("thatch-128.png");
    assert!(off(&thatch, 92.0) < 3.0, "thatch: {thatch:?}");
}
