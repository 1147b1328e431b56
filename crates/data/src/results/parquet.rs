//! Tables as Parquet files, beside those of text.
//!
//! Bounds are stored as the floats that were proved: nothing is rounded. A time stamp is the float next to it.

use super::folder::{CompleteFile, ResultFile, ResultFolder};
use super::table::{Cell, Column};
use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::io;
use std::sync::Arc;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;

/// So many rows are collected before they are written.
const GROUP: usize = 1 << 16;

/// A table that is being written; memory does not grow with the number of rows.
pub(crate) struct ParquetTable {
    /// The file, until it is known what the columns hold.
    file: Option<ResultFile>,
    writer: Option<SerializedFileWriter<ResultFile>>,
    names: Vec<String>,
    columns: Vec<Values>,
    rows: usize,
}

/// The values of a column, and what it holds.
enum Values {
    /// Nothing yet.
    Unknown,
    /// Floats; none where the set is empty.
    Floats(Vec<Option<f64>>),
    Counts(Vec<i64>),
    Texts(Vec<ByteArray>),
}

impl std::fmt::Debug for ParquetTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ParquetTable")
            .field("names", &self.names)
            .finish_non_exhaustive()
    }
}

impl ParquetTable {
    /// Starts the twin of the text table `name`; the first column is the time where there is one.
    pub(crate) fn create(
        folder: &ResultFolder,
        name: &str,
        (columns, has_time): (&[Column], bool),
    ) -> Result<ParquetTable, Diagnostic> {
        let stem = name.strip_suffix(".csv").unwrap_or(name);
        let mut names = Vec::new();
        let mut values = Vec::new();
        if has_time {
            names.push("t".to_owned());
            values.push(Values::Floats(Vec::new()));
        }
        for column in columns {
            match column {
                Column::Bounds(name) | Column::Parameter(name, _) => {
                    names.extend([format!("{name}.lo"), format!("{name}.hi")]);
                    values.extend([Values::Floats(Vec::new()), Values::Floats(Vec::new())]);
                }
                Column::Plain(name) => {
                    names.push(name.clone());
                    values.push(Values::Unknown);
                }
            }
        }
        Ok(ParquetTable {
            file: Some(folder.file(&format!("{stem}.parquet"))?),
            writer: None,
            names,
            columns: values,
            rows: 0,
        })
    }

    /// Takes a row that fits the columns.
    pub(crate) fn row(
        &mut self,
        time: Option<&Decimal>,
        cells: &[Cell<'_>],
    ) -> Result<(), Diagnostic> {
        let mut columns = self.columns.iter_mut();
        let mut put = |cell: Cell<'_>| {
            if let Some(column) = columns.next() {
                column.push(cell);
            }
        };
        if let Some(time) = time {
            put(Cell::Float(time.to_interval().mid()));
        }
        for cell in cells {
            match *cell {
                Cell::Bounds(x) | Cell::Exact(x) => {
                    let end = |end: fn(Interval) -> f64| {
                        if x.is_empty() { f64::NAN } else { end(x) }
                    };
                    put(Cell::Float(end(Interval::lo)));
                    put(Cell::Float(end(Interval::hi)));
                }
                other => put(other),
            }
        }
        self.rows += 1;
        if self.rows == GROUP {
            self.flush()
        } else {
            Ok(())
        }
    }

    /// Ends the table.
    pub(crate) fn finish(mut self) -> Result<CompleteFile, Diagnostic> {
        self.flush()?;
        let writer = self
            .writer
            .take()
            .ok_or_else(|| unwritten("there is no writer"))?;
        let file = writer.into_inner().map_err(|error| refuse(&error))?;
        file.finish()
    }

    /// Writes the rows at hand; starts the file where that was not done.
    fn flush(&mut self) -> Result<(), Diagnostic> {
        if let Some(file) = self.file.take() {
            self.writer = Some(self.start(file).map_err(|error| refuse(&error))?);
        }
        if self.rows > 0
            && let Some(writer) = &mut self.writer
        {
            write_group(writer, &mut self.columns).map_err(|error| refuse(&error))?;
        }
        self.rows = 0;
        Ok(())
    }

    fn start(&self, file: ResultFile) -> Result<SerializedFileWriter<ResultFile>, ParquetError> {
        let fields = self.names.iter().zip(&self.columns).map(|(name, values)| {
            let (physical, logical, repetition) = match values {
                Values::Floats(_) => (Physical::DOUBLE, None, Repetition::OPTIONAL),
                Values::Counts(_) => (Physical::INT64, None, Repetition::REQUIRED),
                Values::Unknown | Values::Texts(_) => (
                    Physical::BYTE_ARRAY,
                    Some(LogicalType::String),
                    Repetition::REQUIRED,
                ),
            };
            let field = Type::primitive_type_builder(name, physical);
            let field = field.with_repetition(repetition).with_logical_type(logical);
            field.build().map(Arc::new)
        });
        let fields = fields.collect::<Result<Vec<_>, _>>()?;
        let schema = Type::group_type_builder("table")
            .with_fields(fields)
            .build()?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY);
        SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties.build()))
    }
}

