//! The page of all keys of a case file, made from their schema.

use std::fmt::Write as _;

use serde_json::Value as Json;

use super::check::range;
use super::keys;

/// One table of keys, or several that have the same keys.
struct Section {
    /// Its paths, for example `finger.front`; with a variant's tag, for example `shape = "circle"`.
    titles: Vec<String>,
    meaning: Vec<String>,
    schema: &'static Json,
}

/// Folder of the page's pictures, beside it; they are `NAME.svg`, see [`crate::draw::key_picture`].
pub const PICTURES: &str = "case";

/// The page as Markdown.
pub fn reference() -> String {
    let mut sections = Vec::new();
    collect("", keys::schema(), &mut sections);
    let mut out = String::from(INTRODUCTION);
    let mut drawn = Vec::new();
    for section in &sections {
        write_section(&mut out, section, &mut drawn);
    }
    out
}

const INTRODUCTION: &str = "\
<!-- Made by `cargo run --release --bin fre -- schema --force --page docs`; a test keeps it current. Edit host/fre/src/case/keys instead. -->

# Keys of a case file

A case is a TOML file with a finger, an object and a motion. Lengths are in mm, angles in degrees, stresses in Pa.
Points `[x, y]` of a finger are in its own frame: origin at the front beam's base, y towards the tip, x towards the
object. Objects are in the world frame, which is the finger's at a motor angle of 0.

A key is addressed by its path, for example `finger.front.thickness_mm`; an entry of a list by its number from 0, for
example `object.centre_mm.1`. `fre sweep --vary` varies a key, `fre calibrate --write` writes fitted ones, and messages
name the key at fault.

Editors that support JSON Schema for TOML (such as Taplo) check and complete keys with
`fre schema > case.schema.json` and, in the first line of a case, `#:schema case.schema.json`.
";

/// Collects the tables below a schema, the outer ones first.
fn collect(path: &str, schema: &'static Json, sections: &mut Vec<Section>) {
    let variants =
        schema["oneOf"].as_array().filter(|variants| variants.iter().all(|one| one["properties"].is_object()));
    if let Some(variants) = variants {
        for variant in variants {
            add(sections, format!("[{path}] {}", tag(variant)), variant);
        }
        return;
    }
    if !path.is_empty() {
        add(sections, format!("[{path}]"), schema);
    }
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        if let Some(table) = table_of(property) {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            collect(&path, table, sections);
        }
    }
}

