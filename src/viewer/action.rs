//! Deeds: what menus, keys and buttons ask for, each with its name, its keys and what it does in words.

use egui::{Key, KeyboardShortcut, Modifiers};

/// A deed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "`Action::facts` says what each is")]
pub enum Action {
    New,
    Open,
    Save,
    SaveAs,
    ExportPicture,
    ExportRecord,
    ExportBaked,
    ExportSynthesis,
    Quit,
    Undo,
    Redo,
    Frame,
    Turntable,
    Play,
    Split,
    NextMode,
    Compare,
    Comb,
    Cut,
    Watch,
    Arrows,
    Streamlines,
    Singularities,
    Edges,
    Reload,
    Stop,
    Theme,
    Gallery,
    Figures,
    Help,
}

const COMMAND: Modifiers = Modifiers::COMMAND;
const COMMAND_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

impl Action {
    /// All deeds, in the order of the help sheet.
    pub const ALL: [Self; 30] = [
        Self::New,
        Self::Open,
        Self::Save,
        Self::SaveAs,
        Self::ExportPicture,
        Self::ExportRecord,
        Self::ExportBaked,
        Self::ExportSynthesis,
        Self::Undo,
        Self::Redo,
        Self::Frame,
        Self::Turntable,
        Self::Play,
        Self::Split,
        Self::NextMode,
        Self::Compare,
        Self::Comb,
        Self::Cut,
        Self::Watch,
        Self::Arrows,
        Self::Streamlines,
        Self::Singularities,
        Self::Edges,
        Self::Reload,
        Self::Stop,
        Self::Gallery,
        Self::Figures,
        Self::Theme,
        Self::Help,
        Self::Quit,
    ];

    /// Its name, its key if it has one, and what it does.
    #[must_use]
    pub const fn facts(self) -> (&'static str, Option<KeyboardShortcut>, &'static str) {
        const fn key(modifiers: Modifiers, key: Key) -> Option<KeyboardShortcut> {
            Some(KeyboardShortcut::new(modifiers, key))
        }
        const NONE: Modifiers = Modifiers::NONE;
        match self {
            Self::New => ("New", key(COMMAND, Key::N), "Begin an empty project"),
            Self::Open => ("Open...", key(COMMAND, Key::O), "Open a mesh, an exemplar image, a record or a project"),
            Self::Save => {
                ("Save project", key(COMMAND, Key::S), "Save everything chosen here in one file that opens again as it was")
            }
            Self::SaveAs => ("Save project as...", key(COMMAND_SHIFT, Key::S), "Save under another name"),
            Self::ExportPicture => {
                ("Export picture...", key(COMMAND, Key::P), "Write this view as a PNG, drawn by the reference renderer")
            }
            Self::ExportRecord => ("Export record...", key(COMMAND, Key::E), "Write the model with its pastes as a GLB"),
            Self::ExportBaked => (
                "Export baked model...",
                key(COMMAND_SHIFT, Key::E),
                "Bake the texture into an atlas and write a GLB that any tool shows",
            ),
            Self::ExportSynthesis => {
                ("Export synthesis...", None, "Write the synthesised mesh that is shown, a colour at each vertex, as GLB or PLY")
            }
            Self::Quit => ("Quit", key(COMMAND, Key::Q), "Close the window"),
            Self::Undo => ("Undo", key(COMMAND, Key::Z), "Take the last change back"),
            Self::Redo => ("Redo", key(COMMAND_SHIFT, Key::Z), "Make the change again"),
            Self::Frame => ("Frame", key(NONE, Key::F), "Show all of the model"),
            Self::Turntable => ("Turntable", key(NONE, Key::T), "Let the model go around"),
            Self::Play => ("Play", key(NONE, Key::K), "Let exemplars change that go by time"),
            Self::Split => ("Split view", key(NONE, Key::V), "Compare two modes; drag the line between them"),
            Self::NextMode => ("Next mode", key(NONE, Key::M), "Show the next mode in the left pane"),
            Self::Compare => (
                "Compare with synthesis",
                key(NONE, Key::Y),
                "Show the pasted texture and, beside it, the exemplar synthesised over the same model",
            ),
            Self::Comb => ("Comb", key(NONE, Key::C), "Drag over the model to set which way the texture lies"),
            Self::Cut => ("Cut patches", key(NONE, Key::X), "Draw outlines of texture patches on the exemplar"),
            Self::Watch => ("Watch", key(NONE, Key::O), "See pastes laid one by one, and how one of them grows"),
            Self::Arrows => {
                ("Field arrows", key(NONE, Key::A), "Arrows where texture up points; longer ones mean a larger texture")
            }
            Self::Streamlines => ("Streamlines", key(NONE, Key::S), "Lines along the tangent field"),
            Self::Singularities => {
                ("Singularities", key(NONE, Key::P), "Points around which the field turns: poles red, saddles orange")
            }
            Self::Edges => {
                ("Mesh edges", key(NONE, Key::W), "The edges of the faces that are pasted on, where they are no more than 300 000")
            }
            Self::Reload => ("Reload files", key(COMMAND, Key::R), "Read model and exemplars again"),
            Self::Stop => ("Stop", key(NONE, Key::Escape), "Stop the work that goes on"),
            Self::Theme => ("Light or dark", key(NONE, Key::L), "Change between the light and the dark theme"),
            Self::Gallery => ("Gallery", key(NONE, Key::G), "Built-in models and exemplars"),
            Self::Figures => ("Figures", key(NONE, Key::I), "Pastes, draws per face, times and memory"),
            Self::Help => ("Help", key(NONE, Key::F1), "Keys and the mouse"),
        }
    }

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.facts().0
    }

    /// The deed whose keys were pressed; they are used up. With `typing`, keys without Ctrl go to the text instead.
    pub fn pressed(input: &mut egui::InputState, typing: bool) -> Option<Self> {
        // Keys with more modifiers first: Ctrl+Shift+S is not Ctrl+S.
        let mut ordered = Self::ALL;
        ordered.sort_by_key(|a| a.facts().1.map_or(0, |s| -i32::from(s.modifiers.shift)));
        ordered.into_iter().find(|action| {
            let Some(shortcut) = action.facts().1 else { return false };
            let plain = shortcut.modifiers.is_none() && shortcut.logical_key != Key::F1;
            !(typing && plain) && input.consume_shortcut(&shortcut)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things_and_every_deed_says_what_it_does() {
        for (i, a) in Action::ALL.iter().enumerate() {
            assert!(!a.facts().2.is_empty(), "{a:?} says nothing");
            for b in &Action::ALL[i + 1..] {
                assert!(a.facts().1.is_none() || a.facts().1 != b.facts().1, "{a:?} and {b:?} have one key");
            }
        }
    }
}
