//! Every mesh of the corpus reads with the counts that another program found in it. The folder comes from
//! `LAPPED_CORPUS`; without it there is nothing to test.

use lapped::format::read_model;
use lapped::mesh::{CleanOptions, clean};
use std::path::PathBuf;

/// File, vertices, polygons and triangles as counted by the corpus's own index, which gives of suzanne.obj only the number of
/// quads (468); 32 triangles come on top.
const COUNTS: [(&str, usize, usize, usize); 24] = [
    ("stanford-bunny.obj", 35947, 69451, 69451),
    ("bunny-npm.obj", 1839, 3674, 3674),
    ("horse.ply", 48485, 96966, 96966),
    ("cat.obj", 7949, 15894, 15894),
    ("dino.obj", 3916, 7828, 7828),
    ("teapot.obj", 3644, 6320, 6320),
    ("torus.obj", 2304, 4608, 4608),
    ("sphere.obj", 642, 1280, 1280),
    ("knot.obj", 3200, 6400, 6400),
    ("fandisk.obj", 6475, 12946, 12946),
    ("rocker-arm.obj", 10044, 20088, 20088),
    ("mechpart.obj", 7612, 15232, 15232),
    ("armadillo.obj", 43243, 86482, 86482),
    ("dragon.ply", 437_645, 871_414, 871_414),
    ("dragon-res4.ply", 5205, 11102, 11102),
    ("spot.obj", 2930, 5856, 5856),
    ("cow.obj", 2903, 5804, 5804),
    ("mannequin.obj", 12977, 25888, 25888),
    ("nefertiti.obj", 35002, 70000, 70000),
    ("ogre.obj", 62194, 124_008, 124_008),
    ("blade.obj", 8231, 16222, 16222),
    ("range-scan.ply", 44461, 86766, 86766),
    ("suzanne.obj", 507, 500, 968),
    ("duck.glb", 2399, 4212, 4212),
];

#[test]
fn every_mesh_has_the_counts_of_the_index() {
    let Some(corpus) = std::env::var_os("LAPPED_CORPUS").map(PathBuf::from) else { return };
    for (name, vertices, polygons, faces) in COUNTS {
        let start = std::time::Instant::now();
        let model = read_model(&corpus.join("meshes").join(name)).unwrap();
        println!("{name}: {} faces in {:?}", model.faces.len(), start.elapsed());
        assert_eq!(model.source.vertices, vertices, "{name}: vertices of the file");
        assert_eq!(model.source.polygons, polygons, "{name}: polygons of the file");
        assert_eq!(model.faces.len(), faces, "{name}: triangles");
        assert!(model.positions.len() >= vertices, "{name}: no vertex is lost");
        assert_eq!(model.polygons.is_some(), polygons != faces, "{name}: polygons are told exactly if some are no triangles");
        assert_eq!(model.source.notes, Vec::<String>::new(), "{name}: nothing needs mending");
        let report = clean(&model.positions, &model.faces, &CleanOptions::default()).unwrap().report;
        assert_eq!(report.faces_in, faces, "{name}: cleaning takes every face");
    }
}
