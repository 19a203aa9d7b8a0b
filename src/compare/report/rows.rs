//! The rows of the table: each measure with what it means, where it comes from, what is good, and who is best.

use crate::compare::cell::{Figures, MethodReport};
use crate::compare::measures::Measured;
use serde::Serialize;

/// Which values are good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Good {
    /// Small ones; with a floor, all that are no larger than it are as good as each other.
    Low,
    /// Large ones.
    High,
    /// Those near this one, by their ratio to it.
    Near(f64),
    /// Neither: it tells what a method does.
    Neither,
}

/// A row.
pub struct Row {
    /// Its name in files.
    pub key: &'static str,
    /// What it belongs to.
    pub group: &'static str,
    /// Its name for people.
    pub label: &'static str,
    /// Its unit; empty for shares and ratios.
    pub unit: &'static str,
    /// Which values are good.
    pub good: Good,
    /// What it is, and what it is blind to.
    pub explains: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// Its value.
    pub value: fn(&Figures) -> Option<f64>,
    /// What one half of the exemplar has against the other.
    pub floor: fn(&Measured) -> Option<f64>,
}

const LOOKS: &str = "Looks like the exemplar";
const SEAMS: &str = "Seams";
const COPIES: &str = "Copying";
const LIES: &str = "How it lies on the surface";
const COSTS: &str = "What it takes";

const OURS: &str = "ours; see docs/comparison.md";
const SIMAKOV: &str = "Simakov et al., \"Summarizing visual data using bidirectional similarity\", CVPR 2008";
const SANDER: &str = "Sander et al., \"Texture mapping progressive meshes\", SIGGRAPH 2001";

fn none(_: &Measured) -> Option<f64> {
    None
}

