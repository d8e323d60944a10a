//! What a command says, to compare it as a whole where its figures are the model's or a clock's.

/// The text's lines, those of a row that are alike once, with `#` for every number and one blank for several.
pub fn words(text: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(without_numbers).collect();
    lines.dedup();
    lines.join("\n")
}

fn without_numbers(line: &str) -> String {
    let letters: Vec<char> = line.chars().collect();
    let is_digit = |at: usize| letters.get(at).is_some_and(char::is_ascii_digit);
    let (mut words, mut at) = (String::new(), 0);
    while let Some(&letter) = letters.get(at) {
        let after_blank = words.is_empty() || words.ends_with(' ');
        if is_digit(at) {
            while is_digit(at) || (letters.get(at) == Some(&'.') && is_digit(at + 1)) {
                at += 1;
            }
            words.push('#');
            continue;
        }
        at += 1;
        let is_sign = matches!(letter, '-' | '+' | '−') && is_digit(at);
        if !(after_blank && (letter == ' ' || is_sign)) {
            words.push(letter);
        }
    }
    words
}
