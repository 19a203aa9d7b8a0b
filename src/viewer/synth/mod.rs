//! Syntheses beside the pastes: the same exemplar, size and direction on the same model, by Wei and Levoy or by Chen and Dong, as
//! modes of a pane.
//!
//! [`SynthRoom`] asks for one when a pane shows it and what it is of has changed, and holds what is there; `make` does the work on
//! a thread of its own. What is shown meanwhile is what was there before, then the levels as they are done.

mod make;
pub(super) mod panel;

use super::build::Shown;
use super::graphics::Graphics;
use super::library::OpenModel;
use super::mode::Mode;
use super::worker::{Lane, Meter};
use crate::exemplar::Exemplar;
use crate::field::Constraints;
use crate::job::project::Direction;
use crate::job::{Link, Project, Synthesis};
use crate::render::gpu::Subject;
use crate::synth::VertexTexture;
use make::{Circles, SynthError, make};
use std::sync::Arc;

/// A method of synthesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Method {
    /// Wei and Levoy 2001: on re-tiled meshes, level by level.
    WeiLevoy,
    /// Chen and Dong 2008: on the model's own vertices, by circles about them that are marched once.
    ChenDong,
}

impl Method {
    /// Both.
    pub const ALL: [Self; 2] = [Self::WeiLevoy, Self::ChenDong];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::WeiLevoy => "Wei-Levoy",
            Self::ChenDong => "Chen-Dong",
        }
    }

    /// What it is, for who does not know.
    #[must_use]
    pub const fn hint(self) -> &'static str {
        match self {
            Self::WeiLevoy => {
                "Synthesised by Wei and Levoy 2001 instead of pasted: the exemplar matched vertex by vertex on a re-tiled mesh, level by level"
            }
            Self::ChenDong => {
                "Synthesised by Chen and Dong 2008 instead of pasted, on the model's own vertices: circles about them are marched once, and \
                 every other direction is then matched at once"
            }
        }
    }

    /// The mode that shows it.
    #[must_use]
    pub const fn mode(self) -> Mode {
        match self {
            Self::WeiLevoy => Mode::WeiLevoy,
            Self::ChenDong => Mode::ChenDong,
        }
    }

    const fn number(self) -> usize {
        match self {
            Self::WeiLevoy => 0,
            Self::ChenDong => 1,
        }
    }
}

/// Everything that a synthesis depends on.
#[derive(Debug, Clone)]
struct Wanted {
    open: Arc<OpenModel>,
    link: Option<Link>,
    scale: Option<f64>,
    direction: Direction,
    constraints: Constraints,
    synthesis: Synthesis,
}

impl PartialEq for Wanted {
    fn eq(&self, other: &Self) -> bool {
        let steered = |w: &Self| (w.scale, w.direction, w.synthesis);
        Arc::ptr_eq(&self.open, &other.open)
            && self.link == other.link
            && steered(self) == steered(other)
            && self.constraints == other.constraints
    }
}

/// Figures of a synthesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// Levels that are done, and how many there are; once all are, it is whole.
    pub levels: [usize; 2],
    /// Vertices.
    pub vertices: usize,
    /// Size of the exemplar as it was used, pixels.
    pub exemplar: [u32; 2],
    /// Seconds for what depends on the mesh alone (re-tiling, or marching, 0 if it was kept), for directions, and for matching.
    pub seconds: [f64; 3],
}

impl Figures {
    /// True if all levels are done.
    #[must_use]
    pub const fn whole(&self) -> bool {
        self.levels[0] == self.levels[1]
    }
}

/// A synthesis, or its levels so far.
#[derive(Debug)]
struct Made {
    wanted: Wanted,
    revision: u64,
    subject: Subject,
    /// Once it is whole.
    texture: Option<Arc<VertexTexture>>,
    figures: Figures,
}

type Answer = Result<Made, SynthError>;

/// The work on one method.
#[derive(Debug)]
struct Bench {
    lane: Lane<Answer>,
    asked: Option<Wanted>,
    made: Option<(u64, Made)>,
}

/// The syntheses that are there.
#[derive(Debug)]
pub struct SynthRoom {
    benches: [Bench; 2],
    circles: Arc<Circles>,
    /// Counts what was made.
    count: u64,
}

impl SynthRoom {
    /// None yet; `wake` is called when one is there.
    pub fn new(wake: impl Fn() + Send + Sync + Clone + 'static) -> Self {
        let bench = |name| Bench { lane: Lane::new(name, wake.clone()), asked: None, made: None };
        Self { benches: [bench("lapped levels"), bench("lapped circles")], circles: Arc::default(), count: 0 }
    }

