//! Where the bytes of glTF buffers and images come from: the GLB itself, data URIs, and files beside the document.

use super::accessor::Data;
use super::document::Document;
use crate::format::error::Problem;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use base64::{Engine, alphabet};
use std::borrow::Cow;
use std::path::Path;

/// The bytes of every buffer, at least as long as declared. `folder` is where file names start.
pub(crate) fn load_buffers<'a>(
    document: &Document,
    bin: Option<&'a [u8]>,
    folder: Option<&Path>,
) -> Result<Vec<Cow<'a, [u8]>>, Problem> {
    let mut all = Vec::with_capacity(document.buffers.len());
    for (k, buffer) in document.buffers.iter().enumerate() {
        let place = format!("buffer {k}");
        let bytes = match &buffer.uri {
            None if k == 0 => Cow::Borrowed(bin.ok_or_else(|| Problem::damaged(&place, "its data is missing"))?),
            None => return Err(Problem::damaged(place, "it names no file and is not the GLB's own")),
            Some(uri) => match uri.strip_prefix("data:") {
                Some(data) => Cow::Owned(decode_data(data).ok_or_else(|| Problem::damaged(&place, "its data URI is damaged"))?),
                None => Cow::Owned(read_beside(uri, folder, &place)?),
            },
        };
        if (bytes.len() as u64) < buffer.byte_length {
            let what = format!("{} bytes are declared, but there are only {}", buffer.byte_length, bytes.len());
            return Err(Problem::damaged(place, what));
        }
        all.push(bytes);
    }
    Ok(all)
}

/// The bytes of a texture's image file.
pub(crate) fn load_image<'a>(data: &Data<'a>, texture: usize, folder: Option<&Path>) -> Result<Cow<'a, [u8]>, Problem> {
    let place = format!("texture {texture}");
    let image = data.document.textures.get(texture).and_then(|t| t.source).and_then(|s| data.document.images.get(s));
    let image = image.ok_or_else(|| Problem::damaged(&place, "it has no image"))?;
    match (&image.buffer_view, &image.uri) {
        (Some(view), _) => Ok(Cow::Borrowed(data.view(*view)?)),
        (None, Some(uri)) => match uri.strip_prefix("data:") {
            Some(bytes) => decode_data(bytes).map(Cow::Owned).ok_or_else(|| Problem::damaged(&place, "its data URI is damaged")),
            None => Ok(Cow::Owned(read_beside(uri, folder, &place)?)),
        },
        (None, None) => Err(Problem::damaged(place, "its image has no data")),
    }
}

fn read_beside(uri: &str, folder: Option<&Path>, place: &str) -> Result<Vec<u8>, Problem> {
    let name = percent_decode(uri);
    // A document may name files beside and beneath it, not anything on the machine or the network.
    if name.contains("://") || Path::new(&name).is_absolute() {
        let what = format!("it lies at {uri:?}, and only files beside the document are read");
        return Err(Problem::new(place, what, "export as GLB, or keep the buffers beside the document"));
    }
    let Some(folder) = folder else {
        let what = format!("it lies in the file {name:?}, which cannot be found from here");
        return Err(Problem::new(place, what, "export as GLB"));
    };
    let file = folder.join(&name);
    std::fs::read(&file).map_err(|e| {
        let what = format!("its file {} cannot be read: {e}", file.display());
        Problem::new(place, what, "put the file beside the document, or export as GLB")
    })
}

/// What a data URI holds, given all of it after `data:`.
fn decode_data(uri: &str) -> Option<Vec<u8>> {
    let (kind, data) = uri.split_once(',')?;
    if kind.ends_with(";base64") { decode_base64(data.as_bytes()) } else { Some(percent_decode(data).into_bytes()) }
}

/// `%20` and its like as characters; anything malformed stays as it is.
fn percent_decode(text: &str) -> String {
    percent_encoding::percent_decode_str(text).decode_utf8().map_or_else(|_| text.to_owned(), Cow::into_owned)
}

/// Base64 in its usual or its URL alphabet; blanks and padding are skipped, bits that are left over too.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    let usual = |&c: &u8| match c {
        b'=' | b' ' | b'\n' | b'\r' => None,
        b'-' => Some(b'+'),
        b'_' => Some(b'/'),
        c => Some(c),
    };
    let lenient =
        GeneralPurposeConfig::new().with_decode_allow_trailing_bits(true).with_decode_padding_mode(DecodePaddingMode::RequireNone);
    let plain: Vec<u8> = text.iter().filter_map(usual).collect();
    GeneralPurpose::new(&alphabet::STANDARD, lenient).decode(plain).ok()
}

#[cfg(test)]
mod tests {
    use super::{decode_base64, percent_decode};

    #[test]
    fn base64_of_every_length_decodes() {
        for (text, plain) in
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg", "foob"), ("Zm9v\nYmFy", "foobar")]
        {
            assert_eq!(decode_base64(text.as_bytes()).as_deref(), Some(plain.as_bytes()), "{text:?} (RFC 4648 test vector)");
        }
        assert_eq!(decode_base64(b"Zm9v!"), None, "a character outside the alphabet");
    }

    #[test]
    fn percent_signs_decode_or_stay() {
        assert_eq!(percent_decode("a%20b%2Fc"), "a b/c", "escaped characters");
        assert_eq!(percent_decode("100%"), "100%", "a lone percent sign");
    }
}
