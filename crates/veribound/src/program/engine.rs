//! What the program says of engines.

use veribound_flow::comparison::{Cause, Comparison, Disorder, Outlook};
use veribound_flow::engine::{Answer, LONG};
use veribound_flow::form::{Flow, Stretch};
use veribound_interval::Interval;
use veribound_model::{Model, Var};

/// Start values, parameters, and inputs: recorded ones may have any value and are uncertain where the model says so.
struct Start {
    states: Vec<Interval>,
    params: Vec<Interval>,
    inputs: Vec<Interval>,
}

fn start(model: &Model) -> Start {
    let inputs = model.inputs.iter().map(|input| {
        let exact = input.error.absolute.is_zero() && input.error.relative.is_zero();
        match (input.within, exact) {
            (Some(bounds), _) => bounds,
            (None, true) => Interval::ZERO,
            (None, false) => input.domain.unwrap_or(Interval::ENTIRE),
        }
    });
    Start {
        states: model.states.iter().map(|state| state.init).collect(),
        params: model.params.iter().map(|param| param.bounds).collect(),
        inputs: inputs.collect(),
    }
}

/// Which engine `enclose` will take, and why, in one line.
pub fn plan(model: &Model) -> String {
    let Start {
        states,
        params,
        inputs,
    } = start(model);
    let steepness = Flow::new(model).steepness(&[&states[..], &params, &inputs].concat());
    let first = Stretch {
        inputs,
        dt: Interval::ZERO,
    };
    let outlook = Comparison::new(model).outlook(&states, &params, &[first]);
    let closed = steepness.filter(|steepness| *steepness > 0.0);
    let closed = closed.map_or(String::new(), |steepness| {
        let longest = LONG / steepness;
        let decimals = (1.0 - longest.log10().floor()).clamp(0.0, 20.0) as usize;
        format!("; in closed form, since modes are affine, where inputs are held for {longest:.decimals$} s or longer")
    });
    format!("{}{closed}", by_order(model, &outlook))
}

fn by_order(model: &Model, outlook: &Outlook) -> String {
    let reason = outlook.disorders.first().map(|d| why(model, d));
    let names = |list: &[Var]| -> String {
        let quoted: Vec<String> = list.iter().map(|var| name(model, *var)).collect();
        quoted.join(", ")
    };
    match (outlook.corners.is_empty(), outlook.kept.is_empty(), reason) {
        (true, _, None) => "engine: forms (nothing is uncertain that could be ordered)".to_string(),
        (true, _, Some(reason)) => format!("engine: forms ({reason})"),
        (false, true, _) => format!(
            "engine: comparison of two corners, exact hulls as long as the right-hand side stays monotone, as it is on \
             the start box (in {}); forms from then on",
            names(&outlook.corners)
        ),
        (false, false, reason) => format!(
            "engine: forms, and where they are not tight and it does not take many times as long comparison of two corners in {}, \
             not in {}{}",
            names(&outlook.corners),
            names(&outlook.kept),
            reason.map_or(String::new(), |reason| format!(" ({reason})"))
        ),
    }
}

/// Which engines proved what was proved, and what stood in the way of the best one.
pub fn told(model: &Model, answer: &Answer) -> String {
    let names: Vec<&str> = answer.by.iter().map(|engine| engine.name()).collect();
    let corners = match &answer.corners[..] {
        [] => String::new(),
        corners => {
            let quoted: Vec<String> = corners.iter().map(|var| name(model, *var)).collect();
            format!(" (corners in {})", quoted.join(", "))
        }
    };
    let disorder = answer.disorders.first().map_or(String::new(), |disorder| {
        let since = disorder.since;
        format!("; {} from {since:.4} s on", why(model, disorder))
    });
    format!("{}{corners}{disorder}", names.join(" and "))
}

/// What stood in the way of an order.
fn why(model: &Model, disorder: &Disorder) -> String {
    let rate = |state: usize| {
        let state = model.states.get(state);
        format!("{}'", state.map_or("", |state| state.name.as_str()))
    };
    match disorder.cause {
        Cause::Slope { of, by, value } => {
            let by = name(model, by);
            match (value.lo() >= 0.0, value.hi() <= 0.0) {
                (false, false) => format!("{} both rises and falls with {by}", rate(of)),
                (rises, _) => format!(
                    "{} {} with {by}, against what other slopes ask for",
                    rate(of),
                    if rises { "rises" } else { "falls" }
                ),
            }
        }
        Cause::Switch { state } => format!(
            "{} switches, not only downwards at a level of its own",
            rate(state)
        ),
        Cause::Undefined { state } => {
            format!("{} or a slope of it may be undefined or jump", rate(state))
        }
        Cause::Jump => "the state may jump".to_string(),
        Cause::LeavesDomain => {
            "the set may leave the domain in which the guards are proved to leave no gap"
                .to_string()
        }
    }
}

/// The user's name of a quantity.
fn name(model: &Model, var: Var) -> String {
    let name = match var {
        Var::State(i) => model.states.get(i).map(|state| &state.name),
        Var::Param(i) => model.params.get(i).map(|param| &param.name),
        Var::Input(i) => model.inputs.get(i).map(|input| &input.name),
    };
    name.cloned().unwrap_or_default()
}
