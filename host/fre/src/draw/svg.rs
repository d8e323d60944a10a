//! A picture as SVG: colours in a style sheet with a light set, for print too, and a dark one.
//!
//! In a file letters are drawn as paths, so that a picture looks the same everywhere and needs no font of the system; the
//! words lie over them invisibly: they can be marked, searched and read aloud. In a page, whose other text needs fonts anyhow,
//! they are text. Whatever the viewer's font, a line of words is as long as the picture has room for.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use kurbo::PathEl;

use super::font::Fonts;
use super::palette::Ink;
use super::path::{Path, Rect};
use super::scene::{Anchor, Item, SUBSCRIPT_DROP, SUBSCRIPT_SIZE, Scene, Text};

/// The picture as an SVG document.
pub fn svg(scene: &Scene) -> String {
    written(scene, None)
}

/// The picture as an SVG element of a page; its identifiers begin with a prefix, since they are the whole page's.
pub fn svg_in_page(scene: &Scene, prefix: &str) -> String {
    written(scene, Some(prefix))
}

/// How much longer than the others a moving picture shows its last frame, in frames.
const REST: f64 = 3.0;

/// Pictures of one size as a moving SVG: each is shown for so many seconds, in turn and again and again, the last one longer. Where
/// nothing moves (a viewer without animations, or a person who wants none) it is the last one.
pub fn moving_svg(frames: &[Scene], seconds_each: f64) -> String {
    let Some(last) = frames.last() else { return String::new() };
    let mut letters = Letters { fonts: Fonts::new(), paths: BTreeMap::new() };
    let mut out = String::new();
    open(&mut out, last);
    let units = frames.len() as f64 + REST;
    let [share, rest] = [1.0, 1.0 + REST].map(|part| number(100.0 * part / units));
    let whole = seconds_each * units;
    let _ = writeln!(
        out,
        "<style>.frame{{visibility:hidden;animation:shown {}s step-end infinite}}\
         .frame.last{{visibility:visible;animation-name:rest}}\
         @keyframes shown{{0%{{visibility:visible}}{share}%,100%{{visibility:hidden}}}}\
         @keyframes rest{{0%{{visibility:visible}}{rest}%,100%{{visibility:hidden}}}}\
         @media(prefers-reduced-motion:reduce){{.frame{{animation:none}}}}</style>",
        number(whole)
    );
    frames.iter().for_each(|scene| letters.learn(scene));
    out.push_str(&letters.definitions());
    paper(&mut out, last);
    // What all of them show is drawn once; what changes lies between, as it did in each.
    let all: Vec<Vec<Drawn>> = frames.iter().map(drawn).collect();
    let still = in_all(&all);
    let mut turns: Vec<_> = all.iter().map(|frame| frame.iter().copied().peekable()).collect();
    let mut clips = 0;
    for next in still.iter().map(Some).chain([None]) {
        for (index, turn) in turns.iter_mut().enumerate() {
            let mut moving = Vec::new();
            while let Some(item) = turn.next_if(|item| Some(item) != next) {
                moving.push(item);
            }
            turn.next();
            if moving.is_empty() {
                continue;
            }
            // Each begins its turn in the middle of the round that has passed already.
            let delay = number(seconds_each * index as f64 - whole);
            let class = if index + 1 == frames.len() { "frame last" } else { "frame" };
            let _ = writeln!(out, r#"<g class="{class}" style="animation-delay:{delay}s">"#);
            items(&mut out, &moving, &letters, None, &mut clips);
            out.push_str("</g>\n");
        }
        if let Some(item) = next {
            items(&mut out, std::slice::from_ref(item), &letters, None, &mut clips);
        }
    }
    out.push_str("</svg>\n");
    out
}

/// What all frames show in the same order.
fn in_all<'a>(frames: &[Vec<Drawn<'a>>]) -> Vec<Drawn<'a>> {
    let Some((first, others)) = frames.split_first() else { return Vec::new() };
    let mut common = first.clone();
    for other in others {
        // In order: what is found is looked for behind what was found before.
        let mut from = 0;
        common.retain(|item| match other[from..].iter().position(|there| there == item) {
            Some(behind) => {
                from += behind + 1;
                true
            }
            None => false,
        });
    }
    common
}

/// A path or text of a picture, and the region that it is clipped to.
type Drawn<'a> = (Option<Rect>, &'a Item);

fn drawn(scene: &Scene) -> Vec<Drawn<'_>> {
    let mut region = None;
    let mut all = Vec::new();
    for item in &scene.items {
        match item {
            Item::Clip(rect) => region = Some(*rect),
            Item::Unclip => region = None,
            item => all.push((region, item)),
        }
    }
    all
}

