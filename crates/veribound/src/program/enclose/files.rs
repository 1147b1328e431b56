//! The files of an enclosure.

use super::super::arguments::Format;
use super::super::files::{drawn_modes, figure_meta, joined, undrawable, write_figures};
use super::super::flags::PlaneFlag;
use super::super::message::{flag_problem, list};
use super::Findings;
use veribound_data::{Cell, Column, ResultFolder, RunInfo, TableWriter};
use veribound_flow::ModeSet;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::{Model, Node, Var};
use veribound_report::{FigureMeta, Page, Plots, ReportError, Tube, TubeRow, Zoom};

/// So many trajectories are drawn.
const MOST_DRAWN: usize = 24;

/// Two states by their positions.
pub type Plane = Option<(usize, usize)>;

/// The states of the phase plane: as asked for, or a state with its rate, or the first two.
pub fn plane(model: &Model, asked: &PlaneFlag) -> Result<Plane, Diagnostic> {
    let names = || model.states.iter().map(|state| state.name.as_str());
    match asked {
        PlaneFlag::Off => Ok(None),
        PlaneFlag::Auto => {
            Ok(position_and_rate(model).or((model.states.len() > 1).then_some((0, 1))))
        }
        PlaneFlag::States(x, y) => {
            let place = |name: &str, at: usize| {
                let found = names().position(|known| known == name);
                found.ok_or_else(|| {
                    let message = format!("the model has no state `{name}`");
                    let typed = format!("{x},{y}");
                    let place = ("--plane", typed.as_str(), at..at + name.len());
                    let help = format!("it has {}", list(names()));
                    flag_problem("E0601", message, place, "unknown", help)
                })
            };
            Ok(Some((place(x, 0)?, place(y, x.len() + 1)?)))
        }
    }
}

/// The first state whose rate is another state, with that one.
fn position_and_rate(model: &Model) -> Plane {
    (0..model.states.len()).find_map(|state| {
        let mut rates = model.governing(state).map(|(_, rate)| rate);
        let rate = rates.next()?;
        match model.graph.node(rate) {
            Node::Var(Var::State(other)) if rates.all(|next| next == rate) => Some((state, *other)),
            _ => None,
        }
    })
}

/// What is proved at one row of the table, and since the row before.
pub struct Row<'f> {
    /// States now.
    pub states: &'f [Interval],
    /// Outputs now.
    pub outputs: Vec<Interval>,
    /// States at all times since the row before.
    pub states_since: &'f [Interval],
    /// Outputs at all times since the row before.
    pub outputs_since: Vec<Interval>,
    /// Modes that may have acted since the row before.
    pub modes: ModeSet,
}

impl Findings {
    /// The start of all parts together.
    pub fn start(&self) -> Vec<Interval> {
        let mut parts = self.enclosure.parts.iter().map(|part| part.states.clone());
        let first = parts.next().unwrap_or_default();
        parts.fold(first, |hull, part| {
            hull.iter().zip(part).map(|(a, b)| a.hull(b)).collect()
        })
    }

    /// What is proved at a row; `start` is that of all parts together.
    pub fn row<'f>(&'f self, start: &'f [Interval], row: usize) -> Row<'f> {
        let found = &self.enclosure;
        let now = found.outputs.get(row).cloned().unwrap_or_default();
        let Some(last) = row.checked_sub(1) else {
            return Row {
                states: start,
                outputs_since: now.clone(),
                outputs: now,
                states_since: start,
                modes: ModeSet::EMPTY,
            };
        };
        let of = |list: &'f [Vec<Interval>]| list.get(last).map_or(&[][..], Vec::as_slice);
        // New inputs may make outputs jump at the time itself.
        let since = of(&found.output_tubes).iter().zip(&now);
        Row {
            states: of(&found.ends),
            outputs_since: since.map(|(since, now)| since.hull(*now)).collect(),
            outputs: now,
            states_since: of(&found.tubes),
            modes: found.modes.get(last).copied().unwrap_or_default(),
        }
    }

    /// Names of the modes that may have acted since the last row but one.
    pub fn last_modes(&self, model: &Model) -> Vec<String> {
        let last = self.rows.checked_sub(2);
        let last = last.and_then(|last| self.enclosure.modes.get(last));
        let last = last.copied().unwrap_or_default();
        let told = drawn_modes(model)
            .flatten()
            .filter(|mode| last.contains(*mode));
        told.filter_map(|mode| Some(model.modes.get(mode)?.name.clone()))
            .collect()
    }

