//! A file's tree against the schema of its keys: the first thing that does not fit, with its place and what is allowed.

use serde_json::Value as Json;

use super::error::CaseError;
use super::source::{Table, Value};

/// Checks a table, with all that is below it.
pub(super) fn table(table: &Table<'_>, schema: &'static Json) -> Result<(), CaseError> {
    let schema = match schema["oneOf"].as_array() {
        Some(variants) => variant(table, variants)?,
        None => schema,
    };
    let properties = schema["properties"].as_object();
    let properties = || properties.into_iter().flatten();
    let known: Vec<&'static str> = properties().map(|(key, _)| key.as_str()).collect();
    table.only(&known, || known.clone())?;
    for (key, property) in properties() {
        if let Some(found) = table.get(key) {
            value(&found, property)?;
        }
    }
    for key in schema["required"].as_array().into_iter().flatten().filter_map(Json::as_str) {
        if !table.has(key) {
            return Err(table.missing(key, &needed(&schema["properties"][key])));
        }
    }
    Ok(())
}

/// The schema that the table's tag names.
fn variant(table: &Table<'_>, variants: &'static [Json]) -> Result<&'static Json, CaseError> {
    let tag = variants.first().and_then(|variant| {
        let mut properties = variant["properties"].as_object()?.iter();
        properties.find(|(_, property)| !property["const"].is_null()).map(|(key, _)| key.as_str())
    });
    let Some(tag) = tag else { return Ok(&Json::Null) };
    let words: Vec<Word> = variants
        .iter()
        .filter_map(|schema| Some(Word { word: schema["properties"][tag]["const"].as_str()?, schema }))
        .collect();
    match table.get(tag) {
        Some(value) => choice(&value, &words),
        None => Err(table.missing(tag, &format!("one of {}", quoted(&words)))),
    }
}

/// Checks a value, with all that is below it.
fn value(found: &Value<'_>, schema: &'static Json) -> Result<(), CaseError> {
    if let Some(forms) = schema["anyOf"].as_array() {
        let Some(form) = form(found, forms) else { return Err(found.wrong(needed(schema))) };
        return value_of(found, form);
    }
    value_of(found, schema)
}

/// The form that a value has, as far as types say: of two lists, the one whose entries are of the first entry's type.
fn form(found: &Value<'_>, forms: &'static [Json]) -> Option<&'static Json> {
    let mut same = forms.iter().filter(|form| form["type"] == found.kind());
    let first = same.next()?;
    let Some(entry) = found.entries(String::new, usize::MAX).ok().and_then(|entries| entries.into_iter().next()) else {
        return Some(first);
    };
    let fits = |form: &&Json| form["items"]["type"] == entry.kind();
    if fits(&first) { Some(first) } else { same.find(fits).or(Some(first)) }
}

/// Checks a value of one form.
fn value_of(found: &Value<'_>, schema: &'static Json) -> Result<(), CaseError> {
    if let Some(words) = schema["oneOf"].as_array().and_then(|words| words_of(words)) {
        return choice(found, &words).map(drop);
    }
    match schema["type"].as_str() {
        Some("number") => number(found, schema),
        Some("string") => found.text(|| needed(schema)).map(drop),
        Some("array") => array(found, schema),
        _ => table(&found.table(|| needed(schema))?, schema),
    }
}

fn number(found: &Value<'_>, schema: &'static Json) -> Result<(), CaseError> {
    let number = found.number(|| needed(schema))?;
    match (schema["minimum"].as_f64(), schema["maximum"].as_f64()) {
        (Some(least), Some(most)) if !(least..=most).contains(&number) => {
            let unit = schema["x-unit"].as_str().map(|unit| format!(" {unit}")).unwrap_or_default();
            let note = schema["x-note"].as_str().unwrap_or_default();
            Err(found.refuse(format!("allowed is {}{unit}{note}", range(least, most))))
        }
        _ => Ok(()),
    }
}