    /// True if nothing is being made.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.meter().is_none()
    }

    /// The work that goes on, if any does.
    #[must_use]
    pub fn meter(&self) -> Option<Arc<Meter>> {
        self.benches.iter().find_map(|bench| bench.lane.meter())
    }

    /// Stops what is being made. It is not begun again until something changes.
    pub fn cancel(&self) {
        self.benches.iter().for_each(|bench| bench.lane.cancel());
    }

    /// Begins anew with what is asked for next.
    pub fn forget(&mut self) {
        self.benches.iter_mut().for_each(|bench| bench.asked = None);
    }

    fn of(&self, method: Method, shown: &Shown) -> Option<&(u64, Made)> {
        // That of another model is no picture of this one.
        self.benches[method.number()].made.as_ref().filter(|(_, made)| Arc::ptr_eq(&made.wanted.open, &shown.open))
    }

    /// The subject of a method on what is shown, if it is there, and a number that is another with every other; it may be of an
    /// earlier revision.
    #[must_use]
    pub fn subject(&self, method: Method, shown: &Shown) -> (Option<&Subject>, u64) {
        self.of(method, shown).map_or((None, 0), |(number, made)| (Some(&made.subject), *number))
    }

    /// Its figures.
    #[must_use]
    pub fn figures(&self, method: Method, shown: &Shown) -> Option<&Figures> {
        self.of(method, shown).map(|(_, made)| &made.figures)
    }

    /// The whole texture of a method, to be written, unless something newer is being made.
    #[must_use]
    pub fn texture(&self, method: Method, shown: &Shown) -> Option<Arc<VertexTexture>> {
        let current = self.benches[method.number()].lane.meter().is_none();
        self.of(method, shown).and_then(|(_, made)| made.texture.clone()).filter(|_| current)
    }

    /// How many pictures, of levels and of whole syntheses, have come.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Takes in what was made. The latest revision of the document that is seen now, with its vertices; and what went wrong.
    pub fn take(&mut self) -> (Option<(u64, usize)>, Vec<SynthError>) {
        let (mut seen, mut errors) = (None, Vec::new());
        for bench in &mut self.benches {
            for answer in bench.lane.take() {
                match answer {
                    Ok(made) => {
                        self.count += 1;
                        seen = made.figures.whole().then_some((made.revision, made.figures.vertices)).or(seen);
                        let before = bench.made.replace((self.count, made));
                        // Letting go of a large mesh takes longer than a frame.
                        rayon::spawn(move || drop(before));
                    }
                    Err(error) if error.is_cancelled() => {}
                    Err(error) => errors.push(error),
                }
            }
        }
        (seen, errors)
    }

    /// Asks for the methods that are to be seen on what is shown, with what a project's document of a revision chooses.
    pub fn ask(
        &mut self,
        methods: impl Iterator<Item = Method>,
        shown: &Arc<Shown>,
        chosen: Synthesis,
        revision: u64,
        graphics: &Graphics,
    ) {
        for method in methods {
            let exemplar = exemplar(shown, chosen);
            let wanted = Wanted {
                open: Arc::clone(&shown.open),
                link: shown.project.exemplars.get(chosen.exemplar).map(|e| e.link.clone()),
                scale: shown.report().map(|report| report.scale),
                direction: shown.project.direction,
                constraints: shown.project.constraints.clone(),
                synthesis: chosen,
            };
            let bench = &mut self.benches[method.number()];
            if exemplar.is_none() || bench.asked.as_ref() == Some(&wanted) {
                continue;
            }
            bench.asked = Some(wanted.clone());
            let (shown, circles) = (Arc::clone(shown), Arc::clone(&self.circles));
            let renderer = Arc::clone(&graphics.renderer);
            bench.lane.submit(move |meter, deliver| {
                let project = Project { synthesis: chosen, ..shown.project.clone() };
                let Some(exemplar) = self::exemplar(&shown, chosen) else { return };
                let show = |subject, texture, figures| {
                    deliver(Ok(Made { wanted: wanted.clone(), revision, subject, texture, figures }));
                };
                if let Err(error) = make(method, &project, &shown, exemplar, &circles, &renderer, &**meter, &show) {
                    deliver(Err(error));
                }
            });
        }
    }
}

/// The exemplar that is chosen, of what is shown; the first if there is no such one.
fn exemplar(shown: &Shown, chosen: Synthesis) -> Option<&Exemplar> {
    let all = &shown.lapped()?.exemplars;
    all.get(chosen.exemplar).or_else(|| all.first())
}
