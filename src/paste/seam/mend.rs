//! Holes that cuts left: samples that nothing covers any more.
//!
//! Cuts look at what lies below through a grid over their mask, coarser than coverage: a face that touches none of its neighbours, or a
//! sliver between two borders, may lie between its cells. So coverage has the last word. Taking a cut back uncovers nothing else.

use super::super::cut::Cut;
use super::super::lapped::{FaceLists, LappedTexture};
use super::super::order::Seen;
use crate::exemplar::CoverageMask;
use crate::mesh::{Mesh, SurfacePoint};
use glam::Vec2;

/// Cuts are taken back so far around a hole, pixels of the mask: a sample's cell and what coverage looks around it.
const AROUND: f32 = 4.0;

/// What can be seen of each paste, once cuts are taken back where they left holes; and how many pastes are whole again by that. `lists`
/// are those of the pastes, `pitch` is the width of a coverage cell by face, and with `occluded` off pastes hide nothing.
#[must_use]
pub fn see_without_holes(
    mesh: &Mesh,
    lapped: &mut LappedTexture,
    lists: &FaceLists,
    masks: &[CoverageMask],
    pitch: &(impl Fn(u32) -> f64 + Sync),
    occluded: bool,
) -> (Seen, usize) {
    let mut seen = Seen::new(&lapped.pastes);
    let mut faces: Vec<u32> = (0..mesh.face_count() as u32).collect();
    let mut whole = 0;
    loop {
        seen.look(mesh, lapped, lists, masks, pitch, occluded, &faces);
        // What was cut away and is shown again must be looked at again, until no cut is left that could be blamed.
        let (now_whole, mended) = mend_holes(lapped, lists, masks, &seen.holes);
        whole += now_whole;
        if mended.is_empty() {
            return (seen, whole);
        }
        faces = mended;
    }
}

/// Takes cuts back around samples that are not covered with them. Returns how many pastes are whole again, and the faces of all that
/// were mended, in order.
fn mend_holes(lapped: &mut LappedTexture, lists: &FaceLists, masks: &[CoverageMask], holes: &[SurfacePoint]) -> (usize, Vec<u32>) {
    let mut mended = vec![false; lapped.pastes.len()];
    for hole in holes {
        for &(number, slot) in lists.of(hole.face) {
            let paste = &mut lapped.pastes[number as usize];
            let [a, b, c] = paste.uv[slot as usize];
            let uv = a * hole.bary.x + b * hole.bary.y + c * hole.bary.z;
            let mask = &masks[paste.patch as usize];
            let size = Vec2::from(mask.size().map(|s| s as f32));
            // The middle of the cell may lie off the mask where the cell does not.
            let reaches = mask.touches(uv * size, AROUND);
            if let Some(cut) = paste.cut.as_mut().filter(|_| reaches) {
                mended[number as usize] |= cut.mend(uv, AROUND / size.min_element());
            }
        }
    }
    let mut whole = 0;
    let mut faces = Vec::new();
    for (paste, _) in lapped.pastes.iter_mut().zip(mended).filter(|(_, mended)| *mended) {
        faces.extend_from_slice(&paste.faces);
        if paste.cut.as_deref().is_some_and(Cut::is_whole) {
            paste.cut = None;
            whole += 1;
        }
    }
    faces.sort_unstable();
    faces.dedup();
    (whole, faces)
}