fn array(found: &Value<'_>, schema: &'static Json) -> Result<(), CaseError> {
    let expected = || needed(schema);
    let length = |key: &str| schema[key].as_u64().and_then(|length| usize::try_from(length).ok());
    let (least, most) = (length("minItems").unwrap_or(0), length("maxItems").unwrap_or(usize::MAX));
    if least == most {
        let entries = found.entries(expected, usize::MAX)?;
        if entries.len() != least {
            return Err(found.refuse(format!("has {} entries; needed is {}", entries.len(), expected())));
        }
        let each = |index: usize| match &schema["items"] {
            Json::Array(items) => items.get(index).unwrap_or(&Json::Null),
            item => item,
        };
        return entries.iter().enumerate().try_for_each(|(index, entry)| value(entry, each(index)));
    }
    let entries = found.entries(expected, most)?;
    if entries.len() < least {
        if least > 1 {
            return Err(found.refuse(format!(
                "has {} entries; needed is {}, at least {least}",
                entries.len(),
                expected()
            )));
        }
        let one = needed(&schema["items"]);
        return Err(found.refuse(format!("is empty; needed is at least one {}", one.trim_start_matches("a "))));
    }
    entries.iter().try_for_each(|entry| value(entry, &schema["items"]))
}

/// A word that a value may be, with the schema that goes with it.
struct Word {
    word: &'static str,
    schema: &'static Json,
}

/// The words of an enumeration; none for another schema.
fn words_of(words: &'static [Json]) -> Option<Vec<Word>> {
    words.iter().map(|schema| Some(Word { word: schema["const"].as_str()?, schema })).collect()
}

/// Words in quotes.
fn quoted(words: &[Word]) -> String {
    words.iter().map(|word| format!("\"{}\"", word.word)).collect::<Vec<_>>().join(", ")
}

fn choice(found: &Value<'_>, words: &[Word]) -> Result<&'static Json, CaseError> {
    let text = found.text(|| format!("one of {}", quoted(words)))?;
    match words.iter().find(|word| word.word == text) {
        Some(word) => Ok(word.schema),
        None => Err(found.refuse(format!("allowed is {}", quoted(words)))),
    }
}

/// A range in words; powers of ten where there would be rows of zeros.
pub(super) fn range(least: f64, most: f64) -> String {
    let limit = |limit: f64| if most >= 1e6 && limit >= 1e3 { format!("{limit:e}") } else { limit.to_string() };
    format!("{} to {}", limit(least), limit(most))
}

/// What a value of a schema should be, with its article.
pub(super) fn needed(schema: &Json) -> String {
    let said = |key: &str| schema[key].as_str();
    if let Some(words) = said("x-needed") {
        return words.to_owned();
    }
    if let Some(forms) = schema["anyOf"].as_array() {
        return forms.iter().map(needed).collect::<Vec<_>>().join(", or ");
    }
    if let Some(words) = schema["oneOf"].as_array() {
        let words = words.iter().filter_map(|word| word["const"].as_str());
        return format!("one of {}", words.map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", "));
    }
    let unit = |before: &str| said("x-unit").map(|unit| format!("{before}{unit}")).unwrap_or_default();
    match (said("type"), &schema["items"]) {
        (Some("number"), _) => match (schema["minimum"].as_f64(), schema["maximum"].as_f64(), said("x-unit")) {
            (Some(least), Some(most), None) => format!("a number from {}", range(least, most)),
            _ => format!("a number{}", unit(" of ")),
        },
        (Some("string"), _) => "a text".to_owned(),
        (Some("array"), Json::Array(_)) => format!("a pair {}", said("x-pair").unwrap_or("[position, value]")),
        (Some("array"), item) if item["items"].is_array() => {
            format!("a taper [{}, …]", said("x-pair").unwrap_or("[position, value]"))
        }
        (Some("array"), item) if item["type"] == "array" => format!("an array of [x, y]{}", unit(" in ")),
        (Some("array"), _) if schema["minItems"] == 2 && schema["maxItems"] == 2 => format!("[x, y]{}", unit(" in ")),
        (Some("array"), _) => {
            format!("an array of numbers{}", said("x-unit").map(|unit| format!(" ({unit})")).unwrap_or_default())
        }
        _ => "a table".to_owned(),
    }
}
