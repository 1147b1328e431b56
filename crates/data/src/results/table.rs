//! CSV tables of a run, one row per sample, written as the run goes on.

use super::folder::{CompleteFile, ResultFile, ResultFolder};
use super::parquet::ParquetTable;
use crate::outward;
use std::fmt::Write as _;
use std::io::{self, Write};
use veribound_interval::{Decimal, Interval, text};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::model::Model;

/// A column of a table.
///
/// ```
/// use veribound_data::Column;
/// use veribound_model::Model;
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 0\nder.x = 1\noutputs.y = \"x +- 0.1\"";
/// let columns = Column::of_states(&Model::from_text("clock.toml", text)?);
/// assert_eq!(columns[0], Column::Bounds("x".to_string()));
/// assert_eq!(columns[2], Column::plain("boxes"));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Bounds of a variable: the two columns `name.lo` and `name.hi`.
    Bounds(String),
    /// The same of a parameter with this prior: an end at which nothing was cut off the prior is
    /// printed as the user spelled it.
    Parameter(String, Interval),
    /// Anything else under its name.
    Plain(String),
}

/// What stands in a row below one [`Column`].
///
/// ```
/// use veribound_data::Cell;
///
/// let row = [Cell::Count(3), Cell::Text("forward|stick"), Cell::Float(0.25)];
/// assert!(matches!(row[1], Cell::Text(names) if names.contains("stick")));
/// ```
#[derive(Debug, Clone, Copy)]
pub enum Cell<'a> {
    /// Printed outward with 12 significant digits; two empty fields for the empty set.
    Bounds(Interval),
    /// Every digit of both ends, so that neighbours still share them; two empty fields for the empty set.
    Exact(Interval),
    /// A number of things.
    Count(usize),
    /// A duration in seconds, or another number that is no bound.
    Float(f64),
    /// A text, quoted where it must be.
    Text(&'a str),
}

/// Writes one CSV table; it is complete when [`TableWriter::finish`] is called. Where the folder asks for it, the same
/// table is written as a Parquet file: its bounds are the proved floats themselves, time stamps the floats next to
/// them, and a text or number is of the type that it is.
///
/// *Guarantee*: a printed lower (upper) bound is not above (below) the bound it stands for.
///
/// *Cost*: memory does not grow with the number of rows.
///
/// ```
/// use veribound_data::{Cell, Column, ResultFolder, TableWriter};
/// use veribound_interval::{Decimal, Interval};
/// # use veribound_model::Model;
/// # let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = 0\nparams.k = [0, 2]\nder.x = \"k\"\noutputs.y = \"x +- 0.1\"";
/// # let model = Model::from_text("slide.toml", text)?;
/// # let place = std::env::temp_dir().join(format!("veribound-doc-table-{}", std::process::id()));
/// let folder = ResultFolder::create(&place)?;
/// let mut table = TableWriter::create(&folder, "params.csv", Column::of_params(&model))?;
/// let third = Interval::new(1.0 / 3.0, 2.0 / 3.0).unwrap();
/// table.row(&Decimal::zero(), &[Cell::Bounds(third), Cell::Text("")])?;
/// folder.publish(vec![table.finish()?])?;
/// let text = std::fs::read_to_string(place.join("params.csv"))?;
/// assert_eq!(text, "t,k.lo,k.hi,resets\n0,0.333333333333,0.666666666667,\n");
/// # std::fs::remove_dir_all(place)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TableWriter {
    file: ResultFile,
    twin: Option<ParquetTable>,
    columns: Vec<Column>,
    /// By column: the prior and its ends as they were spelled.
    priors: Vec<Option<(Interval, (String, String))>>,
    line: String,
}

impl Column {
    /// The columns of `states.csv`: bounds of every state, then `modes` and `boxes`.
    pub fn of_states(model: &Model) -> Vec<Column> {
        let bounds = model
            .states
            .iter()
            .map(|state| Column::Bounds(state.name.clone()));
        bounds
            .chain(["modes", "boxes"].map(Column::plain))
            .collect()
    }

    /// The columns of `params.csv`: bounds of every parameter, then `resets`.
    pub fn of_params(model: &Model) -> Vec<Column> {
        let bounds = model
            .params
            .iter()
            .map(|param| Column::Parameter(param.name.clone(), param.bounds));
        bounds.chain(["resets"].map(Column::plain)).collect()
    }

