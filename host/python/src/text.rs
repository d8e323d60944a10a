//! TOML as Python's dictionaries and back: Python 3.10 reads no TOML, and no Python writes it. Numbers that are not finite survive, so
//! that the case's reader refuses them by their keys.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyInt, PyList};
use toml_edit::{DocumentMut, InlineTable, Item, Table, Value};

use crate::error::value;

/// A TOML text as a dictionary.
#[pyfunction]
pub(crate) fn from_toml<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyDict>> {
    let document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| value(error.to_string()))?;
    read_table(py, document.as_table())
}

/// A dictionary as TOML: tables below tables, everything else in a line. A None is left out.
#[pyfunction]
pub(crate) fn to_toml(table: &Bound<'_, PyDict>) -> PyResult<String> {
    Ok(DocumentMut::from(write_table(table)?).to_string())
}

fn read_table<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    for (key, item) in table {
        match item {
            Item::None => {}
            Item::Value(value) => found.set_item(key, read(py, value)?)?,
            Item::Table(below) => found.set_item(key, read_table(py, below)?)?,
            Item::ArrayOfTables(tables) => {
                let tables = tables.iter().map(|table| read_table(py, table)).collect::<PyResult<Vec<_>>>()?;
                found.set_item(key, tables)?;
            }
        }
    }
    Ok(found)
}

fn read<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::String(text) => text.value().into_pyobject(py)?.into_any(),
        Value::Integer(number) => number.value().into_pyobject(py)?.into_any(),
        Value::Float(number) => number.value().into_pyobject(py)?.into_any(),
        Value::Boolean(flag) => PyBool::new(py, *flag.value()).to_owned().into_any(),
        Value::Datetime(date) => date.value().to_string().into_pyobject(py)?.into_any(),
        Value::Array(items) => {
            let items = items.iter().map(|item| read(py, item)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, items)?.into_any()
        }
        Value::InlineTable(below) => {
            let found = PyDict::new(py);
            for (key, value) in below {
                found.set_item(key, read(py, value)?)?;
            }
            found.into_any()
        }
    })
}

fn write_table(entries: &Bound<'_, PyDict>) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in entries.iter().filter(|(_, value)| !value.is_none()) {
        let item = match value.cast::<PyDict>() {
            Ok(below) => Item::Table(write_table(below)?),
            Err(_) => Item::Value(write(&value)?),
        };
        table.insert(&key.extract::<String>()?, item);
    }
    Ok(table)
}

fn write(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if let Ok(below) = value.cast::<PyDict>() {
        let mut table = InlineTable::new();
        for (key, value) in below.iter().filter(|(_, value)| !value.is_none()) {
            table.insert(&key.extract::<String>()?, write(&value)?);
        }
        return Ok(table.into());
    }
    if let Ok(items) = value.cast::<PyList>() {
        return Ok(Value::Array(items.iter().map(|item| write(&item)).collect::<PyResult<_>>()?));
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(text.into());
    }
    match value.cast::<PyInt>().map(|number| number.extract::<i64>()) {
        Ok(Ok(integer)) => Ok(integer.into()),
        // An integer that TOML has no room for is a number all the same.
        _ => Ok(value.extract::<f64>()?.into()),
    }
}
