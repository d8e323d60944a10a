//! Tables as Apache Parquet files, for pandas, Polars, DuckDB and their like. Not known is null.

use std::io::Write;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, FloatType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use crate::table::{Column, Kind, Table, Values};

/// Why a Parquet file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("the Parquet file cannot be written: {0}")]
pub struct ParquetError(#[from] ::parquet::errors::ParquetError);

/// A Parquet file that is being written.
pub struct Writer<W: Write + Send> {
    file: SerializedFileWriter<W>,
}

impl<W: Write + Send> Writer<W> {
    /// Begins a file with the columns of a table; `notes` are kept with it as keys and values.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(out: W, table: &Table, notes: &[(&str, String)]) -> Result<Self, ParquetError> {
        let notes = notes.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("fre ", env!("CARGO_PKG_VERSION")).to_owned())
            .set_key_value_metadata(Some(notes))
            .build();
        let fields = table.columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        Ok(Self { file: SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))? })
    }

    /// Writes the rows of a table, which has the columns of the first one, as a group of rows.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&mut self, table: &Table) -> Result<(), ParquetError> {
        if table.rows() == 0 {
            return Ok(());
        }
        let mut group = self.file.next_row_group()?;
        for column in &table.columns {
            write_column(&mut group, &column.values)?;
        }
        group.close()?;
        Ok(())
    }

    /// Writes the end; gives back what was written to.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(self) -> Result<W, ParquetError> {
        Ok(self.file.into_inner()?)
    }
}

/// A column of the schema; everything may be null.
fn field(column: &Column) -> Result<TypePtr, ParquetError> {
    let name = column.name.as_str();
    let plain = |physical| Type::primitive_type_builder(name, physical).with_repetition(Repetition::OPTIONAL);
    let field = match column.values.kind() {
        Kind::Number => plain(Physical::DOUBLE).build()?,
        Kind::Single => plain(Physical::FLOAT).build()?,
        Kind::Integer => plain(Physical::INT64).build()?,
        Kind::Flag => plain(Physical::BOOLEAN).build()?,
        Kind::Word => plain(Physical::BYTE_ARRAY).with_logical_type(Some(LogicalType::String)).build()?,
        Kind::List => {
            let element = Type::primitive_type_builder("element", Physical::DOUBLE)
                .with_repetition(Repetition::REQUIRED)
                .build()?;
            let list = Type::group_type_builder("list")
                .with_repetition(Repetition::REPEATED)
                .with_fields(vec![Arc::new(element)])
                .build()?;
            Type::group_type_builder(name)
                .with_repetition(Repetition::REQUIRED)
                .with_logical_type(Some(LogicalType::List))
                .with_fields(vec![Arc::new(list)])
                .build()?
        }
    };
    Ok(Arc::new(field))
}

fn write_column<W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &Values,
) -> Result<(), ParquetError> {
    match values {
        Values::Number(values) => {
            optional::<DoubleType, W>(group, values.iter().map(|value| (!value.is_nan()).then_some(*value)))
        }
        Values::Single(values) => {
            optional::<FloatType, W>(group, values.iter().map(|value| (!value.is_nan()).then_some(*value)))
        }
        Values::Integer(values) => optional::<Int64Type, W>(group, values.iter().copied()),
        Values::Flag(values) => optional::<BoolType, W>(group, values.iter().copied()),
        Values::Word(values) => {
            let bytes = |word: &String| ByteArray::from(word.as_bytes().to_vec());
            optional::<ByteArrayType, W>(group, values.iter().map(|word| word.as_ref().map(bytes)))
        }
        Values::List(lists) => {
            // A list's first entry begins a row (0), the others go on with it (1); an empty list has none (level 0).
            let repeated = lists.iter().flat_map(|list| (0..list.len().max(1)).map(|entry| i16::from(entry > 0)));
            let defined =
                lists.iter().flat_map(|list| std::iter::repeat_n(i16::from(!list.is_empty()), list.len().max(1)));
            let (repeated, defined): (Vec<i16>, Vec<i16>) = (repeated.collect(), defined.collect());
            let entries: Vec<f64> = lists.iter().flatten().copied().collect();
            write_values::<DoubleType, W>(group, &entries, &defined, Some(&repeated))
        }
    }
}

/// Values of which some are not known.
fn optional<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: impl Iterator<Item = Option<T::T>>,
) -> Result<(), ParquetError> {
    let (mut known, mut defined) = (Vec::new(), Vec::new());
    for value in values {
        defined.push(i16::from(value.is_some()));
        known.extend(value);
    }
    write_values::<T, W>(group, &known, &defined, None)
}

fn write_values<T: DataType, W: Write + Send>(
    group: &mut SerializedRowGroupWriter<'_, W>,
    values: &[T::T],
    defined: &[i16],
    repeated: Option<&[i16]>,
) -> Result<(), ParquetError> {
    if let Some(mut column) = group.next_column()? {
        column.typed::<T>().write_batch(values, Some(defined), repeated)?;
        column.close()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader as _, SerializedFileReader};

    use super::Writer;
    use crate::table::{Kind, Table};

    #[test]
    fn what_is_written_is_read_again() {
        let kind = |name: &str| match name {
            "n" => Kind::Integer,
            "s" => Kind::Word,
            "b" => Kind::Flag,
            "f" => Kind::Single,
            "l" => Kind::List,
            _ => Kind::Number,
        };
        let mut table = Table::new(["n", "object.radius_mm", "s", "b", "f", "l"], kind);
        assert!(table.take("1,0.1,folded,true,0.5,1 2.5") && table.take(",,,,,") && table.take("3,3,a,false,1,7"));
        let mut writer = Writer::new(Vec::new(), &table, &[("fre.test", "note".to_owned())]).unwrap();
        writer.write(&table).unwrap();
        table.clear();
        writer.write(&table).unwrap();
        assert!(table.take("4,4,b,,,"));
        writer.write(&table).unwrap();
        let bytes = writer.finish().unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let notes = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert_eq!((notes[0].key.as_str(), notes[0].value.as_deref()), ("fre.test", Some("note")));
        let rows: Vec<String> = reader.get_row_iter(None).unwrap().map(|row| row.unwrap().to_string()).collect();
        let expected = [
            "{n: 1, object.radius_mm: 0.1, s: \"folded\", b: true, f: 0.5, l: [1.0, 2.5]}",
            "{n: null, object.radius_mm: null, s: null, b: null, f: null, l: []}",
            "{n: 3, object.radius_mm: 3.0, s: \"a\", b: false, f: 1.0, l: [7.0]}",
            "{n: 4, object.radius_mm: 4.0, s: \"b\", b: null, f: null, l: []}",
        ];
        assert_eq!(rows, expected);
    }
}
