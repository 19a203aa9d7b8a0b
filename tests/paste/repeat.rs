//! The same job gives the same bytes, however many threads work on it and however often; another seed does not.

#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use crate::common::{input, pasted};
use glam::DVec3;
use lapped::exemplar::PatchSource;
use lapped::format::write_record;
use lapped::job::{PasteJob, Scale, Steer, paste_model};
use lapped::paste::PasteOptions;
use lapped::progress::{Progress, Silent};

/// The bytes of the record that `threads` threads write.
fn written(threads: usize, steer: &Steer, seed: u64) -> Vec<u8> {
    let model = lapped::assets::mesh("dragonling").unwrap();
    let job = PasteJob {
        scale: Scale::Ratio(40.0),
        steer: steer.clone(),
        paste: PasteOptions { seed, ..PasteOptions::default() },
        ..PasteJob::default()
    };
    let inputs = vec![input("moss", &[]), input("stone", &[PatchSource::Circle])];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let done = paste_model(&model, inputs, &job, &Silent).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.glb");
        write_record(&path, &done.record).unwrap();
        std::fs::read(&path).unwrap()
    })
}

#[test]
fn the_written_bytes_are_the_same_for_any_number_of_threads_and_every_run() {
    for steer in [Steer::Up(DVec3::Y), Steer::Isotropic(None)] {
        let one = written(1, &steer, 1);
        for threads in [1, 2, 3] {
            let other = written(threads, &steer, 1);
            let differs = one.iter().zip(&other).position(|(a, b)| a != b);
            assert!(one.len() == other.len() && differs.is_none(), "{threads} threads: byte {differs:?} differs, {steer:?}");
        }
    }
}

#[test]
fn another_seed_gives_another_layout() {
    let model = lapped::assets::mesh("vase").unwrap();
    let run = |seed| {
        let paste = PasteOptions { seed, ..PasteOptions::default() };
        pasted(&model, "rust", &PasteJob { paste, ..PasteJob::default() }).lapped.pastes
    };
    let (one, two) = (run(1), run(2));
    assert_eq!(one, run(1), "the same seed gives the same pastes");
    let shared = one.iter().filter(|p| two.iter().any(|q| q.faces == p.faces)).count();
    assert!(shared * 5 < one.len(), "{shared} of {} pastes lie on the same faces with another seed", one.len());
}

/// Asks to stop at once.
struct Stop;

impl Progress for Stop {
    fn stage(&self, _name: &str, _total: u64) {}
    fn done(&self, _done: u64) {}
    fn cancelled(&self) -> bool {
        true
    }
}

#[test]
fn a_sink_that_cancels_ends_the_job() {
    let model = lapped::assets::mesh("vase").unwrap();
    let ended = paste_model(&model, vec![input("rust", &[])], &PasteJob::default(), &Stop);
    assert_eq!(ended.unwrap_err().to_string(), "pasting was cancelled", "the job says why it has no result");
}
