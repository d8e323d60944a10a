//! A TOML file as a tree in which every value has its key and its line.

use std::ops::Range;

use serde::de::DeserializeOwned;
use serde_json::Value as Json;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{CaseError, KnownKeys, Place, nearest, shortened};
use crate::visible::visible;

/// The largest case file, bytes.
pub(super) const MAX_BYTES: u64 = 1 << 20;

/// The text of a file and what it is called in messages.
pub(super) struct Source {
    pub(super) name: String,
    pub(super) text: String,
}

impl Source {
    /// Reads a file.
    pub(super) fn read(path: &std::path::Path) -> Result<Self, CaseError> {
        use std::io::Read as _;
        let name = path.display().to_string();
        let unreadable = |error: std::io::Error| CaseError::Unreadable {
            file: name.clone(),
            kind: error.kind(),
            reason: error.to_string(),
        };
        let file = std::fs::File::open(path).map_err(unreadable)?;
        // Devices and pipes have no length to trust, so the reading itself is bounded.
        let mut bytes = Vec::new();
        file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        if bytes.len() as u64 > MAX_BYTES {
            let length = std::fs::metadata(path).map_or(0, |data| data.len()).max(bytes.len() as u64);
            return Err(CaseError::TooLarge { file: name, bytes: length, max: MAX_BYTES });
        }
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Self { name, text }),
            Err(error) => {
                let valid = error.utf8_error().valid_up_to();
                let line = 1 + error.as_bytes()[..valid].iter().filter(|&&byte| byte == b'\n').count();
                let found = match error.as_bytes() {
                    [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "it is UTF-16",
                    _ => "a byte is not UTF-8",
                };
                Err(CaseError::NotText { file: name, line, found })
            }
        }
    }

    /// Number of the line with the most dots and opening brackets.
    fn deepest(&self) -> usize {
        let depth = |line: &str| line.chars().filter(|letter| matches!(letter, '.' | '[' | '{')).count();
        let lines = self.text.lines().map(depth).enumerate();
        lines.max_by(|a, b| a.1.cmp(&b.1).then(b.0.cmp(&a.0))).map_or(1, |(index, _)| index + 1)
    }

    /// The tree. The text stays borrowed: values point into it.
    pub(super) fn parse(&self) -> Result<Spanned<DeTable<'_>>, CaseError> {
        DeTable::parse(&self.text).map_err(|error| self.syntax(error.span(), error.message()))
    }

    /// The error of a text that is not TOML.
    pub(super) fn syntax(&self, place: Option<Range<usize>>, message: &str) -> CaseError {
        // What is nested too deep is reported without its place: it is where most begins.
        let line = place.map_or_else(|| self.deepest(), |span| self.line(span.start));
        let text = self.text.lines().nth(line - 1).unwrap_or("");
        let mut reason = visible(&message.replace('\n', ", "));
        if has_decimal_comma(text) {
            reason.push_str(" (decimals have a point)");
        }
        CaseError::Syntax { file: self.name.clone(), line, reason, text: shortened(text) }
    }

    fn line(&self, offset: usize) -> usize {
        let before = self.text.as_bytes().get(..offset).unwrap_or(self.text.as_bytes());
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    fn piece(&self, span: &Range<usize>) -> Option<&str> {
        self.text.get(span.clone()).filter(|piece| !piece.is_empty())
    }
}

/// True for `key = 1,5`.
fn has_decimal_comma(line: &str) -> bool {
    let digits = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    let value = line.split_once('=').map_or("", |(_, value)| value.split('#').next().unwrap_or("").trim());
    value.split_once(',').is_some_and(|(whole, part)| digits(whole.trim_start_matches(['-', '+'])) && digits(part))
}

/// A table with the keys that are allowed in it; opened only if it holds no other.
#[derive(Clone)]
pub(super) struct Table<'d> {
    source: &'d Source,
    /// Dotted key of the table, empty for the root.
    path: String,
    /// Where it begins in the text: lines are counted only for messages.
    start: usize,
    entries: &'d DeTable<'d>,
}

impl<'d> Table<'d> {
    /// The root of a file.
    pub(super) fn root(source: &'d Source, entries: &'d DeTable<'d>) -> Self {
        Self { source, path: String::new(), start: 0, entries }
    }