    /// Bounds of states, and of outputs, at the last row and over all rows.
    pub fn ranges(&self) -> [Vec<(Interval, Interval)>; 2] {
        let start = self.start();
        let mut all: [Vec<(Interval, Interval)>; 2] = [Vec::new(), Vec::new()];
        for number in 0..self.rows {
            let row = self.row(&start, number);
            let kinds = [
                (row.states.to_vec(), row.states_since.to_vec()),
                (row.outputs, row.outputs_since),
            ];
            for (all, (now, since)) in all.iter_mut().zip(kinds) {
                let before = all.iter().map(|known| known.1);
                let before = before.chain(std::iter::repeat(Interval::EMPTY));
                let values = now.into_iter().zip(since).zip(before);
                *all = values
                    .map(|((now, since), before)| (now, before.hull(since).hull(now)))
                    .collect();
            }
        }
        all
    }
}

/// Writes all files of the run, and puts them in place together.
pub fn write(
    (folder, formats, plane): (&ResultFolder, &[Format], Plane),
    model: &Model,
    (times, found): (&[Decimal], &Findings),
    (info, json, page): (&RunInfo, &str, Option<Page>),
) -> Result<(), Diagnostic> {
    let start = found.start();
    let drawn = found.drawn.get(..MOST_DRAWN).unwrap_or(&found.drawn);
    let mut table = TableWriter::create(folder, "tube.csv", Column::of_tube(model))?;
    let meta = FigureMeta {
        page: page.is_some(),
        ..meta(model)
    };
    let mut tube = Tube::new(meta, plane, drawn.len());
    for (number, time) in times.iter().enumerate() {
        let row = found.row(&start, number);
        let modes = mode_names(model, row.modes);
        let lists = [
            row.states,
            &row.outputs,
            row.states_since,
            &row.outputs_since,
        ];
        let bounds = lists.into_iter().flatten().map(|x| Cell::Bounds(*x));
        let cells: Vec<Cell<'_>> = bounds.chain([Cell::Text(&modes)]).collect();
        table.row(time, &cells)?;
        let [states, outputs, states_since, outputs_since] = lists.map(pairs);
        let trajectories = drawn.iter().map(|one| one.at(number));
        let possible: Vec<bool> = drawn_modes(model)
            .flatten()
            .map(|mode| number == 0 || row.modes.contains(mode))
            .collect();
        let row = TubeRow {
            t: time.to_interval().mid(),
            states: &states,
            outputs: &outputs,
            states_since: &states_since,
            outputs_since: &outputs_since,
            modes: &possible,
            trajectories: &trajectories.collect::<Vec<_>>(),
        };
        match tube.push(&row) {
            // Stamps that differ by less than a float can tell share a point of the time axis.
            Ok(()) | Err(ReportError::TimeNotIncreasing { .. }) => {}
            Err(error) => return Err(undrawable(&error)),
        }
    }
    for past in &found.past_use {
        tube.past_use(past.cause.state, past.since.to_interval().mid());
    }
    let mut files = vec![
        table.finish()?,
        parts(folder, model, (times, found))?,
        info.write(folder)?,
    ];
    files.extend(write_figures(folder, formats, || tube.render_all())?);
    if let Some(mut page) = page {
        page.plots = Plots::of_tube(&tube);
        files.push(folder.write("report.html", page.render().as_bytes())?);
    }
    files.push(folder.write("summary.json", json.as_bytes())?);
    folder.publish(files)
}

/// The parts that the set was divided into.
fn parts(
    folder: &ResultFolder,
    model: &Model,
    (times, found): (&[Decimal], &Findings),
) -> Result<veribound_data::CompleteFile, Diagnostic> {
    let mut table = TableWriter::create(folder, "parts.csv", Column::of_parts(model))?;
    let zero = Decimal::zero();
    for (number, part) in found.enclosure.parts.iter().enumerate() {
        // Of a part that was proved further than others the end of all is told.
        let same = part.passed == found.enclosure.ends.len();
        let all = found.enclosure.ends.last().unwrap_or(&part.states);
        let end = if same && part.passed > 0 {
            &part.end
        } else {
            all
        };
        let bounds = part.states.iter().chain(&part.params).chain(end);
        let mut cells = vec![Cell::Count(number + 1)];
        cells.extend(bounds.map(|x| Cell::Bounds(*x)));
        table.row(times.last().unwrap_or(&zero), &cells)?;
    }
    table.finish()
}

fn pairs(list: &[Interval]) -> Vec<(f64, f64)> {
    list.iter().map(|x| (x.lo(), x.hi())).collect()
}

/// Names of modes, joined; groups that have no choice are left out where others have one.
pub fn mode_names(model: &Model, modes: ModeSet) -> String {
    let told = drawn_modes(model).flatten();
    let told = told.filter(|mode| modes.contains(*mode));
    joined(told.filter_map(|mode| Some(model.modes.get(mode)?.name.as_str())))
}

fn meta(model: &Model) -> FigureMeta {
    FigureMeta {
        params: Vec::new(),
        ..figure_meta(model, Zoom::Off, None)
    }
}
