//! `lapped compare`: pages, what is kept, and what is told of broken pairs.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::program::{Place, text};
use serde_json::Value;

fn json(place: &Place, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(place.path(name)).unwrap()).unwrap()
}

fn page(place: &Place, name: &str) -> String {
    std::fs::read_to_string(place.path(name)).unwrap()
}

const SMALL: [&str; 6] = ["--exemplar-size", "48", "--ratio", "4", "--size", "64x48"];

#[test]
fn one_pair_is_a_page_a_report_and_pictures_and_is_kept() {
    let place = Place::new();
    let methods = ["--methods", "pasted,triplanar,tiling"];
    let args = [&["compare", "mesh.obj", "wood.png", "-o", "out/c"][..], &SMALL, &methods].concat();
    let out = place.run(&args);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(text(&out.stdout).contains("out/c/report.html"), "the page is named: {}", text(&out.stdout));
    assert_eq!(place.files("out/c"), ["pictures", "report.html", "report.json"], "files written");
    let report = json(&place, "out/c/report.json");
    let methods: Vec<&str> = report["methods"].as_array().unwrap().iter().map(|m| m["method"].as_str().unwrap()).collect();
    assert_eq!(methods, ["pasted", "triplanar", "tiling"], "methods in the order asked for");
    for method in report["methods"].as_array().unwrap() {
        for view in method["pictures"].as_array().unwrap() {
            let name = format!("out/c/pictures/{}.png", view["texture"].as_str().unwrap());
            let picture = image::open(place.path(&name)).unwrap();
            assert_eq!((picture.width(), picture.height()), (64, 48), "size of {name}");
        }
    }
    let html = page(&place, "out/c/report.html");
    assert!(!html.contains("http://") && !html.contains("https://"), "the page needs no network");
    assert!(html.contains("data:image/jpeg;base64,"), "pictures are in it");
    let command = report["asked"]["command"].as_str().unwrap();
    for word in
        ["lapped compare mesh.obj wood.png", "--methods pasted,triplanar,tiling", "--ratio 4", "--exemplar-size 48", "--seed 1"]
    {
        assert!(command.contains(word), "{word:?} is in the command that does it again: {command}");
    }
    // The same again is kept, with another seed it is not.
    let before = std::fs::metadata(place.path("out/c/report.json")).unwrap().modified().unwrap();
    let again = place.run(&args);
    assert!(text(&again.stderr).contains("kept"), "{}", text(&again.stderr));
    assert_eq!(std::fs::metadata(place.path("out/c/report.json")).unwrap().modified().unwrap(), before, "nothing is written again");
    let other = place.run(&[&args[..], &["--seed", "2"]].concat());
    assert_eq!(other.status.code(), Some(0), "{}", text(&other.stderr));
    assert_eq!(json(&place, "out/c/report.json")["setting"]["seed"], 2, "another seed is another comparison");
    let small = place.run(&[&args[..], &["--small"]].concat());
    assert_eq!(small.status.code(), Some(0), "{}", text(&small.stderr));
    assert!(!text(&small.stderr).contains("kept"), "and so are smaller pastes: {}", text(&small.stderr));
    let report = json(&place, "out/c/report.json");
    assert!(report["asked"]["command"].as_str().unwrap().ends_with("--small"), "the command has the switch: {}", report["asked"]);
}

#[test]
fn many_pairs_have_a_page_over_them_and_broken_ones_do_not_stop_the_rest() {
    let place = Place::new();
    place.write("broken.png", "no image");
    place.write(
        "job.toml",
        "mesh = [\"mesh.obj\"]\nexemplar = [\"wood.png\", \"broken.png\", { file = \"rust.png\", field = \"none\", name = \"iron\" }]\n\
         [defaults]\nmethods = [\"hex\", \"triplanar\"]\nratio = 4\nexemplar-size = 48\nsize = \"64x48\"\n",
    );
    let args = ["compare", "--job", "job.toml", "-o", "out/c", "--report", "out/run.json"];
    let out = place.run(&args);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(text(&out.stdout).contains("2 of 3"), "{}", text(&out.stdout));
    assert_eq!(place.files("out/c"), ["index.html", "index.json", "mesh-iron", "mesh-wood"], "a folder each, and the page");
    let index = json(&place, "out/c/index.json");
    let cells = index["cells"].as_array().unwrap();
    assert!(cells[1]["failed"].as_str().unwrap().contains("broken.png"), "the broken one is told: {}", cells[1]);
    assert_eq!(json(&place, "out/c/mesh-iron/report.json")["setting"]["ways"], 0, "keys of an exemplar count");
    assert!(index["failures"].as_array().unwrap().len() >= 2, "failures of each method: {index}");
    // A run that was stopped goes on where it was: what is finished is kept, the rest is done.
    std::fs::remove_file(place.path("out/c/mesh-iron/report.json")).unwrap();
    let again = place.run(&args);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again.stderr));
    let kept: Vec<bool> =
        json(&place, "out/run.json")["cells"].as_array().unwrap().iter().map(|c| c["kept"].as_bool().unwrap()).collect();
    assert_eq!(kept, [true, false, false], "what was finished is kept");
}

#[test]
fn what_cannot_be_compared_is_told_in_a_sentence() {
    let place = Place::new();
    place.write("empty.toml", "mesh = \"mesh.obj\"\n");
    place.write("unknown.toml", "mesh = [\"mesh.obj\"]\nexemplar = [\"wood.png\"]\n[defaults]\nsize = \"64x48\"\ncolour = 1\n");
    let lines: [(&[&str], i32, &str); 8] = [
        (&["compare", "--job", "empty.toml", "-o", "out/c", "--ratio", "3"], 2, "--ratio"),
        (&["compare", "mesh.obj", "wood.png", "-o", "out/c", "--methods", "magic"], 2, "there are pasted, plain, baked"),
        (&["compare", "mesh.obj", "wood.png"], 2, "--output"),
        (&["compare", "none.obj", "wood.png", "-o", "out/c"], 1, "none.obj"),
        (&["compare", "mesh.obj", "wood.png", "-o", "mesh.obj"], 1, "name a folder"),
        (&["compare", "mesh.obj", "wood.png", "-o", "out/c", "--scale=-1"], 1, "--scale is -1"),
        (&["compare", "--job", "empty.toml", "-o", "out/c"], 1, "there is no mesh"),
        (&["compare", "--job", "unknown.toml", "-o", "out/c"], 1, "colour"),
    ];
    for (args, code, told) in lines {
        let out = place.run(args);
        let stderr = text(&out.stderr);
        assert_eq!(out.status.code(), Some(code), "{args:?}: {stderr}");
        assert!(stderr.contains(told) && !stderr.contains("panicked"), "{args:?} says {told:?}: {stderr}");
    }
}
