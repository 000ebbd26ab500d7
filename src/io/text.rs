//! What the readers of text formats share: numbered lines, words, numbers.

/// Longest piece of a file that an error message repeats, in characters.
const LONGEST_QUOTE: usize = 40;

/// The lines of a text with their numbers from 1. Lines end with LF, CR LF, or CR alone as on
/// old Macs.
pub(super) fn lines(bytes: &[u8]) -> Lines<'_> {
    Lines { rest: bytes, number: 0 }
}

pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let is_end = |byte: &u8| matches!(byte, b'\n' | b'\r');
        let length = self.rest.iter().position(is_end).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(length);
        self.rest = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..)).unwrap_or_default();
        Some((self.number, line))
    }
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The line without a comment that begins with `#`.
pub(super) fn without_comment(line: &[u8]) -> &[u8] {
    line.split(|byte| *byte == b'#').next().unwrap_or_default()
}

/// A piece of a file as it may stand in an error message.
pub(super) fn quote(piece: &[u8]) -> String {
    let text = String::from_utf8_lossy(piece);
    let text = text.trim();
    let mut quoted: String = text
        .chars()
        .take(LONGEST_QUOTE)
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    if text.chars().nth(LONGEST_QUOTE).is_some() {
        quoted.push('…');
    }
    format!("`{quoted}`")
}

/// The text as a name: trimmed, and readable even where it is not UTF-8.
pub(super) fn name(text: &[u8]) -> String {
    String::from_utf8_lossy(text).trim().to_owned()
}

/// A number of any of Rust's types; for `f64` also `nan` and `inf`.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Result<T, String> {
    std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse().ok())
        .ok_or_else(|| format!("{} is not a number that can stand here", quote(word)))
}

/// Three coordinates; words after them are ignored.
pub(super) fn coordinates<'a>(words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], String> {
    let mut coordinates = [0.0; 3];
    let mut found = 0;
    for (coordinate, word) in coordinates.iter_mut().zip(words) {
        *coordinate = number(word)?;
        found += 1;
    }
    if found < 3 {
        return Err(format!("a vertex needs three coordinates, here are {found}"));
    }
    Ok(coordinates)
}

/// Puts the line's number before the reason.
pub(super) fn at_line(line: usize) -> impl Fn(String) -> String {
    move |reason| format!("line {line}: {reason}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_line_endings_count_once() {
        let found: Vec<_> = lines(b"a\nb\r\nc\rd\n\ne").collect();
        let expected: Vec<(usize, &[u8])> =
            vec![(1, b"a"), (2, b"b"), (3, b"c"), (4, b"d"), (5, b""), (6, b"e")];
        assert_eq!(found, expected);
    }

    #[test]
    fn numbers_keep_all_digits_of_a_double() {
        assert_eq!(number::<f64>(b"0.1234567890123456789"), Ok(0.12345678901234568));
        assert!(number::<f64>(b"-nan").is_ok_and(f64::is_nan));
    }

    #[test]
    fn a_long_or_binary_word_is_quoted_in_short() {
        let error = number::<f64>(&[0xff; 1000]).unwrap_err();
        assert!(error.chars().count() < 100, "{error}");
        assert!(!quote(b"a\nb\0c").contains(['\n', '\0']));
    }
}
