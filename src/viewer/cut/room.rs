//! Cutting in the window: the exemplar with its edges, outlines that become shapes of the project, and the veil that shows their alpha.

use super::editor::{self, Canvas, Zoom};
use super::{Cutter, Line, preview};
use crate::exemplar::{Channel, Edges, Outline};
use crate::job::patches::default_feather;
use crate::job::project::{Link, ProjectExemplar, Shape};
use crate::viewer::library::OpenExemplar;
use crate::viewer::worker::Lane;
use egui::{ColorImage, ComboBox, Context, TextureHandle, TextureOptions, Ui};
use glam::Vec2;
use std::sync::Arc;

/// Outlines as near as this, pixels, are the same: fractions are rounded.
const SAME: f32 = 0.02;

/// Something that a thread has made of the exemplar.
enum Made {
    Picture(ColorImage),
    Edges(Edges),
    Veil(u64, Result<ColorImage, String>),
}

impl std::fmt::Debug for Made {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Picture(_) => "picture",
            Self::Edges(_) => "edges",
            Self::Veil(..) => "veil",
        })
    }
}

/// Outlines being cut from one exemplar.
pub struct CutRoom {
    /// Its place among the project's exemplars.
    pub index: usize,
    cutter: Cutter,
    read: Arc<OpenExemplar>,
    zoom: Zoom,
    picture: Option<TextureHandle>,
    veil: Option<TextureHandle>,
    edges: Lane<Made>,
    veils: Lane<Made>,
    /// The revision whose veil was asked for, and the feather.
    asked: Option<(u64, f32)>,
    /// The revision that the project has.
    sent: u64,
    show_veil: bool,
    trouble: Option<String>,
}

/// What the user wants of the room.
#[derive(Debug, Clone, PartialEq)]
pub enum Wanted {
    /// These shapes for the exemplar.
    Shapes(Vec<Shape>),
    /// To cut from another of the project's exemplars.
    Exemplar(usize),
    /// To close it.
    Close,
}

impl std::fmt::Debug for CutRoom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CutRoom").field("index", &self.index).field("cutter", &self.cutter).finish_non_exhaustive()
    }
}

impl CutRoom {
    /// Begins with the outlines that the exemplar has; `wake` is called whenever something more can be shown.
    pub fn new(
        index: usize,
        exemplar: &ProjectExemplar,
        read: Arc<OpenExemplar>,
        wake: impl Fn() + Clone + Send + Sync + 'static,
    ) -> Self {
        let edges = Lane::new("lapped edges", wake.clone());
        let of = Arc::clone(&read);
        edges.submit(move |_, deliver| {
            deliver(Made::Picture(preview::picture(&of.exemplar)));
            if let Some(color) = of.exemplar.channel(Channel::BaseColor) {
                deliver(Made::Edges(Edges::new(color.finest())));
            }
        });
        Self {
            index,
            cutter: Cutter::new(&outlines(&exemplar.shapes, read.exemplar.size())),
            zoom: Zoom::default(),
            picture: None,
            veil: None,
            edges,
            veils: Lane::new("lapped veil", wake),
            asked: None,
            sent: 0,
            show_veil: true,
            trouble: None,
            read,
        }
    }

    /// True if it cuts this exemplar.
    #[must_use]
    pub fn is_of(&self, link: &Link) -> bool {
        self.read.link == *link
    }

    /// Where a pixel of the exemplar is in the window, once it was shown there.
    #[must_use]
    pub fn place(&self, pixel: Vec2) -> Option<egui::Pos2> {
        self.zoom.place(pixel)
    }

    /// The state of the outlines.
    #[must_use]
    pub const fn cutter(&self) -> &Cutter {
        &self.cutter
    }

    /// Takes the last anchor of an outline being drawn back. False if none is being drawn.
    pub fn back(&mut self) -> bool {
        let drawing = self.cutter.drawing().is_some();
        self.cutter.back();
        drawing
    }

    /// Gives the outline being drawn up, or else the selection. False if there is neither.
    pub fn escape(&mut self) -> bool {
        let some = self.cutter.drawing().is_some() || self.cutter.selected().is_some();
        self.cutter.escape();
        some
    }

    /// Keeps up with shapes that were changed elsewhere, as by undoing.
    pub fn follow(&mut self, shapes: &[Shape]) {
        if self.cutter.drawing().is_none() && self.cutter.revision() == self.sent {
            self.cutter.follow(&outlines(shapes, self.read.exemplar.size()), SAME);
            self.sent = self.cutter.revision();
        }
    }

