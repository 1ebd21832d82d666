//! What a URI in a document means: bytes in the URI itself, or a file beside it.
//!
//! Sources: Berners-Lee et al., *Uniform Resource Identifier*, RFC 3986, 2005;
//! Masinter, *The "data" URL scheme*, RFC 2397, 1998; Josefsson, *The Base16,
//! Base32, and Base64 Data Encodings*, RFC 4648, 2006.

use crate::shown::shown;
use std::borrow::Cow;

/// What a URI stands for.
#[derive(Debug, PartialEq)]
pub(super) enum Meant<'u> {
    /// Bytes, and their media type in small letters, which may be empty.
    Bytes(Vec<u8>, String),
    /// The name of a file, as written.
    File(&'u str),
}

/// Understands a URI, or says what is wrong with it.
pub(super) fn understand(uri: &str) -> Result<Meant<'_>, String> {
    let Some(scheme) = scheme(uri) else { return Ok(Meant::File(uri)) };
    if !scheme.eq_ignore_ascii_case("data") {
        let uri = shown(uri);
        return Err(format!(
            "names \"{uri}\", but only files beside the scene and data: URIs are read"
        ));
    }
    let rest = &uri[scheme.len() + 1..];
    let Some((head, body)) = rest.split_once(',') else {
        return Err("is a data: URI without a comma".to_owned());
    };
    let mut parameters = head.split(';');
    let media = parameters.next().unwrap_or_default().trim().to_ascii_lowercase();
    let is_base64 = parameters.any(|word| word.trim().eq_ignore_ascii_case("base64"));
    let bytes = match is_base64 {
        true if body.contains('%') => base64(&unescape(body))?,
        true => base64(body.as_bytes())?,
        false => unescape(body).into_owned(),
    };
    Ok(Meant::Bytes(bytes, media))
}

/// The scheme before the first colon. One letter is none: it is a disk's.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let is_word = |b: u8| b.is_ascii_alphanumeric() || b"+-.".contains(&b);
    let begins_right = scheme.as_bytes().first().is_some_and(u8::is_ascii_alphabetic);
    (begins_right && scheme.len() > 1 && scheme.bytes().all(is_word)).then_some(scheme)
}

/// A text with %41 written as A. What is no such code stays as it is.
fn unescape(text: &str) -> Cow<'_, [u8]> {
    if !text.contains('%') {
        return Cow::Borrowed(text.as_bytes());
    }
    let digit = |byte: Option<&u8>| char::from(*byte?).to_digit(16);
    let bytes = text.as_bytes();
    let mut plain = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        match (byte, digit(bytes.get(at + 1)), digit(bytes.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                plain.push((16 * high + low) as u8);
                at += 3;
            }
            _ => {
                plain.push(byte);
                at += 1;
            }
        }
    }
    Cow::Owned(plain)
}

/// The name of a file without escapes; `None` where that is no text.
pub(super) fn file_name(uri: &str) -> Option<Cow<'_, str>> {
    match unescape(uri) {
        Cow::Borrowed(_) => Some(Cow::Borrowed(uri)),
        Cow::Owned(bytes) => String::from_utf8(bytes).ok().map(Cow::Owned),
    }
}

/// Bytes of base64. Blanks and line ends count for nothing, and padding may be missing.
fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut held, mut padding) = (0_u32, 0_u32, 0_u32);
    for (i, &letter) in text.iter().enumerate() {
        let six = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b' ' | b'\t' | b'\r' | b'\n' => continue,
            b'=' => {
                padding += 1;
                continue;
            }
            _ => {
                let letter = crate::shown::quoted(&[letter]);
                return Err(format!("is no base64: its data have {letter} at byte {i}"));
            }
        };
        if padding > 0 {
            return Err(format!("is no base64: its data go on behind \"=\" at byte {i}"));
        }
        bits = bits << 6 | u32::from(six);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
        }
    }
    // One letter alone makes no byte.
    if held == 6 || padding > 2 {
        return Err("is no base64: its data are cut off".to_owned());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 4648, section 10, with and without their padding.
    #[test]
    fn base64_is_that_of_its_standard() {
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            let bytes = plain.as_bytes().to_vec();
            assert_eq!(base64(coded.as_bytes()), Ok(bytes.clone()), "{coded}");
            assert_eq!(base64(coded.trim_end_matches('=').as_bytes()), Ok(bytes), "{coded}");
        }
        assert_eq!(base64(b"+/ +/\n"), Ok(vec![0xfb, 0xff, 0xbf]));
        for bad in ["Z", "Zm9vY", "Zg==Zg", "Z-==", "====", "Zm9v\u{e9}"] {
            assert!(base64(bad.as_bytes()).is_err(), "{bad}");
        }
    }

    /// Escapes in names and data, media types, and what is no file.
    #[test]
    fn uris_are_understood() {
        let bytes = |bytes: &[u8], media: &str| Ok(Meant::Bytes(bytes.to_vec(), media.to_owned()));
        assert_eq!(understand("data:;base64,Zm9v"), bytes(b"foo", ""));
        assert_eq!(understand("DATA:Image/PNG;x=1;Base64,Zm9v"), bytes(b"foo", "image/png"));
        assert_eq!(understand("data:,a%20b%"), bytes(b"a b%", ""));
        assert_eq!(understand("data:;base64,Zg%3D%3d"), bytes(b"f", ""));
        assert_eq!(understand("a b.bin"), Ok(Meant::File("a b.bin")));
        assert_eq!(understand("C:a.bin"), Ok(Meant::File("C:a.bin")));
        for bad in ["http://a/b.bin", "file:///etc/passwd", "data:base64", "data:;base64,?"] {
            assert!(understand(bad).is_err(), "{bad}");
        }
        assert_eq!(file_name("a%20%C3%A9.bin").as_deref(), Some("a é.bin"));
        assert_eq!(file_name("100%.bin").as_deref(), Some("100%.bin"));
        assert_eq!(file_name("%ff.bin"), None);
    }
}