/// All rows, in the order they are shown.
pub const ROWS: [Row; 25] = [
    Row {
        key: "swd",
        group: LOOKS,
        label: "Patch distribution (SWD)",
        unit: "x 100",
        good: Good::Low,
        explains: "How far the 7x7 patches of three levels must be moved to be distributed as the exemplar's: sliced Wasserstein \
                   distance over 256 fixed projections. Blind to where patches lie, in part to blur.",
        source: "Elnekave, Weiss, \"Generating natural images with direct patch distributions matching\", ECCV 2022",
        value: |f| Some(f.fidelity.swd),
        floor: |m| Some(m.swd),
    },
    Row {
        key: "coherence",
        group: LOOKS,
        label: "Coherence, mean",
        unit: "",
        good: Good::Low,
        explains: "From each 11x11 patch of the result to the nearest one of the exemplar: is everything shown something that the \
                   exemplar shows? Blind to a result that repeats one piece.",
        source: SIMAKOV,
        value: |f| Some(f.fidelity.coherence.mean),
        floor: |m| Some(m.coherence.mean),
    },
    Row {
        key: "coherence99",
        group: LOOKS,
        label: "Coherence, worst hundredth",
        unit: "",
        good: Good::Low,
        explains: "The same, exceeded by one patch in a hundred: what an eye calls a seam or a smudge.",
        source: SIMAKOV,
        value: |f| Some(f.fidelity.coherence.p99),
        floor: |m| Some(m.coherence.p99),
    },
    Row {
        key: "completeness",
        group: LOOKS,
        label: "Completeness, mean",
        unit: "",
        good: Good::Low,
        explains: "From each patch of the exemplar to the nearest one of the result: is all of the exemplar there? Blind to seams.",
        source: SIMAKOV,
        value: |f| Some(f.fidelity.completeness.mean),
        floor: |m| Some(m.completeness.mean),
    },
    Row {
        key: "energy",
        group: LOOKS,
        label: "Detail (Laplacian energy)",
        unit: "",
        good: Good::Near(1.0),
        explains: "Energy of the Laplacian over the exemplar's: below 1 is blurred, above is noisy or has edges that do not belong there.",
        source: OURS,
        value: |f| Some(f.fidelity.energy),
        floor: |m| Some(m.energy),
    },
    Row {
        key: "histogram",
        group: LOOKS,
        label: "Colours",
        unit: "of 255",
        good: Good::Low,
        explains: "How far colours must be moved to have the exemplar's distribution. Blind to where they lie.",
        source: "sliced Wasserstein distance of single pixels, 13 fixed directions",
        value: |f| Some(f.fidelity.histogram),
        floor: |m| Some(m.histogram),
    },
    Row {
        key: "repetition",
        group: LOOKS,
        label: "Repetition seen",
        unit: "",
        good: Good::Low,
        explains: "The largest correlation of the result with itself beyond 40 pixels. Exemplars that are regular repeat by themselves: \
                   the floor is theirs.",
        source: OURS,
        value: |f| Some(f.fidelity.repetition),
        floor: |m| Some(m.repetition),
    },
    Row {
        key: "seams",
        group: SEAMS,
        label: "Borders of what was copied",
        unit: "",
        good: Good::Low,
        explains: "The mean step of colour over one pixel where a copy ends and another begins (patches, projections, hexagons, charts, \
                   jumps of synthesis), over the exemplar's own steps: 1 is invisible. Soft edges spread a border over several pixels, \
                   of which this sees one; coherence sees them all.",
        source: OURS,
        value: |f| (f.seams.places > 0).then_some(f.seams.ratio),
        floor: |_| Some(1.0),
    },
    Row {
        key: "seamsBeyond",
        group: SEAMS,
        label: "Of these, hard steps",
        unit: "share",
        good: Good::Low,
        explains: "Share of those steps that are among the exemplar's largest hundredth: 0.01 is invisible.",
        source: OURS,
        value: |f| (f.seams.places > 0).then_some(f.seams.beyond),
        floor: |_| Some(0.01),
    },
    Row {
        key: "chartSeams",
        group: SEAMS,
        label: "Borders of charts",
        unit: "",
        good: Good::Low,
        explains: "The mean step of colour over chart borders, over the exemplar's own: 1 is invisible. Only where there are charts.",
        source: OURS,
        value: |f| f.chart_seams.filter(|c| c.places > 0).map(|c| c.ratio),
        floor: |_| Some(1.0),
    },
    Row {
        key: "copied",
        group: COPIES,
        label: "Copied verbatim",
        unit: "share",
        good: Good::Neither,
        explains: "Share of points whose neighbour 16 pixels away was copied along with them. Large pieces keep structure; they are \
                   also what is recognised when it comes again.",
        source: "source maps, after Ashikhmin, \"Synthesizing natural textures\", I3D 2001",
        value: |f| Some(f.mapping.copied),
        floor: none,
    },
    Row {
        key: "copyLength",
        group: COPIES,
        label: "Length of a copy",
        unit: "pixels",
        good: Good::Neither,
        explains: "The distance at which half of the neighbours were copied along; 64 stands for that or more.",
        source: "source maps",
        value: |f| Some(f.mapping.copy_length),
        floor: none,
    },
    Row {
        key: "repeats",
        group: COPIES,
        label: "Same place at one shift",
        unit: "share",
        good: Good::Low,
        explains: "Autocorrelation of the source map: the largest share of points that show the same place of the exemplar again at one \
                   shift of a third of its width or more. 1 is plain tiling.",
        source: OURS,
        value: |f| Some(f.mapping.repeats),
        floor: none,
    },
    Row {
        key: "used",
        group: COPIES,
        label: "Use of the exemplar",
        unit: "share",
        good: Good::High,
        explains: "How evenly its parts are shown: the exponential of the entropy of a 16 x 16 grid, over 256.",
        source: OURS,
        value: |f| Some(f.mapping.used),
        floor: none,
    },
    Row {
        key: "direction",
        group: LIES,
        label: "Off the field",
        unit: "degrees",
        good: Good::Low,
        explains: "Angle between texture up and the field, root mean square, where neighbours were copied together.",
        source: "Praun et al. 2000, sec. 3.2",
        value: |f| f.mapping.direction_rms,
        floor: none,
    },
    Row {
        key: "scale",
        group: LIES,
        label: "Size",
        unit: "of that asked",
        good: Good::Near(1.0),
        explains: "Mean length of a pixel on the surface over the one asked for.",
        source: OURS,
        value: |f| (f.mapping.mapped > 0.0).then_some(f.mapping.scale),
        floor: none,
    },
    Row {
        key: "stretchL2",
        group: LIES,
        label: "Stretch, L2",
        unit: "",
        good: Good::Near(1.0),
        explains: "How unevenly the surface is sampled by the exemplar's pixels, root mean square over surface and directions; 1 is even.",
        source: SANDER,
        value: |f| (f.mapping.mapped > 0.0).then_some(f.mapping.stretch_l2),
        floor: none,
    },
    Row {
        key: "stretchLinf",
        group: LIES,
        label: "Stretch, largest",
        unit: "",
        good: Good::Near(1.0),
        explains: "The same at the worst of the points drawn, in its worst direction.",
        source: SANDER,
        value: |f| (f.mapping.mapped > 0.0).then_some(f.mapping.stretch_linf),
        floor: none,
    },
    Row {
        key: "leastAlpha",
        group: LIES,
        label: "Cover, worst point",
        unit: "",
        good: Good::High,
        explains: "The least opacity of the points drawn.",
        source: "Praun et al. 2000, sec. 3.6",
        value: |f| Some(f.mapping.least_alpha),
        floor: none,
    },
    Row {
        key: "draws",
        group: COSTS,
        label: "Draws per face",
        unit: "",
        good: Good::Low,
        explains: "How often a face is drawn, on the mean. Projections draw once and read up to three or nine times.",
        source: "Praun et al. 2000, sec. 4",
        value: |f| Some(f.costs.draws_per_face),
        floor: none,
    },
    Row {
        key: "textureBytes",
        group: COSTS,
        label: "Texture bytes",
        unit: "a square",
        good: Good::Low,
        explains: "Images that a renderer holds, 8 bits a channel, four channels, with mip levels, for each square of the exemplar's width \
                   on the surface.",
        source: OURS,
        value: |f| Some(f.costs.texture_bytes_per_square),
        floor: none,
    },
    Row {
        key: "recordBytes",
        group: COSTS,
        label: "Other bytes",
        unit: "a square",
        good: Good::Low,
        explains: "All else beside the mesh: pastes, texture coordinates, or a finer mesh with colours.",
        source: OURS,
        value: |f| Some(f.costs.record_bytes_per_square),
        floor: none,
    },
    Row {
        key: "allBytes",
        group: COSTS,
        label: "All bytes",
        unit: "a square",
        good: Good::Low,
        explains: "Both together.",
        source: OURS,
        value: |f| Some(f.costs.texture_bytes_per_square + f.costs.record_bytes_per_square),
        floor: none,
    },
    Row {
        key: "seconds",
        group: COSTS,
        label: "Time to make",
        unit: "s",
        good: Good::Low,
        explains: "Wall seconds, mesh and field given, as the machine was at the time. Of a bake, pasting included.",
        source: "measured",
        value: |f| Some(f.costs.seconds),
        floor: none,
    },
    Row {
        key: "peak",
        group: COSTS,
        label: "Memory to make",
        unit: "MB",
        good: Good::Low,
        explains: "The most that was held at a time, beyond what was held before. Memory that an earlier method left free is not seen.",
        source: "the system's high-water mark",
        value: |f| f.costs.peak_bytes.map(|b| b as f64 / 1e6),
        floor: none,
    },
];

