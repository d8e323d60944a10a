//! The programs that a line of shell runs.

/// The words of each program in a line, without redirections. Quotation marks hold words together; variables stay as they are written.
pub fn programs(line: &str) -> Vec<Vec<String>> {
    let mut programs = vec![Vec::new()];
    let mut word: Option<String> = None;
    let (mut quote, mut to_file) = (None, false);
    let end = |word: &mut Option<String>, programs: &mut Vec<Vec<String>>, to_file: &mut bool| {
        if let Some(word) = word.take()
            && !std::mem::take(to_file)
        {
            programs.last_mut().expect("there is one").push(word);
        }
    };
    for c in line.chars() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (Some(_), c) => word.get_or_insert_default().push(c),
            (None, '"' | '\'') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '>' | '<') => {
                // `2>file`: the number is no word.
                word = word.filter(|word| !word.chars().all(|c| c.is_ascii_digit()));
                end(&mut word, &mut programs, &mut to_file);
                to_file = true;
            }
            (None, '|' | '&' | ';' | '(' | ')') => {
                end(&mut word, &mut programs, &mut to_file);
                if programs.last().is_some_and(|words| !words.is_empty()) {
                    programs.push(Vec::new());
                }
            }
            (None, '#') if word.is_none() => break,
            (None, c) if c.is_whitespace() => end(&mut word, &mut programs, &mut to_file),
            (None, c) => word.get_or_insert_default().push(c),
        }
    }
    end(&mut word, &mut programs, &mut to_file);
    programs.retain(|words| !words.is_empty());
    programs
}

#[cfg(test)]
mod tests {
    use super::programs;

    #[test]
    fn a_line_is_split_as_a_shell_splits_it() {
        for (line, words) in [
            ("fre solve a.toml", vec![vec!["fre", "solve", "a.toml"]]),
            ("a 'b c' \"d e\" # f", vec![vec!["a", "b c", "d e"]]),
            ("a > b 2>c | d", vec![vec!["a"], vec!["d"]]),
            ("a && (b; c) &", vec![vec!["a"], vec!["b"], vec!["c"]]),
            ("--x=\"1 2\"y", vec![vec!["--x=1 2y"]]),
            ("", vec![]),
        ] {
            assert_eq!(programs(line), words, "{line}");
        }
    }
}
