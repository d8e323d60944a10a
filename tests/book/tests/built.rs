//! mdBook builds the book, and its web pages link to one another.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use book::link::attributes;
use book::page::{BOOK, root};

/// Files below a folder, relative to it.
fn files(folder: &Path) -> Vec<PathBuf> {
    let (mut folders, mut files) = (vec![folder.to_path_buf()], Vec::new());
    while let Some(next) = folders.pop() {
        for entry in next.read_dir().expect("a folder").flatten() {
            if entry.path().is_dir() {
                folders.push(entry.path());
            } else {
                files.push(entry.path().strip_prefix(folder).expect("below the folder").to_path_buf());
            }
        }
    }
    files
}

#[test]
fn the_web_pages_are_complete_and_link_to_one_another() {
    let out = tempfile::tempdir().expect("a folder");
    book::html::build(out.path()).expect("a book");
    let there: BTreeSet<PathBuf> = files(out.path()).into_iter().collect();

    // Each page of the book has become a web page, each picture has come along.
    for file in files(&root().join(BOOK)).into_iter().filter(|file| file != Path::new("SUMMARY.md")) {
        let built = if file.extension().is_some_and(|e| e == "md") { file.with_extension("html") } else { file };
        assert!(there.contains(&built), "{} is not in the book", built.display());
    }

    // mdBook's own frames around the pages are left out.
    let frames = [Path::new("toc.html"), Path::new("404.html")];
    let pages: BTreeMap<&PathBuf, String> = there
        .iter()
        .filter(|file| file.extension().is_some_and(|e| e == "html") && !frames.contains(&file.as_path()))
        .map(|file| (file, fs::read_to_string(out.path().join(file)).expect("a web page")))
        .collect();
    let ids: BTreeMap<&PathBuf, BTreeSet<String>> =
        pages.iter().map(|(file, html)| (*file, attributes(html, "id").collect())).collect();
    let mut dead = Vec::new();
    for (file, html) in &pages {
        for target in attributes(html, "href").chain(attributes(html, "src")) {
            if target.contains("://") || target.starts_with("data:") {
                continue;
            }
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let to = if path.is_empty() { (*file).clone() } else { file.with_file_name(path) };
            let anchored = anchor.is_empty() || ids.get(&to).is_none_or(|ids| ids.contains(anchor));
            if !there.contains(&to) || !anchored {
                dead.push(format!("{}: {target}", file.display()));
            }
        }
    }
    assert!(dead.is_empty(), "dead links in the web pages:\n{}", dead.join("\n"));

    let derivation = &pages[&PathBuf::from("derivation.html")];
    assert!(derivation.matches("<math").count() > 50, "the derivation's formulas are not MathML");
    assert!(!pages.values().any(|html| html.contains("src=\"http")), "a web page fetches something");
}
