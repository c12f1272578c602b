//! Numbers in code.

/// The floating-point numbers of a line of code.
pub(super) fn floats(line: &str) -> Vec<f64> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let bytes: Vec<char> = line.chars().collect();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let starts = bytes[at].is_ascii_digit()
            && (at == 0 || !(is_word(bytes[at - 1]) || bytes[at - 1] == '.'));
        if !starts {
            at += 1;
            continue;
        }
        let start = at;
        let digit = |at: usize| bytes.get(at).is_some_and(char::is_ascii_digit);
        while at < bytes.len()
            && (is_word(bytes[at])
                || bytes[at] == '.' && digit(at + 1)
                || bytes[at] == '-' && bytes[at - 1] == 'e' && digit(at + 1))
        {
            at += 1;
        }
        let text: String = bytes[start..at].iter().filter(|c| **c != '_').collect();
        let text = text.trim_end_matches("f64").trim_end_matches("f32");
        if text.contains(['.', 'e']) && !text.starts_with("0x") {
            found.push(text.parse().unwrap_or_else(|_| panic!("{line}: {text}")));
        }
    }
    found
}

#[test]
fn floats_are_found_in_code() {
    assert_eq!(
        floats("x.0 * 1.5 + (0..3).len() as f64 * 1e-6 - t2.max(2.0_f64)"),
        [1.5, 1e-6, 2.0]
    );
    assert!(floats("u32 << 14, 0xffe, self.1.0, 8u64").is_empty());
}
