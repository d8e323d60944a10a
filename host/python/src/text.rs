//! TOML as JSON and back: Python 3.10 reads no TOML, and no Python writes it.

use pyo3::prelude::*;
use serde_json::{Map, Value as Json};
use toml_edit::{DocumentMut, Item, Table, Value};

use crate::error::value;

/// A TOML text as JSON.
#[pyfunction]
pub(crate) fn toml_to_json(text: &str) -> PyResult<String> {
    let document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| value(error.to_string()))?;
    Ok(table(document.as_table()).to_string())
}

/// A JSON object as TOML: tables below tables, everything else in a line. A null is left out.
#[pyfunction]
pub(crate) fn json_to_toml(text: &str) -> PyResult<String> {
    let json: Json = serde_json::from_str(text).map_err(|error| value(error.to_string()))?;
    let Json::Object(entries) = json else { return Err(value("a table is needed")) };
    Ok(DocumentMut::from(to_table(&entries)).to_string())
}

fn table(table: &Table) -> Json {
    Json::Object(table.iter().map(|(key, entry)| (key.to_owned(), item(entry))).collect())
}

fn item(item: &Item) -> Json {
    match item {
        Item::None => Json::Null,
        Item::Value(value) => plain(value),
        Item::Table(below) => table(below),
        Item::ArrayOfTables(tables) => tables.iter().map(table).collect(),
    }
}

fn plain(value: &Value) -> Json {
    match value {
        Value::String(text) => text.value().as_str().into(),
        Value::Integer(number) => (*number.value()).into(),
        Value::Float(number) => (*number.value()).into(),
        Value::Boolean(flag) => (*flag.value()).into(),
        Value::Datetime(date) => date.value().to_string().into(),
        Value::Array(items) => items.iter().map(plain).collect(),
        Value::InlineTable(below) => {
            Json::Object(below.iter().map(|(key, value)| (key.to_owned(), plain(value))).collect())
        }
    }
}

fn to_table(entries: &Map<String, Json>) -> Table {
    let mut table = Table::new();
    for (key, json) in entries.iter().filter(|(_, json)| !json.is_null()) {
        let item = match json {
            Json::Object(below) => Item::Table(to_table(below)),
            other => Item::Value(to_value(other)),
        };
        table.insert(key, item);
    }
    table
}

fn to_value(json: &Json) -> Value {
    match json {
        Json::Null => "".into(),
        Json::Bool(flag) => (*flag).into(),
        Json::Number(number) => match number.as_i64() {
            Some(integer) => integer.into(),
            None => number.as_f64().unwrap_or(f64::NAN).into(),
        },
        Json::String(text) => text.into(),
        Json::Array(items) => items.iter().map(to_value).collect(),
        Json::Object(below) => {
            Value::InlineTable(below.iter().map(|(key, json)| (key.as_str(), to_value(json))).collect())
        }
    }
}
