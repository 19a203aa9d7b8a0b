//! What the name of a texture file says: which material set it belongs to, and which channel it holds.
//!
//! Covers the habits of ambientCG (`Bricks097_2K-JPG_NormalGL.jpg`), Poly Haven (`rock_wall_nor_gl_2k.png`), Quixel
//! (`xyz_4K_Albedo.jpg`) and plain names (`bark_color.jpg`). The last word that names a channel counts, so that
//! `metal_plate_diff.png` is a colour and `rough_wood_nor_gl.png` a normal map.

use super::NormalConvention;
use crate::exemplar::Channel;

/// What an image file is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    /// A channel as it is.
    Channel(Channel),
    /// The opposite of roughness.
    Gloss,
    /// Occlusion, roughness and metallic in red, green and blue.
    Packed,
}

/// A name taken apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Name {
    /// Words that name the material set.
    pub(crate) set: String,
    /// Words for size (`2k`), which may differ within a set.
    pub(crate) variant: String,
    /// What the file is for, if the name says it.
    pub(crate) role: Option<Role>,
    /// Convention of a normal map, if the name says it.
    pub(crate) convention: Option<NormalConvention>,
}

/// Takes a file's stem apart.
pub(crate) fn parse(stem: &str) -> Name {
    let words = split(stem);
    let found = (0..words.len()).rev().find_map(|k| role(&words, k).map(|(role, first)| (role, first, k)));
    let mut name = Name { set: String::new(), variant: String::new(), role: found.map(|f| f.0), convention: None };
    let used = found.map_or(0..0, |(_, first, last)| first..last + 1);
    for (k, word) in words.iter().enumerate() {
        let word = word.as_str();
        if used.contains(&k) {
            name.convention = name.convention.or_else(|| convention(word));
        } else if used.end == k && k > 0 && name.role == Some(Role::Channel(Channel::Normal)) && convention(word).is_some() {
            name.convention = convention(word);
        } else if is_size(word) {
            join(&mut name.variant, word);
        } else if !is_file_type(word) {
            join(&mut name.set, word);
        }
    }
    name
}

fn join(words: &mut String, word: &str) {
    if !words.is_empty() {
        words.push(' ');
    }
    words.push_str(word);
}

/// Words in lower case: parted by anything that is no letter or digit, and where a capital follows a small letter.
fn split(stem: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in stem.chars() {
        if !c.is_alphanumeric() || (c.is_uppercase() && before.is_lowercase()) {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            let word = words.pop().unwrap_or_default();
            words.push(word + &c.to_lowercase().to_string());
        }
        before = c;
    }
    words.retain(|w| !w.is_empty());
    words
}

/// The role that ends at word `k`, and the first word of its name (`base color`, `ambient occlusion`, `normal gl`).
fn role(words: &[String], k: usize) -> Option<(Role, usize)> {
    let word = words[k].as_str();
    let before = k.checked_sub(1).map_or("", |b| words[b].as_str());
    let channel = match word {
        "color" | "colour" | "col" | "basecolor" | "basecolour" | "albedo" | "alb" | "diffuse" | "diff" => Channel::BaseColor,
        "normal" | "normals" | "nor" | "nrm" | "norm" | "normalgl" | "normaldx" | "normalogl" => Channel::Normal,
        "height" | "heightmap" | "displacement" | "disp" | "bump" => Channel::Height,
        "roughness" | "rough" | "rgh" => Channel::Roughness,
        "metallic" | "metalness" | "metal" | "met" => Channel::Metallic,
        "ao" | "occlusion" | "ambientocclusion" | "occ" => Channel::Occlusion,
        "emissive" | "emission" | "emit" | "glow" => Channel::Emissive,
        "opacity" | "alpha" => Channel::Opacity,
        "gloss" | "glossiness" | "smoothness" => return Some((Role::Gloss, k)),
        "arm" | "orm" => return Some((Role::Packed, k)),
        _ => return None,
    };
    let two_words = matches!((before, channel), ("base", Channel::BaseColor) | ("ambient", Channel::Occlusion));
    let first = if two_words { k - 1 } else { k };
    let first = if channel == Channel::Normal && matches!(before, "gl" | "dx" | "opengl" | "directx") { k - 1 } else { first };
    Some((Role::Channel(channel), first))
}

fn convention(word: &str) -> Option<NormalConvention> {
    match word {
        "gl" | "ogl" | "opengl" | "normalgl" | "normalogl" => Some(NormalConvention::OpenGl),
        "dx" | "directx" | "normaldx" => Some(NormalConvention::DirectX),
        _ => None,
    }
}

fn is_size(word: &str) -> bool {
    let digits = word.strip_suffix('k').unwrap_or(word);
    let number = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    number && (digits.len() < word.len() || ["256", "512", "1024", "2048", "4096", "8192"].contains(&word))
}

fn is_file_type(word: &str) -> bool {
    ["jpg", "jpeg", "png", "exr", "tif", "tiff", "tga", "webp", "bmp", "hdr"].contains(&word)
}

#[cfg(test)]
mod tests {
    use super::{Channel, NormalConvention, Role, parse};

    #[test]
    fn the_habits_of_the_big_libraries_are_understood() {
        let gl = Some(NormalConvention::OpenGl);
        let dx = Some(NormalConvention::DirectX);
        let channel = |c| Some(Role::Channel(c));
        for (stem, set, variant, role, convention) in [
            ("Bricks097_2K-JPG_Color", "bricks097", "2k", channel(Channel::BaseColor), None),
            ("Bricks097_2K-JPG_NormalGL", "bricks097", "2k", channel(Channel::Normal), gl),
            ("Bricks097_2K-JPG_NormalDX", "bricks097", "2k", channel(Channel::Normal), dx),
            ("Bricks097_2K-JPG_AmbientOcclusion", "bricks097", "2k", channel(Channel::Occlusion), None),
            ("Bricks097_2K-JPG_Displacement", "bricks097", "2k", channel(Channel::Height), None),
            ("rock_wall_02_nor_gl_4k", "rock wall 02", "4k", channel(Channel::Normal), gl),
            ("rock_wall_02_nor_dx_4k", "rock wall 02", "4k", channel(Channel::Normal), dx),
            ("rock_wall_02_diff_4k", "rock wall 02", "4k", channel(Channel::BaseColor), None),
            ("rock_wall_02_arm_4k", "rock wall 02", "4k", Some(Role::Packed), None),
            ("uh4obesaw_4K_Albedo", "uh4obesaw", "4k", channel(Channel::BaseColor), None),
            ("uh4obesaw_4K_Gloss", "uh4obesaw", "4k", Some(Role::Gloss), None),
            ("T_Metal_Plate_BaseColor", "t metal plate", "", channel(Channel::BaseColor), None),
            ("Metal_Plate_Base_Color_2048", "metal plate", "2048", channel(Channel::BaseColor), None),
            ("rough_wood_roughness", "rough wood", "", channel(Channel::Roughness), None),
            ("bark_color", "bark", "", channel(Channel::BaseColor), None),
            ("bricks-pbr_height", "bricks pbr", "", channel(Channel::Height), None),
            ("normal", "", "", channel(Channel::Normal), None),
            ("holiday photo 17", "holiday photo 17", "", None, None),
        ] {
            let name = parse(stem);
            assert_eq!((name.set.as_str(), name.variant.as_str()), (set, variant), "set and variant of {stem}");
            assert_eq!((name.role, name.convention), (role, convention), "role and convention of {stem}");
        }
    }
}