    /// The columns of `boxes.csv`: number of the box, bounds of every state and parameter, then
    /// `modes`.
    pub fn of_boxes(model: &Model) -> Vec<Column> {
        let states = model
            .states
            .iter()
            .map(|state| Column::Bounds(state.name.clone()));
        let params = model
            .params
            .iter()
            .map(|param| Column::Parameter(param.name.clone(), param.bounds));
        let first = ["box"].map(Column::plain).into_iter();
        first
            .chain(states)
            .chain(params)
            .chain(["modes"].map(Column::plain))
            .collect()
    }

    /// The columns of `tube.csv`: bounds of every state and output at the time, then since the time before, then
    /// `modes`.
    pub fn of_tube(model: &Model) -> Vec<Column> {
        let states = model.states.iter().map(|state| state.name.clone());
        let outputs = model.outputs.iter().map(|output| output.name.clone());
        let names: Vec<String> = states.chain(outputs).collect();
        let since = names.iter().map(|name| format!("{name}.since"));
        let bounds = names.iter().cloned().chain(since).map(Column::Bounds);
        bounds.chain(["modes"].map(Column::plain)).collect()
    }

    /// The columns of `parts.csv`: number of the part, bounds of every state at its start and of every parameter,
    /// then of every state at the end.
    pub fn of_parts(model: &Model) -> Vec<Column> {
        let starts = model.states.iter();
        let starts =
            starts.map(|state| Column::Parameter(format!("{}.start", state.name), state.init));
        let params = model.params.iter();
        let params = params.map(|param| Column::Parameter(param.name.clone(), param.bounds));
        let ends = model
            .states
            .iter()
            .map(|state| Column::Bounds(state.name.clone()));
        let first = ["part"].map(Column::plain).into_iter();
        first.chain(starts).chain(params).chain(ends).collect()
    }

    /// The columns of `points.csv`: number of the point, and bounds of every parameter of it.
    pub fn of_points(model: &Model) -> Vec<Column> {
        let params = model.params.iter();
        let params = params.map(|param| Column::Bounds(param.name.clone()));
        let first = ["point"].map(Column::plain).into_iter();
        first.chain(params).collect()
    }

    /// The columns of `paving.csv`: bounds of every parameter, then `status` and `reason`.
    pub fn of_paving(model: &Model) -> Vec<Column> {
        let params = model.params.iter();
        let params = params.map(|param| Column::Parameter(param.name.clone(), param.bounds));
        let last = ["status", "reason"].map(Column::plain);
        params.chain(last).collect()
    }

    /// The columns of `turned.csv`: number of the frame, bounds of so many coordinates, then `status` and `reason`.
    pub fn of_turned(axes: usize) -> Vec<Column> {
        let coordinates = (1..=axes).map(|axis| Column::Bounds(format!("y{axis}")));
        let first = [Column::plain("frame")].into_iter();
        let last = ["status", "reason"].map(Column::plain);
        first.chain(coordinates).chain(last).collect()
    }

    /// The columns of `frames.csv`: number of the frame; of every parameter its middle, and by how much each of so many
    /// coordinates changes it.
    pub fn of_frames(model: &Model, axes: usize) -> Vec<Column> {
        let mut columns = vec![Column::plain("frame")];
        for param in &model.params {
            columns.push(Column::Plain(format!("{}.middle", param.name)));
            let slopes = (1..=axes).map(|axis| Column::Plain(format!("{}.y{axis}", param.name)));
            columns.extend(slopes);
        }
        columns
    }

    /// A column of anything but bounds.
    pub fn plain(name: &str) -> Column {
        Column::Plain(name.to_owned())
    }

    fn spelled_prior(&self) -> Option<(Interval, (String, String))> {
        match self {
            Column::Parameter(_, prior) => Some((*prior, text::spelled(*prior))),
            _ => None,
        }
    }

    fn has_bounds(&self) -> bool {
        !matches!(self, Column::Plain(_))
    }
}