    /// True if the key is present.
    pub(super) fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// Refuses keys that are not known; the first one in the file's order is named, with those that are allowed.
    pub(super) fn only(
        &self,
        known: &[&'static str],
        allowed: impl FnOnce() -> Vec<&'static str>,
    ) -> Result<(), CaseError> {
        let unknown = self.entries.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        match unknown.min_by_key(|key| key.span().start) {
            None => Ok(()),
            Some(key) => {
                let line = self.source.line(key.span().start);
                let value = self.entries.get(key.get_ref().as_ref()).filter(|value| !value.get_ref().is_table());
                let piece = value.and_then(|value| self.source.piece(&value.span()));
                let name = self.dotted(key.get_ref());
                Err(CaseError::UnknownKey {
                    place: Place::new(&self.source.name, line, &name, piece),
                    known: Box::new(KnownKeys { allowed: allowed(), nearest: nearest(key.get_ref(), known) }),
                })
            }
        }
    }

    /// The value of a key, if present.
    pub(super) fn get(&self, key: &'static str) -> Option<Value<'d>> {
        let (name, item) = self.entries.get_key_value(key)?;
        // A table's own span may be empty (dotted keys): its key says where it begins.
        let start = if item.get_ref().is_table() { name.span().start } else { item.span().start };
        Some(Value { source: self.source, key: self.dotted(key), start, item })
    }

    /// The table below a key; none if there is no such table.
    pub(super) fn child(&self, key: &'static str) -> Option<Self> {
        self.get(key)?.table(String::new).ok()
    }

    /// The table as the model of its keys. What a schema's check has passed is readable.
    pub(super) fn read<X: DeserializeOwned>(&self) -> Result<X, CaseError> {
        serde_json::from_value(json_table(self.entries)).map_err(|error| CaseError::Refused {
            place: Place::new(&self.source.name, self.source.line(self.start), &self.path, None),
            reason: visible(&error.to_string()),
        })
    }

    /// The error of an absent key.
    pub(super) fn missing(&self, key: &str, expected: &str) -> CaseError {
        CaseError::Missing {
            place: Place::new(&self.source.name, self.source.line(self.start), &self.dotted(key), None),
            expected: expected.to_owned(),
        }
    }

    /// The error of a table whose keys do not fit together.
    pub(super) fn refuse(&self, key: &str, reason: impl Into<String>) -> CaseError {
        match self.find(key) {
            Some(value) => value.refuse(reason),
            None => CaseError::Refused {
                place: Place::new(&self.source.name, self.source.line(self.start), &self.dotted(key), None),
                reason: reason.into(),
            },
        }
    }

    /// The error of an array's entry; of the key itself if it holds no such entry.
    pub(super) fn refuse_entry(&self, key: &str, index: usize, reason: impl Into<String>) -> CaseError {
        let entries = self.find(key).and_then(|value| value.entries(String::new, usize::MAX).ok());
        match entries.as_ref().and_then(|entries| entries.get(index)) {
            Some(value) => value.refuse(reason),
            None => self.refuse(key, reason),
        }
    }

    /// A value below this table by its dotted key.
    pub(super) fn find(&self, dotted: &str) -> Option<Value<'d>> {
        let mut table = self.clone();
        let mut keys = dotted.split('.').peekable();
        while let Some(key) = keys.next() {
            let (name, item) = table.entries.get_key_value(key)?;
            let start = if item.get_ref().is_table() { name.span().start } else { item.span().start };
            let value = Value { source: table.source, key: table.dotted(key), start, item };
            if keys.peek().is_none() {
                return Some(value);
            }
            table = value.table(String::new).ok()?;
        }
        None
    }

    fn dotted(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }
}

/// A value with its key and where it begins.
#[derive(Clone)]
pub(super) struct Value<'d> {
    source: &'d Source,
    key: String,
    start: usize,
    item: &'d Spanned<DeValue<'d>>,
}

impl<'d> Value<'d> {
    /// The error of this value, with a reason that says what is allowed.
    pub(super) fn refuse(&self, reason: impl Into<String>) -> CaseError {
        // A reason may repeat a file's name.
        CaseError::Refused { place: self.place(), reason: visible(&reason.into()) }
    }

    /// Where it is.
    pub(super) fn place(&self) -> Place {
        let piece = if self.item.get_ref().is_table() { None } else { self.source.piece(&self.item.span()) };
        Place::new(&self.source.name, self.source.line(self.start), &self.key, piece)
    }