/// The table that a key holds; none for another value.
fn table_of(property: &'static Json) -> Option<&'static Json> {
    let forms = property["anyOf"].as_array().into_iter().flatten();
    let is_table = |schema: &&Json| schema["properties"].is_object() || schema["oneOf"][0]["properties"].is_object();
    Some(property).into_iter().chain(forms).find(is_table)
}

fn add(sections: &mut Vec<Section>, title: String, schema: &'static Json) {
    let meaning = schema["description"].as_str().unwrap_or_default().to_owned();
    match sections.iter_mut().find(|section| section.schema["properties"] == schema["properties"]) {
        Some(same) => {
            same.titles.push(title);
            same.meaning.push(meaning);
        }
        None => sections.push(Section { titles: vec![title], meaning: vec![meaning], schema }),
    }
}

/// `shape = "circle"`.
fn tag(variant: &Json) -> String {
    let properties = variant["properties"].as_object();
    let tag = properties.into_iter().flatten().find_map(|(key, one)| Some(format!("{key} = {}", one.get("const")?)));
    tag.unwrap_or_default()
}

fn write_section(out: &mut String, section: &Section, drawn: &mut Vec<&'static str>) {
    let titles: Vec<String> = section.titles.iter().map(|title| format!("`{title}`")).collect();
    let _ = writeln!(out, "\n## {}\n", titles.join(", "));
    if let ([_], [meaning]) = (&section.titles[..], &section.meaning[..]) {
        let _ = writeln!(out, "{}\n", line(meaning));
    } else {
        for (title, meaning) in titles.iter().zip(&section.meaning) {
            let _ = writeln!(out, "- {title}: {}", line(meaning));
        }
        out.push('\n');
    }
    let mut pictures: Vec<&str> = Vec::new();
    out.push_str("| key | value | unit | default | range | meaning |\n|---|---|---|---|---|---|\n");
    for (key, schema) in section.schema["properties"].as_object().into_iter().flatten() {
        // The tag is in the title; a table below has a section of its own.
        if !schema["const"].is_null() || (table_of(schema).is_some() && schema["type"] == "object") {
            continue;
        }
        let required =
            section.schema["required"].as_array().is_some_and(|required| required.contains(&Json::from(&**key)));
        let unit = schema["x-unit"].as_str().unwrap_or_default();
        let cells = [form(schema), unit.to_owned(), default(schema, required), limits(schema), meaning(schema)];
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        let _ = writeln!(out, "| `{key}` | {} |", cells.join(" | "));
        // Each picture is on the page once.
        if let Some(picture) = schema["x-picture"].as_str().filter(|picture| !drawn.contains(picture)) {
            drawn.push(picture);
            pictures.push(picture);
        }
    }
    for picture in pictures {
        let _ = writeln!(out, "\n![Picture: {picture}]({PICTURES}/{picture}.svg)");
    }
}

/// A text on one line.
fn line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The form of a value.
fn form(schema: &Json) -> String {
    if let Some(forms) = schema["anyOf"].as_array() {
        return forms.iter().map(form).collect::<Vec<_>>().join(" or ");
    }
    if let Some(words) = words(schema) {
        return words
            .iter()
            .map(|word| format!("`\"{}\"`", word["const"].as_str().unwrap_or_default()))
            .collect::<Vec<_>>()
            .join(", ");
    }
    let pair = schema["x-pair"].as_str().unwrap_or("[x, y]");
    match (schema["type"].as_str(), &schema["items"]) {
        (Some("number"), _) => "number".to_owned(),
        (Some("string"), _) => "text".to_owned(),
        (Some("object"), _) => "table".to_owned(),
        (_, Json::Array(_)) => format!("`{pair}`"),
        (_, item) if item["type"] == "array" => format!("`[{pair}, …]`"),
        _ if schema["minItems"] == 2 && schema["maxItems"] == 2 => format!("`{pair}`"),
        _ => "list".to_owned(),
    }
}

/// The words of an enumeration; none for another schema.
fn words(schema: &Json) -> Option<&Vec<Json>> {
    schema["oneOf"].as_array().filter(|words| words.iter().all(|word| word["const"].is_string()))
}

fn default(schema: &Json, required: bool) -> String {
    match (&schema["default"], schema["x-default"].as_str()) {
        (_, Some(words)) => words.to_owned(),
        (Json::Null, None) if required => "needed".to_owned(),
        (Json::Null, None) => "none".to_owned(),
        (value, None) => format!("`{}`", value.as_f64().map_or_else(|| value.to_string(), |number| number.to_string())),
    }
}

fn limits(schema: &Json) -> String {
    if let Some(words) = schema["x-limits"].as_str() {
        return words.to_owned();
    }
    let mut parts = Vec::new();
    if let Some([least, most]) = schema["x-range"].as_array().map(Vec::as_slice) {
        parts.push(range(least.as_f64().unwrap_or_default(), most.as_f64().unwrap_or_default()));
    }
    let lists = schema["anyOf"].as_array().into_iter().flatten().chain([schema]);
    let most = lists.filter(|list| list["minItems"] != list["maxItems"]).find_map(|list| list["maxItems"].as_u64());
    parts.extend(most.map(|most| format!("up to {most} entries")));
    parts.join("; ")
}

fn meaning(schema: &Json) -> String {
    let mut out = line(schema["description"].as_str().unwrap_or_default());
    for word in words(schema).into_iter().flatten() {
        let meaning = line(word["description"].as_str().unwrap_or_default());
        let _ = write!(out, "<br>`{}`: {meaning}", word["const"].as_str().unwrap_or_default());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::reference;

    #[test]
    fn the_page_names_keys_units_defaults_ranges_and_pictures() {
        let page = reference();
        for piece in [
            "## `[finger.front]`, `[finger.back]`",
            "| `stiffness_factor` | number |  | `1` | 0.001 to 1000 |",
            "| `youngs_modulus_pa` | number | Pa | needed | 1e3 to 1e12 |",
            "| `width_mm` | number or `[[height_mm, width_mm], …]` | mm | needed | 0.1 to 5000; up to 64 entries |",
            "| `friction` | number |  | `0` | 0 to 3 |",
            "## `[object] shape = \"ellipse\"`",
            "`gap`: Welded to the front beam, `gap_mm` away from the back beam.",
            "![Picture: hinge](case/hinge.svg)",
        ] {
            assert!(page.contains(piece), "{piece}\n{page}");
        }
        assert!(!page.contains("null"), "{page}");
    }
}