/// Values within this share of the best one are as good.
const TIE: f64 = 0.03;

/// A row with its values, as it is written.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct RowReport {
    /// Its name in files.
    pub key: &'static str,
    /// What it belongs to.
    pub group: &'static str,
    /// Its name for people.
    pub label: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// `lower`, `higher`, `near 1` or `neither`.
    pub good: String,
    /// What it is, and what it is blind to.
    pub explains: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    /// What one half of the exemplar has against the other.
    pub floor: Option<f64>,
    /// A value a method, in their order.
    pub values: Vec<Option<f64>>,
    /// The best, by name; several where they are as good as each other.
    pub winners: Vec<&'static str>,
    /// Why, in a sentence.
    pub why: String,
}

impl Good {
    fn name(self) -> String {
        match self {
            Self::Low => "lower".to_owned(),
            Self::High => "higher".to_owned(),
            Self::Near(to) => format!("near {to}"),
            Self::Neither => "neither".to_owned(),
        }
    }

    /// How far a value is from being perfect, and how much of that is nothing.
    fn far(self, value: f64, floor: Option<f64>) -> Option<f64> {
        match self {
            Self::Low => Some(value.max(floor.unwrap_or(f64::NEG_INFINITY))),
            Self::High => Some(-value),
            Self::Near(to) => Some((value / to).ln().abs()),
            Self::Neither => None,
        }
    }
}

