//! Links and pictures of a page, and the places in it that can be linked to.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

use crate::page::{Page, root};

/// A link or a picture.
#[derive(Clone, Debug)]
pub struct Link {
    /// Line of the page, from 1.
    pub line: usize,
    /// What it points to, as written.
    pub target: String,
}

/// What GitHub and mdBook both read.
pub(crate) const SYNTAX: Options = Options::ENABLE_TABLES
    .union(Options::ENABLE_FOOTNOTES)
    .union(Options::ENABLE_STRIKETHROUGH)
    .union(Options::ENABLE_TASKLISTS);

/// All links and pictures of a page, those in HTML too.
pub fn links(page: &Page) -> Vec<Link> {
    let mut found = Vec::new();
    for (event, range) in Parser::new_ext(&page.text, SYNTAX).into_offset_iter() {
        let line = page.line(range.start);
        match event {
            Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                found.push(Link { line, target: dest_url.into_string() });
            }
            Event::Html(html) | Event::InlineHtml(html) => {
                let values = attributes(&html, "href").chain(attributes(&html, "src"));
                found.extend(values.map(|target| Link { line, target }));
            }
            _ => {}
        }
    }
    found
}

/// Values of an attribute in HTML, in order.
pub fn attributes<'a>(html: &'a str, name: &str) -> impl Iterator<Item = String> + use<'a> {
    html.split(&format!(" {name}=\""))
        .skip(1)
        .filter_map(|rest| rest.split_once('"').map(|(value, _)| value.replace("&amp;", "&")))
        .collect::<Vec<_>>()
        .into_iter()
}

/// The anchors of a page's headings, and those of its HTML.
pub fn anchors(page: &Page) -> BTreeSet<String> {
    let (mut found, mut seen) = (BTreeSet::new(), BTreeMap::<String, usize>::new());
    let mut heading: Option<String> = None;
    for event in Parser::new_ext(&page.text, SYNTAX) {
        match event {
            Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
            Event::End(TagEnd::Heading(_)) => {
                let slug = slug(&heading.take().unwrap_or_default());
                let before = seen.entry(slug.clone()).or_default();
                found.insert(if *before == 0 { slug } else { format!("{slug}-{before}") });
                *before += 1;
            }
            Event::Text(part) | Event::Code(part) => {
                if let Some(text) = &mut heading {
                    text.push_str(&part);
                }
            }
            Event::Html(html) | Event::InlineHtml(html) => found.extend(attributes(&html, "id")),
            _ => {}
        }
    }
    found
}

/// A heading's anchor, as GitHub and mdBook make it.
fn slug(heading: &str) -> String {
    let kept = |c: char| match c {
        ' ' => Some('-'),
        c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
        _ => None,
    };
    heading.trim().to_lowercase().chars().filter_map(kept).collect()
}

/// What is wrong with a link of a page; nothing if it leads where it says. Addresses on the web are not looked up.
pub fn fault(page: &Page, link: &Link, pages: &[Page]) -> Option<String> {
    let target = link.target.as_str();
    if target.starts_with("https://") || target.starts_with("http://") || target.starts_with("mailto:") {
        return None;
    }
    let (path, anchor) = target.split_once('#').map_or((target, None), |(path, anchor)| (path, Some(anchor)));
    let file = if path.is_empty() { PathBuf::from(&page.path) } else { normal(&page.folder().join(path))? };
    let name = file.to_str()?.replace('\\', "/");
    if pages.iter().all(|page| page.path != name) && !root().join(&file).exists() {
        return Some(format!("{name} does not exist"));
    }
    if page.is_of_book() && !name.starts_with("docs/") {
        return Some(format!("{name} is not in the book, whose web pages would have a dead link"));
    }
    let anchor = anchor?;
    match pages.iter().find(|page| page.path == name) {
        Some(other) if anchors(other).contains(anchor) => None,
        Some(_) => Some(format!("{name} has no heading `#{anchor}`")),
        None => Some(format!("{name} is no page, so that it has no headings")),
    }
}

/// A path without `.` and `..`; none if it leaves the repository.
fn normal(path: &Path) -> Option<PathBuf> {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => out.pop().then_some(())?,
            Component::Normal(name) => out.push(name),
            _ => {}
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page(text: &str) -> Page {
        Page { path: "docs/it.md".to_owned(), text: text.to_owned() }
    }

    #[test]
    fn a_heading_has_the_anchor_that_its_readers_use() {
        let found =
            anchors(&page("# What it costs, at most\n## `[finger]`\n## Twice\n## Twice\n<a id=\"here\"></a>\n"));
        assert_eq!(Vec::from_iter(found), ["finger", "here", "twice", "twice-1", "what-it-costs-at-most"]);
    }

    #[test]
    fn links_and_pictures_are_found_with_their_lines() {
        let page = page("[a](b.md)\n\n![c](d.svg)\n\n<img src=\"e.png\" width=\"5\">\n\n`[no](link)`\n");
        let found: Vec<_> = links(&page).into_iter().map(|link| (link.line, link.target)).collect();
        assert_eq!(found, [(1, "b.md".to_owned()), (3, "d.svg".to_owned()), (5, "e.png".to_owned())]);
    }

    #[test]
    fn a_dead_link_is_named() {
        let pages = [page("# One\n"), Page { path: "docs/SUMMARY.md".to_owned(), text: "# Contents\n".to_owned() }];
        let fault = |target: &str| fault(&pages[0], &Link { line: 1, target: target.to_owned() }, &pages);
        assert_eq!(fault("#one"), None);
        assert_eq!(fault("SUMMARY.md#contents"), None);
        assert_eq!(fault("https://example.org"), None);
        assert!(fault("#two").unwrap().contains("no heading `#two`"));
        assert!(fault("nothing.md").unwrap().contains("docs/nothing.md does not exist"));
        assert!(fault("../README.md").unwrap().contains("not in the book"));
        assert!(fault("closing.svg#a").unwrap().contains("no page"));
    }
}