    /// Shows the editor with its bar. What the user wants of it. `names` are those of the project's exemplars.
    pub fn show(&mut self, ui: &mut Ui, feather: Option<f32>, names: &[String]) -> Option<Wanted> {
        let size = self.read.exemplar.size();
        let feather = feather.unwrap_or_else(|| default_feather(size));
        self.take(ui.ctx());
        let mut wanted = self.bar(ui, names);
        let canvas = Canvas {
            picture: self.picture.as_ref().map(TextureHandle::id),
            veil: self.veil.as_ref().filter(|_| self.show_veil && !self.cutter.outlines().is_empty()).map(TextureHandle::id),
            size,
        };
        editor::show(ui, &mut self.cutter, &mut self.zoom, &canvas);
        let revision = self.cutter.revision();
        if self.asked != Some((revision, feather)) {
            self.asked = Some((revision, feather));
            let (read, cut) = (Arc::clone(&self.read), self.cutter.result());
            self.veils.submit(move |_, deliver| {
                let veil = preview::veil(&read.exemplar, &cut, feather).map_err(|e| e.to_string());
                deliver(Made::Veil(revision, veil));
            });
        }
        if self.sent != revision {
            self.sent = revision;
            let cut = self.cutter.result();
            // What cannot be cut is told by the veil, and not pasted.
            let usable = cut.iter().all(|outline| outline.check(size).is_ok());
            wanted = usable.then(|| Wanted::Shapes(shapes(&cut, size))).or(wanted);
        }
        wanted
    }

    fn bar(&mut self, ui: &mut Ui, names: &[String]) -> Option<Wanted> {
        let mut index = self.index;
        let close = ui
            .horizontal_wrapped(|ui| {
                ui.strong("Cut texture patches").on_hover_text("Outlines of texture patches drawn on the exemplar (3.1)");
                if names.len() > 1 {
                    let combo = ComboBox::from_id_salt("cut exemplar").selected_text(names.get(index).map_or("", String::as_str));
                    let choice = combo.show_ui(ui, |ui| {
                        for (i, name) in names.iter().enumerate() {
                            ui.selectable_value(&mut index, i, name);
                        }
                    });
                    choice.response.on_hover_text("Which exemplar patches are cut from; each has its own outlines");
                }
                let snapping = [
                    (Line::Snapped, "Snap", "The line follows the exemplar's edges; hold Shift for a straight one"),
                    (Line::Straight, "Straight", "The line is straight; drag to draw free"),
                ];
                for (line, name, help) in snapping {
                    ui.selectable_value(&mut self.cutter.line, line, name).on_hover_text(help);
                }
                ui.checkbox(&mut self.show_veil, "Alpha").on_hover_text("Darkens what is cut off, with the feather of its edge");
                if ui.button("Fit").on_hover_text("Shows the whole exemplar").clicked() {
                    self.zoom.fit();
                }
                let some = !self.cutter.outlines().is_empty();
                let clear = ui.add_enabled(some, egui::Button::new("Clear"));
                if clear.on_hover_text("Deletes all outlines; patches are automatic again").clicked() {
                    self.cutter.clear();
                }
                ui.button("Done").on_hover_text("Back to the model").clicked()
            })
            .inner;
        let says = match (&self.trouble, self.cutter.drawing(), self.cutter.outlines().len()) {
            (Some(trouble), ..) => trouble.clone(),
            (None, Some((drawn, _)), _) if drawn.anchors.len() < 3 => {
                "Click along the edge of what you want; drag to draw free. Backspace takes a point back".to_owned()
            }
            (None, Some(_), _) => "Click the first point, or press Enter, to close the outline".to_owned(),
            (None, None, 0) => "Click on an edge in the picture to begin an outline".to_owned(),
            (None, None, n) => {
                format!("{n} {}. Drag points; click beside to begin another", if n == 1 { "outline" } else { "outlines" })
            }
        };
        if self.trouble.is_some() {
            ui.colored_label(ui.visuals().error_fg_color, says)
        } else {
            ui.weak(says)
        };
        if index != self.index {
            return Some(Wanted::Exemplar(index));
        }
        close.then_some(Wanted::Close)
    }

    fn take(&mut self, context: &Context) {
        for made in self.edges.take().into_iter().chain(self.veils.take()) {
            match made {
                Made::Picture(picture) => {
                    self.picture = Some(context.load_texture("exemplar to be cut", picture, TextureOptions::NEAREST));
                }
                Made::Edges(edges) => self.cutter.set_edges(Arc::new(edges)),
                Made::Veil(of, _) if of != self.cutter.revision() => {}
                Made::Veil(_, Ok(veil)) => {
                    self.veil = Some(context.load_texture("veil", veil, TextureOptions::LINEAR));
                    self.trouble = None;
                }
                Made::Veil(_, Err(trouble)) => (self.veil, self.trouble) = (None, Some(trouble)),
            }
        }
    }
}

/// The outlines among shapes, in pixels.
fn outlines(shapes: &[Shape], size: [u32; 2]) -> Vec<Outline> {
    let size = Vec2::new(size[0] as f32, size[1] as f32);
    let outline = |shape: &Shape| match shape {
        Shape::Outline(points) => Some(Outline { points: points.iter().map(|&p| Vec2::from(p) * size).collect() }),
        _ => None,
    };
    shapes.iter().filter_map(outline).collect()
}

/// Outlines as shapes of a project: fractions of the exemplar's size.
fn shapes(outlines: &[Outline], size: [u32; 2]) -> Vec<Shape> {
    let size = Vec2::new(size[0] as f32, size[1] as f32);
    let fraction = |p: &Vec2| (*p / size).clamp(Vec2::ZERO, Vec2::ONE).to_array();
    outlines.iter().map(|o| Shape::Outline(o.points.iter().map(fraction).collect())).collect()
}
