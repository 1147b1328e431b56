//! Parquet files.

use super::{Column, Values, float};
use bytes::Bytes;
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// All columns of the file. What is no number, text or truth value is an empty field; nothing is known of it.
pub(super) fn columns(bytes: Vec<u8>) -> Result<Vec<Column>, String> {
    // The crate gives errors for most damages and panics at some; these are found before, as far as known.
    let read = catch_unwind(AssertUnwindSafe(|| read(bytes)));
    read.unwrap_or_else(|_| Err("it is damaged".to_owned()))
}

/// No part of a file is longer than this when it is not compressed any more.
const LONGEST: i64 = 1 << 31;

/// Whether all parts lie in a file of this length.
fn is_whole(metadata: &ParquetMetaData, length: usize) -> bool {
    let groups = metadata.row_groups().iter();
    let mut parts = groups.flat_map(|group| group.columns());
    parts.all(|part| {
        let data = part.data_page_offset();
        let start = part
            .dictionary_page_offset()
            .map_or(data, |dictionary| dictionary.min(data));
        let size = part.compressed_size();
        let sizes = 0..=LONGEST;
        let end = start
            .checked_add(size)
            .and_then(|end| usize::try_from(end).ok());
        start >= 0
            && sizes.contains(&size)
            && sizes.contains(&part.uncompressed_size())
            && sizes.contains(&part.num_values())
            && end.is_some_and(|end| end <= length)
    })
}

fn read(bytes: Vec<u8>) -> Result<Vec<Column>, String> {
    let length = bytes.len();
    let reader =
        SerializedFileReader::new(Bytes::from(bytes)).map_err(|error| error.to_string())?;
    if !is_whole(reader.metadata(), length) {
        return Err("it is cut off or damaged".to_owned());
    }
    let schema = reader.metadata().file_metadata().schema_descr();
    let names: Vec<String> = { schema.root_schema().get_fields().iter() }
        .map(|field| field.name().to_owned())
        .collect();
    let mut lists: Vec<Vec<Field>> = names.iter().map(|_| Vec::new()).collect();
    for row in reader
        .get_row_iter(None)
        .map_err(|error| error.to_string())?
    {
        let row = row.map_err(|error| error.to_string())?;
        for (list, (_, field)) in lists.iter_mut().zip(row.into_columns()) {
            list.push(field);
        }
    }
    let columns = names.into_iter().zip(lists);
    Ok(columns
        .map(|(name, list)| Column {
            name,
            values: values(&list),
        })
        .collect())
}

fn values(list: &[Field]) -> Values {
    let float = |field: &Field| match field {
        Field::Double(x) => Some(*x),
        Field::Float(x) => Some(f64::from(*x)),
        // Not recorded, as NaN.
        Field::Null => Some(f64::NAN),
        _ => None,
    };
    let floats: Option<Vec<f64>> = list.iter().map(float).collect();
    match floats {
        Some(floats) => Values::Floats(floats),
        None => Values::Texts(list.iter().map(spelled).collect()),
    }
}

/// A value as it is written in a text table.
fn spelled(field: &Field) -> String {
    match field {
        Field::Bool(is) => u8::from(*is).to_string(),
        Field::Byte(x) => x.to_string(),
        Field::Short(x) => x.to_string(),
        Field::Int(x) => x.to_string(),
        Field::Long(x) => x.to_string(),
        Field::UByte(x) => x.to_string(),
        Field::UShort(x) => x.to_string(),
        Field::UInt(x) => x.to_string(),
        Field::ULong(x) => x.to_string(),
        Field::Float16(x) => float(x.to_f64()),
        Field::Float(x) => float(f64::from(*x)),
        Field::Double(x) => float(*x),
        Field::Str(text) => text.clone(),
        Field::Null => String::new(),
        // A date, a time of day, a decimal or something nested: told as it is, so that the message for it shows it.
        other => other.to_string(),
    }
}