impl Values {
    fn push(&mut self, cell: Cell<'_>) {
        if matches!(self, Values::Unknown) {
            *self = match cell {
                Cell::Count(_) => Values::Counts(Vec::new()),
                Cell::Text(_) => Values::Texts(Vec::new()),
                _ => Values::Floats(Vec::new()),
            };
        }
        // A column holds one kind of cells, as in a text table.
        match (self, cell) {
            (Values::Floats(list), Cell::Float(x)) => list.push((!x.is_nan()).then_some(x)),
            (Values::Floats(list), _) => list.push(None),
            (Values::Counts(list), Cell::Count(count)) => list.push(count as i64),
            (Values::Counts(list), _) => list.push(-1),
            (Values::Texts(list), Cell::Text(text)) => list.push(ByteArray::from(text)),
            (Values::Texts(list), _) => list.push(ByteArray::from("")),
            (Values::Unknown, _) => {}
        }
    }
}

fn write_group(
    writer: &mut SerializedFileWriter<ResultFile>,
    columns: &mut [Values],
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for values in columns {
        let Some(mut column) = group.next_column()? else {
            break;
        };
        match values {
            Values::Floats(list) => {
                let levels: Vec<i16> = list.iter().map(|x| i16::from(x.is_some())).collect();
                let known: Vec<f64> = list.drain(..).flatten().collect();
                column
                    .typed::<DoubleType>()
                    .write_batch(&known, Some(&levels), None)?;
            }
            Values::Counts(list) => {
                column.typed::<Int64Type>().write_batch(list, None, None)?;
                list.clear();
            }
            Values::Texts(list) => {
                column
                    .typed::<ByteArrayType>()
                    .write_batch(list, None, None)?;
                list.clear();
            }
            Values::Unknown => {}
        }
        column.close()?;
    }
    group.close()?;
    Ok(())
}

/// A full disk comes out of the library as an error of its own; the file tells the rest at its end.
fn refuse(error: &ParquetError) -> Diagnostic {
    let mut inner: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(one) = inner {
        if let Some(io) = one.downcast_ref::<io::Error>() {
            return crate::failure::unwritable("a Parquet table", io);
        }
        inner = one.source();
    }
    unwritten(&error.to_string())
}

fn unwritten(what: &str) -> Diagnostic {
    Diagnostic::new(
        "E0503",
        format!("a table cannot be written as Parquet: {what}"),
    )
    .help("leave out `--parquet`")
}

#[cfg(test)]
mod tests {
    use super::super::table::TableWriter;
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;

    #[test]
    fn a_table_has_its_twin_with_the_floats_themselves() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultFolder::create(place.path())
            .unwrap()
            .with_parquet(true);
        let columns = vec![
            Column::Bounds("phi".into()),
            Column::plain("modes"),
            Column::plain("boxes"),
        ];
        let mut table = TableWriter::create(&folder, "states.csv", columns).unwrap();
        let third = Interval::ONE / Interval::point(3.0);
        let rows = [
            (third, "a,b"),
            (Interval::EMPTY, ""),
            (Interval::ENTIRE, "ä"),
        ];
        for (k, (bounds, modes)) in rows.iter().enumerate() {
            let time = Decimal::parse(&format!("0.{k}")).unwrap();
            let cells = [Cell::Bounds(*bounds), Cell::Text(modes), Cell::Count(k)];
            table.row(&time, &cells).unwrap();
        }
        table.finish().unwrap().put_in_place().unwrap();
        let file = std::fs::File::open(place.path().join("states.parquet")).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let rows: Vec<Vec<Field>> = { reader.get_row_iter(None).unwrap() }
            .map(|row| {
                row.unwrap()
                    .into_columns()
                    .into_iter()
                    .map(|(_, field)| field)
                    .collect()
            })
            .collect();
        let (lo, hi) = (Field::Double(third.lo()), Field::Double(third.hi()));
        let text = |text: &str| Field::Str(text.to_owned());
        assert_eq!(
            rows[0],
            [Field::Double(0.0), lo, hi, text("a,b"), Field::Long(0)]
        );
        assert_eq!(
            rows[1],
            [
                Field::Double(0.1),
                Field::Null,
                Field::Null,
                text(""),
                Field::Long(1)
            ]
        );
        let (lo, hi) = (
            Field::Double(f64::NEG_INFINITY),
            Field::Double(f64::INFINITY),
        );
        assert_eq!(
            rows[2],
            [Field::Double(0.2), lo, hi, text("ä"), Field::Long(2)]
        );
    }

    #[test]
    fn a_table_without_rows_is_one() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultFolder::create(place.path())
            .unwrap()
            .with_parquet(true);
        let columns = vec![Column::Bounds("k".into()), Column::plain("status")];
        let table = TableWriter::timeless(&folder, "paving.csv", columns).unwrap();
        table.finish().unwrap().put_in_place().unwrap();
        let file = std::fs::File::open(place.path().join("paving.parquet")).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        assert_eq!(reader.metadata().file_metadata().num_rows(), 0);
        assert_eq!(
            reader
                .metadata()
                .file_metadata()
                .schema_descr()
                .num_columns(),
            3
        );
    }
}
