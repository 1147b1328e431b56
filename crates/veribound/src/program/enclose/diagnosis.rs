//! Which width grew past use, since when, by which term, and what to try.

use super::Course;
use veribound_flow::form::{Enclosure, Obstacle, Unknown};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Model, Tape, Term};

/// Growth by this factor is much.
const GROWN: f64 = 10.0;

/// Up to so many parts, more of them are worth a try first.
const FEW_PARTS: usize = 16;

/// What made a width grow.
pub struct Cause {
    /// Position of the state.
    pub state: usize,
    /// The term of its right-hand side, as it is written, and its line.
    pub term: Option<(String, usize)>,
    /// What to try, after "try".
    pub remedy: String,
}

/// A state whose width grew past use.
pub struct PastUse {
    /// Which, and by what.
    pub cause: Cause,
    /// From when on.
    pub since: Decimal,
}

/// Which states grew past use in the rows at `times`.
pub fn past_use(
    model: &Model,
    course: &Course,
    (times, enclosure): (&[Decimal], &Enclosure),
    most_parts: usize,
) -> Vec<PastUse> {
    let start = model.states.iter().map(|state| state.init).collect();
    let rows: Vec<&Vec<Interval>> = std::iter::once(&start).chain(&enclosure.ends).collect();
    let rows = rows.get(..times.len()).unwrap_or_default();
    let past = |state: usize| {
        let of = |row: &&Vec<Interval>| row.get(state).copied().unwrap_or(Interval::ENTIRE);
        let row = first_past_use(&rows.iter().map(of).collect::<Vec<_>>())?;
        let quantities = quantities(model, course, rows, row);
        let cause = Cause {
            state,
            term: widest_term(model, state, &quantities).map(place),
            remedy: remedy(model, enclosure, state, most_parts),
        };
        let since = times.get(row)?.clone();
        Some(PastUse { cause, since })
    };
    (0..model.states.len()).filter_map(past).collect()
}

/// What stood in the way, where the enclosure ended early.
pub fn obstacle(
    model: &Model,
    course: &Course,
    enclosure: &Enclosure,
    most_parts: usize,
) -> Option<Cause> {
    let stopped = enclosure.stopped.as_ref()?;
    let start = model.states.iter().map(|state| state.init).collect();
    let rows: Vec<&Vec<Interval>> = std::iter::once(&start).chain(&enclosure.ends).collect();
    let last = rows.len().saturating_sub(1);
    let quantities = quantities(model, course, &rows, last);
    let term = match stopped.obstacle {
        Obstacle::Undefined | Obstacle::Jump => model
            .terms
            .iter()
            .find(|term| !is_smooth(model, term, &quantities)),
        _ => None,
    };
    let state = term.map_or(stopped.state, |term| term.state);
    let term = term.or_else(|| widest_term(model, state, &quantities));
    let remedy = match stopped.obstacle {
        Obstacle::NotAffine | Obstacle::NotMonotone => "`--engine auto`".to_owned(),
        _ => remedy(model, enclosure, state, most_parts),
    };
    Some(Cause {
        state,
        term: term.map(place),
        remedy,
    })
}

/// The first row from which on the width is past use to the end.
///
/// It is, if it grows tenfold in the last two thirds of the rows, which what builds up to some width does not, from
/// where it is larger than the range in which the middle moved until then, and than ten times the start. What starts as
/// a point has no width to compare with: the smallest one in those rows stands for it.
fn first_past_use(bounds: &[Interval]) -> Option<usize> {
    let widths: Vec<f64> = bounds.iter().map(|x| x.width()).collect();
    let late = widths.get(widths.len() / 3..)?;
    let usual = late.iter().copied().fold(f64::INFINITY, f64::min);
    let start = widths.first().copied()?;
    let enough = if start > 0.0 { GROWN * start } else { usual };
    let mut moved = Interval::EMPTY;
    let mut since = None;
    for (row, (x, width)) in bounds.iter().zip(&widths).enumerate() {
        if x.is_bounded() {
            moved = moved.hull(Interval::point(x.mid()));
        }
        if *width <= moved.width().max(enough) {
            since = None;
        } else {
            since = since.or(Some(row));
        }
    }
    let last = widths.last().copied()?;
    since.filter(|_| last > GROWN * usual.max(start))
}

/// All quantities at a row.
fn quantities(
    model: &Model,
    course: &Course,
    rows: &[&Vec<Interval>],
    row: usize,
) -> Vec<Interval> {
    let states = rows.get(row).copied().cloned().unwrap_or_default();
    let params = model.params.iter().map(|param| param.bounds);
    let inputs = course.stretches.get(row).map(|stretch| &stretch.inputs);
    let inputs = inputs.into_iter().flatten().copied();
    states.into_iter().chain(params).chain(inputs).collect()
}