impl Row {
    /// The row of these methods.
    #[must_use]
    pub fn of(&self, methods: &[MethodReport], floor: &Measured) -> RowReport {
        let usable = |v: Option<f64>| v.filter(|v| v.is_finite());
        let values: Vec<Option<f64>> = methods.iter().map(|m| usable(m.figures.as_ref().and_then(self.value))).collect();
        let floor = usable((self.floor)(floor));
        let far: Vec<Option<f64>> = values.iter().map(|v| v.and_then(|v| self.good.far(v, floor))).collect();
        let best = far.iter().flatten().copied().min_by(f64::total_cmp);
        let measured = far.iter().flatten().count();
        let is_best = |f: &Option<f64>| match (f, best) {
            (Some(f), Some(best)) => {
                // Near values are logarithms already.
                let slack = if matches!(self.good, Good::Near(_)) { TIE } else { TIE * best.abs() };
                measured > 1 && *f <= best + slack
            }
            _ => false,
        };
        let won: Vec<usize> = (0..methods.len()).filter(|&i| is_best(&far[i])).collect();
        // Where all are as good, nobody wins.
        let won = if won.len() == measured { Vec::new() } else { won };
        let why = self.why(methods, &values, &won, floor, measured);
        RowReport {
            key: self.key,
            group: self.group,
            label: self.label,
            unit: self.unit,
            good: self.good.name(),
            explains: self.explains,
            source: self.source,
            floor,
            winners: won.iter().map(|&i| methods[i].method.key()).collect(),
            values,
            why,
        }
    }

    fn why(&self, methods: &[MethodReport], values: &[Option<f64>], won: &[usize], floor: Option<f64>, measured: usize) -> String {
        if self.good == Good::Neither {
            return "It tells what a method does; neither more nor less is better.".to_owned();
        }
        if measured < 2 {
            return "Fewer than two methods have it.".to_owned();
        }
        if won.is_empty() {
            return "All are as good as each other here.".to_owned();
        }
        let names: Vec<&str> = won.iter().map(|&i| methods[i].label).collect();
        let all = names.join(", ");
        let at_floor = self.good == Good::Low
            && floor.is_some_and(|floor| won.iter().all(|&i| values[i].is_some_and(|v| v <= floor * (1.0 + TIE))));
        match (self.good, at_floor) {
            (Good::Low, true) => format!("{all}: at the floor, where nothing better can be told."),
            (Good::Low, false) => format!("{all}: lowest, within {:.0} %.", 100.0 * TIE),
            (Good::High, _) => format!("{all}: highest, within {:.0} %.", 100.0 * TIE),
            (Good::Near(to), _) => format!("{all}: nearest to {to}, within {:.0} %.", 100.0 * TIE),
            (Good::Neither, _) => String::new(),
        }
    }
}