    /// The error of a value of another type than is expected.
    pub(super) fn wrong(&self, expected: String) -> CaseError {
        let found = match self.item.get_ref() {
            DeValue::String(_) => "a text",
            DeValue::Integer(_) => "an integer",
            DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "an array",
            DeValue::Table(_) => "a table",
        };
        CaseError::WrongType { place: self.place(), found, expected }
    }

    /// A table; `expected` is what another type's message asks for.
    pub(super) fn table(&self, expected: impl FnOnce() -> String) -> Result<Table<'d>, CaseError> {
        match self.item.get_ref() {
            DeValue::Table(entries) => {
                Ok(Table { source: self.source, path: self.key.clone(), start: self.start, entries })
            }
            _ => Err(self.wrong(expected())),
        }
    }

    /// Name of the value's type in a JSON Schema.
    pub(super) fn kind(&self) -> &'static str {
        match self.item.get_ref() {
            DeValue::String(_) => "string",
            DeValue::Integer(_) | DeValue::Float(_) => "number",
            DeValue::Boolean(_) => "boolean",
            DeValue::Datetime(_) => "date",
            DeValue::Array(_) => "array",
            DeValue::Table(_) => "object",
        }
    }

    /// A text.
    pub(super) fn text(&self, expected: impl FnOnce() -> String) -> Result<&'d str, CaseError> {
        self.item.get_ref().as_str().ok_or_else(|| self.wrong(expected()))
    }

    /// True for an array.
    pub(super) fn is_array(&self) -> bool {
        self.item.get_ref().is_array()
    }

    /// A finite number; `expected` is what another type's message asks for.
    pub(super) fn number(&self, expected: impl FnOnce() -> String) -> Result<f64, CaseError> {
        match number(self.item.get_ref()) {
            None => Err(self.wrong(expected())),
            Some(number) if number.is_finite() => Ok(number),
            Some(_) => Err(self.refuse("a finite number is needed")),
        }
    }

    /// The entries of an array of at most `max` entries.
    pub(super) fn entries(&self, expected: impl FnOnce() -> String, max: usize) -> Result<Vec<Value<'d>>, CaseError> {
        let DeValue::Array(array) = self.item.get_ref() else {
            return Err(self.wrong(expected()));
        };
        if array.len() > max {
            return Err(self.refuse(format!("has {} entries; at most {max} are allowed", array.len())));
        }
        let entry = |(index, item): (usize, &'d Spanned<DeValue<'d>>)| Value {
            source: self.source,
            key: format!("{}[{index}]", self.key),
            start: item.span().start,
            item,
        };
        Ok(array.iter().enumerate().map(entry).collect())
    }

    /// The first entry below this value (at any depth) that is this number; the value itself if there is none.
    pub(super) fn entry_holding(&self, number: f64) -> Value<'d> {
        self.search(number).unwrap_or_else(|| self.clone())
    }

    fn search(&self, number: f64) -> Option<Value<'d>> {
        if self.is_array() {
            return self.entries(String::new, usize::MAX).ok()?.iter().find_map(|entry| entry.search(number));
        }
        (self.number(String::new).ok()?.to_bits() == number.to_bits()).then(|| self.clone())
    }
}

/// A number, which may be infinite; none for another type.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => Some(float.as_str().parse().unwrap_or(f64::INFINITY)),
        DeValue::Integer(integer) if integer.radix() == 10 => Some(integer.as_str().parse().unwrap_or(f64::INFINITY)),
        DeValue::Integer(integer) => {
            Some(i64::from_str_radix(integer.as_str(), integer.radix()).map_or(f64::INFINITY, |integer| integer as f64))
        }
        _ => None,
    }
}

fn json(value: &DeValue<'_>) -> Json {
    match value {
        DeValue::String(text) => Json::from(text.as_ref()),
        DeValue::Boolean(value) => Json::from(*value),
        DeValue::Datetime(date) => Json::from(date.to_string()),
        DeValue::Array(array) => array.iter().map(|item| json(item.get_ref())).collect(),
        DeValue::Table(table) => json_table(table),
        DeValue::Integer(_) | DeValue::Float(_) => number(value).map_or(Json::Null, Json::from),
    }
}

fn json_table(table: &DeTable<'_>) -> Json {
    table.iter().map(|(key, value)| (key.get_ref().to_string(), json(value.get_ref()))).collect()
}