/// The term of a state's right-hand side with the widest range on a box.
fn widest_term<'m>(model: &'m Model, state: usize, quantities: &[Interval]) -> Option<&'m Term> {
    let terms = model.terms.iter().filter(|term| term.state == state);
    let width = |term: &&Term| {
        let layout = model.layout();
        let value = |var| {
            let index = layout.index(var);
            quantities.get(index).copied().unwrap_or(Interval::ENTIRE)
        };
        model.graph.eval_interval(term.expr, &value).width()
    };
    terms.max_by(|a, b| width(a).total_cmp(&width(b)))
}

/// Whether a term is defined and smooth on a box.
fn is_smooth(model: &Model, term: &Term, quantities: &[Interval]) -> bool {
    let tape = Tape::compile(&model.graph, model.layout(), &[term.expr]);
    let mut registers = tape.registers();
    let regular = tape.eval(quantities, &mut registers);
    regular.is_defined() && regular.is_continuous()
}

fn place(term: &Term) -> (String, usize) {
    (term.text.clone(), term.line)
}

/// What makes the width of a state smaller: one thing.
fn remedy(model: &Model, enclosure: &Enclosure, state: usize, most_parts: usize) -> String {
    let shares = enclosure.shares.get(state).into_iter().flatten();
    let largest = shares.max_by(|a, b| a.1.total_cmp(&b.1));
    if largest.is_some() && 2 * enclosure.parts.len() > most_parts && most_parts <= FEW_PARTS {
        return format!("more parts: `--parts {}`", 8 * most_parts);
    }
    match largest {
        Some((Unknown::Start(state), _)) => {
            let name = model.states.get(*state).map_or("", |state| &state.name);
            format!("a narrower start of `{name}`")
        }
        Some((Unknown::Param(param), _)) => {
            let name = model.params.get(*param).map_or("", |param| &param.name);
            format!("narrower bounds of `{name}`")
        }
        Some((Unknown::Axis(_), _)) | None => uncertain(model),
    }
}

/// Where no shares are known, as between corners: what the file leaves open.
fn uncertain(model: &Model) -> String {
    let zero = Decimal::zero();
    let input = model.inputs.iter().find(|input| {
        input.within.is_some() || input.error.absolute > zero || input.error.relative > zero
    });
    if let Some(input) = input {
        let kind = match input.within {
            Some(_) => "disturbance",
            None => "input",
        };
        return format!("narrower bounds of the {kind} `{}`", input.name);
    }
    let mut params = model.params.iter();
    if let Some(param) = params.find(|param| param.bounds.width() > 0.0) {
        return format!("narrower bounds of `{}`", param.name);
    }
    let mut states = model.states.iter();
    match states.find(|state| state.init.width() > 0.0) {
        Some(state) => format!("a narrower start of `{}`", state.name),
        None => "an earlier end: `--until`".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_past_use_where_they_stay_so() {
        let list = |widths: &[f64], middle: fn(usize) -> f64| -> Vec<Interval> {
            let bounds = widths.iter().enumerate();
            let bounds =
                bounds.map(|(k, w)| Interval::new(middle(k) - w / 2.0, middle(k) + w / 2.0));
            bounds.map(Option::unwrap).collect()
        };
        let still = |_| 1.0;
        let away = |k| 10.0 * k as f64;
        let growing = [0.1, 0.1, 0.1, 0.2, 0.5, 2.0, 20.0];
        assert_eq!(first_past_use(&list(&growing, still)), Some(5));
        let early = [0.1, 1.5, 5.0, 40.0, 400.0, 1000.0];
        assert_eq!(first_past_use(&list(&early, still)), Some(1));
        // It moved by more than its width until then.
        assert_eq!(first_past_use(&list(&growing, away)), None);
        // A disturbance that builds up to some width is no growth past use.
        let built = [0.0, 1.0, 1.5, 1.6, 1.6, 1.6];
        assert_eq!(first_past_use(&list(&built, still)), None);
        // From a point, all growth is past ten times the start.
        let driven = [0.0, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 12.0];
        assert_eq!(first_past_use(&list(&driven, still)), Some(3));
        // Nor is what comes back.
        let back = [0.1, 0.1, 0.1, 5.0, 0.1, 0.1];
        assert_eq!(first_past_use(&list(&back, still)), None);
        let unbounded = [list(&[0.1; 5], still), vec![Interval::ENTIRE]].concat();
        assert_eq!(first_past_use(&unbounded), Some(5));
    }
}