impl TableWriter {
    /// Starts the table `name` in `folder`; its first column is the time `t`.
    ///
    /// *Errors*: `E0501`, `E0502`.
    pub fn create(
        folder: &ResultFolder,
        name: &str,
        columns: Vec<Column>,
    ) -> Result<Self, Diagnostic> {
        Self::start(folder, name, columns, String::from("t,"))
    }

    /// Starts a table of what holds at no time of its own: it has the columns named, and no other.
    ///
    /// *Errors*: `E0501`, `E0502`.
    pub fn timeless(
        folder: &ResultFolder,
        name: &str,
        columns: Vec<Column>,
    ) -> Result<Self, Diagnostic> {
        Self::start(folder, name, columns, String::new())
    }

    fn start(
        folder: &ResultFolder,
        name: &str,
        columns: Vec<Column>,
        first: String,
    ) -> Result<Self, Diagnostic> {
        let mut table = TableWriter {
            file: folder.file(name)?,
            twin: { folder.has_parquet() }
                .then(|| ParquetTable::create(folder, name, (&columns, !first.is_empty())))
                .transpose()?,
            priors: columns.iter().map(Column::spelled_prior).collect(),
            columns,
            line: first,
        };
        for column in &table.columns {
            match column {
                Column::Bounds(name) | Column::Parameter(name, _) => {
                    push_text(&mut table.line, &format!("{name}.lo"));
                    table.line.push(',');
                    push_text(&mut table.line, &format!("{name}.hi"));
                }
                Column::Plain(name) => push_text(&mut table.line, name),
            }
            table.line.push(',');
        }
        table.write_line()?;
        Ok(table)
    }

