//! Every link of every page leads where it says, and every page of the book is in its table of contents.

use std::collections::BTreeSet;

use book::link::{fault, links};
use book::page::{CONTENTS, all, book};

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let pages = all();
    let (mut faults, mut checked) = (Vec::new(), 0);
    for page in &pages {
        for link in links(page) {
            checked += 1;
            faults.extend(
                fault(page, &link, &pages)
                    .map(|fault| format!("{}:{}: [{}]: {fault}", page.path, link.line, link.target)),
            );
        }
    }
    assert!(faults.is_empty(), "dead links:\n{}", faults.join("\n"));
    assert!(checked > 100, "only {checked} links were found");
}

#[test]
fn the_table_of_contents_has_every_page_once() {
    let pages = all();
    let contents = pages.iter().find(|page| page.path == CONTENTS).expect("a table of contents");
    let mut listed: Vec<String> = links(contents).into_iter().map(|link| format!("docs/{}", link.target)).collect();
    let count = listed.len();
    listed.sort();
    listed.dedup();
    assert_eq!(listed.len(), count, "a page is listed twice");
    let there: BTreeSet<String> = book().into_iter().map(|page| page.path).collect();
    assert_eq!(BTreeSet::from_iter(listed), there);
}

/// A reader who follows links alone finds every page.
#[test]
fn every_page_of_the_book_is_linked_from_another() {
    let pages = all();
    for page in book() {
        let name = page.path.rsplit('/').next().expect("a name");
        let leads_there =
            |target: &str| target.split('#').next().and_then(|path| path.rsplit('/').next()) == Some(name);
        let linked = pages
            .iter()
            .filter(|other| other.path != page.path && other.path != CONTENTS)
            .any(|other| links(other).iter().any(|link| leads_there(&link.target)));
        assert!(linked, "no page links to {}", page.path);
    }
}
