//! Text layers (.usda) in a form that the crate reads.
//!
//! The crate's parser refuses asset paths among time samples, as every sequence of VDB files has them. They are
//! made strings here; [`Reader::assets`](super::values::Reader::assets) takes both.

use std::borrow::Cow;

/// Deepest nesting of brackets: the parser calls itself for each.
const MAX_DEPTH: usize = 256;

/// Beginning of text layers.
const MAGIC: &[u8] = b"#usda";

/// Whether `bytes` begin like a text layer.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// `text` with the asset paths among its time samples as strings.
///
/// # Errors
/// Where brackets are nested too deeply, or a path has a brace without its partner, which makes the crate look for its
/// prim without end.
pub(super) fn readable(text: &str) -> Result<Cow<'_, str>, String> {
    let bytes = text.as_bytes();
    let (mut out, mut copied) = (String::new(), 0);
    let (mut at, mut depth, mut samples) = (0, 0_usize, None);
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'#' => at += text[at..].find('\n').unwrap_or(bytes.len() - at),
            b'"' | b'\'' => at = end_of_quoted(text, at),
            b'@' => {
                let end = end_of_quoted(text, at);
                let quoted = &text[at..end];
                let is_whole = quoted.len() > 1 && quoted.ends_with('@');
                if samples == Some(depth) && is_whole && !quoted.starts_with("@@") {
                    let path = quoted.trim_matches('@');
                    let quote = if path.contains('"') { '\'' } else { '"' };
                    out += &text[copied..at];
                    out.push(quote);
                    out += path;
                    out.push(quote);
                    copied = end;
                }
                at = end;
                continue;
            }
            b'<' => {
                let end = text[at..].find(['>', '\n']).map_or(text.len(), |end| at + end);
                has_paired_braces(&text[at..end])?;
                at = end;
                continue;
            }
            b'{' | b'[' | b'(' => {
                depth += 1;
                if depth > MAX_DEPTH {
                    return Err(format!("brackets are nested more than {MAX_DEPTH} deep"));
                }
                if *byte == b'{' && begins_samples(&text[..at]) {
                    samples = Some(depth);
                }
            }
            b'}' | b']' | b')' => {
                samples = samples.filter(|begun| *begun != depth);
                depth = depth.saturating_sub(1);
            }
            _ => {}
        }
        at += 1;
    }
    if copied == 0 {
        return Ok(Cow::Borrowed(text));
    }
    out += &text[copied..];
    Ok(Cow::Owned(out))
}

fn has_paired_braces(path: &str) -> Result<(), String> {
    let mut open = 0_i32;
    for c in path.chars().filter(|c| "{}".contains(*c)) {
        open += if c == '{' { 1 } else { -1 };
        if !(0..=1).contains(&open) {
            break;
        }
    }
    if open == 0 {
        Ok(())
    } else {
        Err(format!("the path {path}> has a brace without its partner"))
    }
}

/// Whether a block that follows on `before` holds time samples.
fn begins_samples(before: &str) -> bool {
    let assigned = before.trim_end().strip_suffix('=');
    assigned.is_some_and(|name| name.trim_end().ends_with(".timeSamples"))
}

/// One past the last byte of what is quoted, once or three times, by the character at `start`.
fn end_of_quoted(text: &str, start: usize) -> usize {
    let quote = &text[start..=start];
    let triple = quote.repeat(3);
    let mark = if text[start..].starts_with(&triple) { &triple } else { quote };
    let mut at = start + mark.len();
    while let Some(found) = text[at..].find(mark) {
        let escaped = text[..at + found].ends_with('\\');
        at += found + mark.len();
        if !escaped {
            return at;
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_scalar_assets_among_time_samples_become_strings() {
        let text = "#usda 1.0 # \"{ @\ndef \"a\" {\n asset f = @a.vdb@\n asset f.timeSamples = {\n 1: @b \
            1.vdb@, # @c@\n 2: @d.vdb@ }\n asset[] g.timeSamples = { 1: [@e@, @f@] }\n string s = \"x.timeSamples = \
            { @g@\"\n asset h = @@@i@j@@@ }";
        let made = readable(text).unwrap();
        let right = text.replace("@b 1.vdb@", "\"b 1.vdb\"").replace("@d.vdb@", "\"d.vdb\"");
        assert_eq!(made, right);
        assert!(matches!(readable(&right).unwrap(), Cow::Borrowed(_)));
    }

    #[test]
    fn unfinished_text_ends() {
        for text in ["#usda", "\"", "'''a''", "a.timeSamples = { 1: @b", "@@@a@@", "}}])", "\"\\"] {
            assert_eq!(readable(text).unwrap(), text);
        }
        assert!(readable(&"(".repeat(1000)).unwrap_err().contains("deep"));
        assert!(readable("a = </b}c>").unwrap_err().contains("</b}c>"));
        assert!(readable("a = </b{c=d}e>").is_ok());
    }
}