    /// Writes one row: the time stamp, then one cell for every column.
    ///
    /// *Errors*: `E0501`, `E0502`; `E0503` when the cells do not fit the columns.
    pub fn row(&mut self, time: &Decimal, cells: &[Cell<'_>]) -> Result<(), Diagnostic> {
        self.line.clear();
        // Writing to a String cannot fail.
        let _ = write!(self.line, "{time},");
        self.push_cells(Some(time), cells)
    }

    /// Writes one row of a table without times: one cell for every column.
    ///
    /// *Errors*: `E0501`, `E0502`; `E0503` when the cells do not fit the columns.
    pub fn timeless_row(&mut self, cells: &[Cell<'_>]) -> Result<(), Diagnostic> {
        self.line.clear();
        self.push_cells(None, cells)
    }

    fn push_cells(&mut self, time: Option<&Decimal>, cells: &[Cell<'_>]) -> Result<(), Diagnostic> {
        let fits = |(column, cell): (&Column, &Cell<'_>)| {
            column.has_bounds() == matches!(cell, Cell::Bounds(_) | Cell::Exact(_))
        };
        if cells.len() != self.columns.len() || !self.columns.iter().zip(cells).all(fits) {
            return Err(Diagnostic::new(
                "E0503",
                format!(
                    "{} cells do not fit the {} columns of a table",
                    cells.len(),
                    self.columns.len()
                ),
            ));
        }
        if let Some(twin) = &mut self.twin {
            twin.row(time, cells)?;
        }
        for (cell, prior) in cells.iter().zip(&self.priors) {
            let is_exact = matches!(cell, Cell::Exact(_));
            match *cell {
                Cell::Bounds(bounds) | Cell::Exact(bounds) if bounds.is_empty() => {
                    self.line.push(',');
                }
                Cell::Bounds(bounds) | Cell::Exact(bounds) => {
                    let untouched = |end: fn(Interval) -> f64| {
                        prior
                            .as_ref()
                            .filter(|(prior, _)| end(*prior) == end(bounds))
                    };
                    match untouched(Interval::lo) {
                        Some((_, (lo, _))) => self.line.push_str(lo),
                        None if is_exact => self.line.push_str(&text::exact(bounds.lo())),
                        None => self.line.push_str(&outward::lower(bounds)),
                    }
                    self.line.push(',');
                    match untouched(Interval::hi) {
                        Some((_, (_, hi))) => self.line.push_str(hi),
                        None if is_exact => self.line.push_str(&text::exact(bounds.hi())),
                        None => self.line.push_str(&outward::upper(bounds)),
                    }
                }
                Cell::Count(count) => {
                    let _ = write!(self.line, "{count}");
                }
                Cell::Float(number) => {
                    let _ = write!(self.line, "{number}");
                }
                Cell::Text(text) => push_text(&mut self.line, text),
            }
            self.line.push(',');
        }
        self.write_line()
    }

    /// Ends the table.
    ///
    /// *Errors*: `E0501`, `E0502`; nothing of the table is left then.
    pub fn finish(self) -> Result<CompleteFile, Diagnostic> {
        let file = self.file.finish()?;
        match self.twin {
            Some(twin) => Ok(file.with(twin.finish()?)),
            None => Ok(file),
        }
    }

    /// Writes the fields at hand, each with a comma behind it.
    fn write_line(&mut self) -> Result<(), Diagnostic> {
        self.line.pop();
        self.line.push('\n');
        let written: io::Result<()> = self.file.write_all(self.line.as_bytes());
        written.map_err(|error| self.file.refuse(&error))
    }
}

/// Appends one field, quoted where a reader would split it.
fn push_text(line: &mut String, text: &str) {
    if text.contains([',', '"', '\n', '\r']) {
        line.push('"');
        line.push_str(&text.replace('"', "\"\""));
        line.push('"');
    } else {
        line.push_str(text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_model::diagnostic::Diagnostics;

    #[test]
    fn rows_are_printed_outward_and_quoted() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultFolder::create(place.path()).unwrap();
        let columns = vec![
            Column::Bounds("phi".into()),
            Column::plain("modes"),
            Column::plain("boxes"),
        ];
        let mut table = TableWriter::create(&folder, "states.csv", columns).unwrap();
        let time = Decimal::parse("0.10").unwrap();
        let third = Interval::ONE / Interval::point(3.0);
        let tenth = time.to_interval();
        let rows = [
            (third, "a,b"),
            (tenth, "a"),
            (Interval::EMPTY, "say \"x\""),
            (Interval::ENTIRE, ""),
        ];
        for (bounds, modes) in rows {
            let cells = [Cell::Bounds(bounds), Cell::Text(modes), Cell::Count(3)];
            table.row(&time, &cells).unwrap();
        }
        let wrong = table.row(&time, &[Cell::Count(1), Cell::Text(""), Cell::Count(3)]);
        let said = Diagnostics::from(wrong.unwrap_err()).render(false);
        assert_eq!(
            said,
            "error[E0503]: 3 cells do not fit the 3 columns of a table\n"
        );
        table.finish().unwrap().put_in_place().unwrap();
        let expected = "t,phi.lo,phi.hi,modes,boxes\n\
            0.1,0.333333333333,0.333333333334,\"a,b\",3\n\
            0.1,0.0999999999999,0.100000000001,a,3\n\
            0.1,,,\"say \"\"x\"\"\",3\n\
            0.1,-inf,inf,,3\n";
        let written = std::fs::read_to_string(place.path().join("states.csv")).unwrap();
        assert_eq!(written, expected);
    }

    #[test]
    fn tiles_share_their_ends_and_have_those_of_the_prior() {
        let place = tempfile::tempdir().unwrap();
        let folder = ResultFolder::create(place.path()).unwrap();
        let prior = Decimal::parse("-0.3").unwrap().to_interval();
        let prior = prior.hull(Decimal::parse("-0.05").unwrap().to_interval());
        let columns = vec![
            Column::Parameter("k".into(), prior),
            Column::plain("status"),
        ];
        let mut table = TableWriter::timeless(&folder, "paving.csv", columns).unwrap();
        let third = -1.0 / 3.0 + 0.25;
        for (lo, hi) in [(prior.lo(), third), (third, prior.hi())] {
            let tile = Interval::new(lo, hi).unwrap();
            let cells = [Cell::Exact(tile), Cell::Text("outside")];
            table.timeless_row(&cells).unwrap();
        }
        table.finish().unwrap().put_in_place().unwrap();
        let exact = "-0.083333333333333314829616256247390992939472198486328125";
        let expected = format!("k.lo,k.hi,status\n-0.3,{exact},outside\n{exact},-0.05,outside\n");
        let written = std::fs::read_to_string(place.path().join("paving.csv")).unwrap();
        assert_eq!(written, expected);
    }
}
