//! Bytes within a page: pictures as data URIs, JSON within a script.

use crate::render::Picture;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;

/// Quality of the pictures within pages; beside them they lie without loss.
const QUALITY: u8 = 90;

/// A picture as a data URI: JPEG, or PNG where that fails.
#[must_use]
pub fn data_uri(picture: &Picture) -> String {
    let rgb: Vec<u8> = picture.rgba.as_chunks::<4>().0.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let mut jpeg = Vec::new();
    let done = JpegEncoder::new_with_quality(&mut jpeg, QUALITY).encode(
        &rgb,
        picture.width,
        picture.height,
        image::ExtendedColorType::Rgb8,
    );
    match done {
        Ok(()) => format!("data:image/jpeg;base64,{}", STANDARD.encode(&jpeg)),
        Err(_) => png_uri(&picture.png().unwrap_or_default()),
    }
}

/// A PNG file as a data URI.
#[must_use]
pub fn png_uri(file: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(file))
}

/// A page: the template with its style, its script and its data in it.
#[must_use]
pub fn page(template: &str, title: &str, styles: &[&str], scripts: &[&str], data: &serde_json::Value) -> String {
    // Nothing in the data may end the script it is in.
    let data = data.to_string().replace("</", "<\\/").replace("<!--", "<\\!--");
    let title = title.replace('&', "&amp;").replace('<', "&lt;");
    let mut out = String::with_capacity(data.len() + template.len() + 40_000);
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        out.push_str(before);
        let Some((name, after)) = after.split_once("}}") else { break };
        match name {
            "title" => out.push_str(&title),
            "style" => styles.iter().for_each(|s| out.push_str(s)),
            "script" => scripts.iter().for_each(|s| out.push_str(s)),
            "data" => out.push_str(&data),
            _ => {}
        }
        rest = after;
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_cannot_end_its_script_nor_a_title_its_tag() {
        let data = serde_json::json!({"name": "</script><script>alert(1)</script>"});
        let made = page("<title>{{title}}</title><script>{{data}}</script>", "a<b & c", &[], &[], &data);
        assert_eq!(made.matches("</script>").count(), 1, "{made}");
        assert!(made.contains("a&lt;b &amp; c"), "{made}");
        let (_, rest) = made.split_once("<script>").expect("a script");
        let back: serde_json::Value = serde_json::from_str(rest.trim_end_matches("</script>")).expect("JSON still");
        assert_eq!(back, data, "and reads as it was");
    }
}
