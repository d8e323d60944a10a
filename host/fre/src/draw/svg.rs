//! A picture as SVG: colours in a style sheet with a light set, for print too, and a dark one.
//!
//! In a file letters are drawn as paths, so that a picture looks the same everywhere and needs no font of the system; the
//! words lie over them invisibly: they can be marked, searched and read aloud. In a page, whose other text needs fonts anyhow,
//! they are text. Whatever the viewer's font, a line of words is as long as the picture has room for.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::font::Fonts;
use super::palette::Ink;
use super::scene::{Anchor, Item, Path, SUBSCRIPT_DROP, SUBSCRIPT_SIZE, Scene, Step, Text};

/// The picture as an SVG document.
pub fn svg(scene: &Scene) -> String {
    written(scene, None)
}

/// The picture as an SVG element of a page; its identifiers begin with a prefix, since they are the whole page's.
pub fn svg_in_page(scene: &Scene, prefix: &str) -> String {
    written(scene, Some(prefix))
}

fn written(scene: &Scene, page: Option<&str>) -> String {
    let mut out = String::new();
    let prefix = page.unwrap_or_default();
    let (width, height) = (number(scene.width), number(scene.height));
    let description = escape(&scene.description);
    // Writing into a String cannot fail.
    let _ = writeln!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" role="img" aria-label="{description}">"#
    );
    let _ = writeln!(out, "<title>{description}</title>");
    out.push_str(&style());
    let mut letters = Letters { fonts: Fonts::new(), paths: BTreeMap::new() };
    if page.is_none() {
        out.push_str(&letters.definitions(scene));
    }
    let _ = writeln!(out, r#"<rect class="f-paper" width="{width}" height="{height}"/>"#);
    let mut clips = 0;
    let mut clipped = false;
    for item in &scene.items {
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
                    letters.draw(&mut out, text);
                }
                write_text(&mut out, text, letters.fonts.width(text), page.is_some());
            }
            Item::Clip(rect) => {
                if clipped {
                    out.push_str("</g>\n");
                }
                clips += 1;
                clipped = true;
                let _ = writeln!(
                    out,
                    r#"<clipPath id="{prefix}clip{clips}"><path d="{}"/></clipPath><g clip-path="url(#{prefix}clip{clips})">"#,
                    steps(&Path::rectangle(*rect))
                );
            }
            Item::Unclip => {
                if clipped {
                    out.push_str("</g>\n");
                }
                clipped = false;
            }
        }
    }
    if clipped {
        out.push_str("</g>\n");
    }
    out.push_str("</svg>\n");
    out
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
    /// Outlines by their names.
    paths: BTreeMap<String, String>,
}

impl Letters {
    /// Definitions of all letters of a picture.
    fn definitions(&mut self, scene: &Scene) -> String {
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
    let point = |[x, y]: [f64; 2]| format!("{} {}", number(x), number(y));
    for step in &path.0 {
        let _ = match *step {
            Step::Move(p) => write!(out, "M{}", point(p)),
            Step::Line(p) => write!(out, "L{}", point(p)),
            Step::Cubic(a, b, c) => write!(out, "C{} {} {}", point(a), point(b), point(c)),
            Step::Close => write!(out, "Z"),
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