fn written(scene: &Scene, page: Option<&str>) -> String {
    let mut out = String::new();
    open(&mut out, scene);
    let mut letters = Letters { fonts: Fonts::new(), paths: BTreeMap::new() };
    if page.is_none() {
        letters.learn(scene);
        out.push_str(&letters.definitions());
    }
    paper(&mut out, scene);
    items(&mut out, &drawn(scene), &letters, page, &mut 0);
    out.push_str("</svg>\n");
    out
}

/// The document's begin: size, title, colours. Writing into a String cannot fail.
fn open(out: &mut String, scene: &Scene) {
    let (width, height) = (number(scene.width), number(scene.height));
    let description = escape(&scene.description);
    let _ = writeln!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" role="img" aria-label="{description}">"#
    );
    let _ = writeln!(out, "<title>{description}</title>");
    out.push_str(&style());
}

fn paper(out: &mut String, scene: &Scene) {
    let _ =
        writeln!(out, r#"<rect class="f-paper" width="{}" height="{}"/>"#, number(scene.width), number(scene.height));
}

/// Paths and texts; `clips` counts the document's clipped regions.
fn items(out: &mut String, drawn: &[Drawn], letters: &Letters, page: Option<&str>, clips: &mut usize) {
    let prefix = page.unwrap_or_default();
    let mut region = None;
    for &(wanted, item) in drawn {
        if wanted != region {
            if region.is_some() {
                out.push_str("</g>\n");
            }
            if let Some(rect) = wanted {
                *clips += 1;
                let _ = writeln!(
                    out,
                    r#"<clipPath id="{prefix}clip{clips}"><path d="{}"/></clipPath><g clip-path="url(#{prefix}clip{clips})">"#,
                    steps(&Path::rectangle(rect))
                );
            }
            region = wanted;
        }
        match item {
            Item::Path(path, fill, stroke) => {
                let mut classes = Vec::new();
                let mut extra = String::new();
                match fill {
                    Some(fill) => {
                        classes.push(format!("f-{}", fill.ink.class()));
                        if fill.opacity < 1.0 {
                            let _ = write!(extra, r#" fill-opacity="{}""#, number(fill.opacity));
                        }
                    }
                    None => extra.push_str(r#" fill="none""#),
                }
                if let Some(stroke) = stroke {
                    classes.push(format!("s-{}", stroke.ink.class()));
                    let _ = write!(extra, r#" stroke-width="{}""#, number(stroke.width));
                    if let Some([dash, gap]) = stroke.dash {
                        let _ = write!(extra, r#" stroke-dasharray="{} {}""#, number(dash), number(gap));
                    }
                    if stroke.round {
                        extra.push_str(r#" stroke-linecap="round" stroke-linejoin="round""#);
                    }
                }
                let _ = writeln!(out, r#"<path class="{}"{extra} d="{}"/>"#, classes.join(" "), steps(path));
            }
            Item::Text(text) => {
                if page.is_none() {
                    letters.draw(out, text);
                }
                write_text(out, text, letters.fonts.width(text), page.is_some());
            }
            Item::Clip(_) | Item::Unclip => {}
        }
    }
    if region.is_some() {
        out.push_str("</g>\n");
    }
}

fn style() -> String {
    let mut light = String::new();
    let mut dark = String::new();
    for ink in Ink::all() {
        let (on_white, on_black) = ink.colours();
        for (sheet, [r, g, b]) in [(&mut light, on_white), (&mut dark, on_black)] {
            let class = ink.class();
            let _ =
                write!(sheet, ".f-{class}{{fill:#{r:02x}{g:02x}{b:02x}}}.s-{class}{{stroke:#{r:02x}{g:02x}{b:02x}}}");
        }
    }
    format!(
        "<style>.words{{font-family:'Noto Sans','Helvetica Neue',Helvetica,Arial,'DejaVu Sans',sans-serif}}.hidden{{fill-opacity:0}}\
         .halo{{paint-order:stroke;stroke-linejoin:round}}{light}\
         @media screen and (prefers-color-scheme:dark){{{dark}}}</style>\n"
    )
}

/// The letters of a document: each path is in it once.
struct Letters {
    fonts: Fonts,
    /// Paths by their names.
    paths: BTreeMap<String, String>,
}

impl Letters {
    /// Takes note of all letters of a picture.
    fn learn(&mut self, scene: &Scene) {
        for item in &scene.items {
            let Item::Text(text) = item else { continue };
            for glyph in self.fonts.glyphs(text) {
                let name = name(&glyph);
                if !self.paths.contains_key(&name) {
                    let path = steps(&self.fonts.glyph_path(&glyph));
                    self.paths.insert(name, path);
                }
            }
        }
    }

    /// Definitions of all letters.
    fn definitions(&self) -> String {
        let mut out = String::from("<defs>\n");
        for (name, path) in self.paths.iter().filter(|(_, path)| !path.is_empty()) {
            let _ = writeln!(out, r#"<path id="{name}" d="{path}"/>"#);
        }
        out.push_str("</defs>\n");
        out
    }

    /// Draws a text's letters.
    fn draw(&self, out: &mut String, text: &Text) {
        let mut class = format!("f-{}", text.ink.class());
        if text.halo > 0.0 {
            class.push_str(" s-paper halo");
        }
        let turn = if text.upright {
            let [x, y] = text.at.map(number);
            format!(r#" transform="rotate(-90 {x} {y})""#)
        } else {
            String::new()
        };
        let _ = write!(out, r#"<g class="{class}"{turn} aria-hidden="true">"#);
        // Rims first: a letter's must not cover its neighbour.
        for rim in if text.halo > 0.0 { &[true, false][..] } else { &[false] } {
            for glyph in self.fonts.glyphs(text) {
                let name = name(&glyph);
                if self.paths.get(&name).is_none_or(String::is_empty) {
                    continue;
                }
                let ([x, y], scale) = (glyph.at.map(number), glyph.scale);
                let width = if *rim {
                    format!(r#" stroke-width="{}""#, number(text.halo / scale))
                } else if text.halo > 0.0 {
                    r#" stroke="none""#.to_owned()
                } else {
                    String::new()
                };
                let _ =
                    write!(out, r##"<use href="#{name}" transform="translate({x} {y}) scale({scale:.5})"{width}/>"##);
            }
        }
        out.push_str("</g>\n");
    }
}

/// A letter's name in the document.
fn name(glyph: &super::font::Glyph) -> String {
    format!("letter{}-{}", glyph.style, glyph.id)
}

/// Writes a text so that it is this wide.
fn write_text(out: &mut String, text: &Text, width: f64, visible: bool) {
    let anchor = match text.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let [x, y] = text.at.map(number);
    let mut extra = String::new();
    if text.bold {
        extra.push_str(r#" font-weight="bold""#);
    }
    if text.upright {
        let _ = write!(extra, r#" transform="rotate(-90 {x} {y})""#);
    }
    if width > 0.0 {
        let _ = write!(extra, r#" textLength="{}" lengthAdjust="spacingAndGlyphs""#, number(width));
    }
    let mut class = "hidden words".to_owned();
    if visible {
        class = format!("f-{} words", text.ink.class());
        if text.halo > 0.0 {
            class.push_str(" s-paper halo");
            let _ = write!(extra, r#" stroke-width="{}""#, number(text.halo));
        }
    }
    let size = number(text.size);
    let _ = write!(out, r#"<text class="{class}" x="{x}" y="{y}" font-size="{size}" text-anchor="{anchor}"{extra}>"#);
    let mut lowered = false;
    for piece in text.pieces() {
        let words = escape(&piece.words);
        let mut style = String::new();
        if piece.italic {
            style.push_str(r#" font-style="italic""#);
        }
        if piece.subscript {
            let _ = write!(style, r#" font-size="{}""#, number(SUBSCRIPT_SIZE * text.size));
        }
        if piece.subscript != lowered {
            let drop = if piece.subscript { SUBSCRIPT_DROP } else { -SUBSCRIPT_DROP };
            let _ = write!(style, r#" dy="{}""#, number(drop * text.size));
        }
        lowered = piece.subscript;
        if style.is_empty() {
            out.push_str(&words);
        } else {
            let _ = write!(out, "<tspan{style}>{words}</tspan>");
        }
    }
    out.push_str("</text>\n");
}

fn steps(path: &Path) -> String {
    let mut out = String::new();
    let point = |p: kurbo::Point| format!("{} {}", number(p.x), number(p.y));
    for element in &path.0 {
        let _ = match element {
            PathEl::MoveTo(p) => write!(out, "M{}", point(p)),
            PathEl::LineTo(p) => write!(out, "L{}", point(p)),
            PathEl::QuadTo(a, p) => write!(out, "Q{} {}", point(a), point(p)),
            PathEl::CurveTo(a, b, p) => write!(out, "C{} {} {}", point(a), point(b), point(p)),
            PathEl::ClosePath => write!(out, "Z"),
        };
    }
    out
}

/// Two decimals, without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            // Line breaks and tabs part words.
            '\t' | '\n' | '\r' => out.push(' '),
            // Not allowed in XML, whatever their escape.
            '\u{fffe}' | '\u{ffff}' => {}
            control if control.is_control() => {}
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            other => out.push(other),
        }
    }
    out
}
