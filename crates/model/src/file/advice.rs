//! Remarks on what is right and may yet be a slip: names that no equation needs, dry friction in disguise.

use crate::file::dimensions::Written;
use crate::file::scope::{Equation, Meaning};
use crate::graph::Unary;
use crate::model::Input;
use crate::syntax::ast::{Arithmetic, Ast, Function, Kind};
use num_rational::BigRational;

/// A slope of `tanh` from which on it is meant as a step.
const STEEP: i64 = 20;
/// More names are counted.
const MOST_NAMES: usize = 3;

/// Sentences for `veribound check`.
pub(crate) fn advise(written: &Written) -> Vec<String> {
    let used = Used::of(written);
    let mut notes = used.notes(written);
    let states = written.states.iter().map(|state| Some(state.name.as_str()));
    let modes = written.modes.iter();
    let in_modes = modes.flat_map(|mode| states.clone().zip(&mode.der));
    let in_modes = in_modes.filter_map(|(state, equation)| Some((state, equation.as_ref()?)));
    let definitions = written.definitions.iter().zip(&used.lets);
    let in_lets = definitions.filter(|(_, used)| **used);
    let in_lets = in_lets.filter_map(|(known, _)| Some((None, known.equation.as_ref()?)));
    for (state, equation) in in_modes.chain(in_lets) {
        for note in friction(written, state, &equation.ast) {
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    notes
}

/// What the modes, jumps, outputs and signals need, directly or by way of a [let].
struct Used {
    inputs: Vec<bool>,
    params: Vec<bool>,
    lets: Vec<bool>,
}

impl Used {
    fn of(written: &Written) -> Used {
        let modes = written.modes.iter();
        let in_modes = modes.flat_map(|mode| mode.guard.iter().chain(mode.der.iter().flatten()));
        let outputs = written.outputs.iter().map(|output| &output.equation);
        let signals = written.signals.iter().flat_map(|signal| &signal.proves);
        let jumps = written.jumps.iter();
        let jumps = jumps.flat_map(|jump| jump.when.iter().chain(jump.set.iter().map(|(_, e)| e)));
        let all = in_modes.chain(jumps).chain(outputs).chain(signals);
        let mut open: Vec<&Equation> = all.collect();
        let mut used = Used {
            inputs: vec![false; written.inputs.len()],
            params: vec![false; written.params.len()],
            lets: vec![false; written.definitions.len()],
        };
        while let Some(equation) = open.pop() {
            for (name, _) in equation.ast.names() {
                let slot = match written.scope.find(name) {
                    Some(Meaning::Input(i)) => used.inputs.get_mut(i),
                    Some(Meaning::Param(i)) => used.params.get_mut(i),
                    Some(Meaning::Let(i)) => {
                        let seen = used.lets.get_mut(i);
                        if seen.as_ref().is_some_and(|seen| !**seen) {
                            let definition = written.definitions.get(i);
                            open.extend(definition.and_then(|known| known.equation.as_ref()));
                        }
                        seen
                    }
                    _ => None,
                };
                if let Some(slot) = slot {
                    *slot = true;
                }
            }
        }
        used
    }

    fn notes(&self, written: &Written) -> Vec<String> {
        let params = written.params.iter().map(|read| &read.param.name);
        let lets = written
            .definitions
            .iter()
            .map(|definition| &definition.name);
        let mut notes = Vec::new();
        let mut note = |names: Vec<&String>, [one, many]: [&str; 2], end: &str| {
            let shown: Vec<String> = names
                .iter()
                .take(MOST_NAMES)
                .map(|name| format!("`{name}`"))
                .collect();
            match (names.len(), names.len().saturating_sub(MOST_NAMES)) {
                (0, _) => {}
                (1, _) => notes.push(format!("{one} {} is in no equation{end}", shown.join(", "))),
                (_, 0) => notes.push(format!(
                    "{many} {} are in no equation{end}",
                    shown.join(", ")
                )),
                (_, more) => notes.push(format!(
                    "{many} {} and {more} more are in no equation{end}",
                    shown.join(", ")
                )),
            }
        };
        note(
            unused(params, &self.params),
            ["the parameter", "the parameters"],
            "; the record says nothing about what has no effect",
        );
        let inputs: Vec<&Input> = unused(written.inputs.iter(), &self.inputs);
        for (is_disturbance, words) in [
            (false, ["the input", "the inputs"]),
            (true, ["the disturbance", "the disturbances"]),
        ] {
            let own = inputs
                .iter()
                .filter(|input| input.within.is_some() == is_disturbance);
            note(own.map(|input| &input.name).collect(), words, "");
        }
        note(
            unused(lets, &self.lets),
            ["the [let]", "the [let]s"],
            " of a mode or output",
        );
        notes
    }
}

fn unused<'n, T>(names: impl Iterator<Item = &'n T>, used: &[bool]) -> Vec<&'n T> {
    let pairs = names.zip(used);
    pairs
        .filter(|(_, used)| !**used)
        .map(|(name, _)| name)
        .collect()
}

/// What is to be said of `T*sign(v)` and `tanh(100*v)` in the equation of `v`, or in one that may be a part
/// of it.
fn friction(written: &Written, of: Option<&str>, ast: &Ast) -> Vec<String> {
    let mut notes = Vec::new();
    let mut open = vec![ast];
    let state = |ast: &Ast| match &ast.kind {
        Kind::Name(name) => {
            let is_state = matches!(written.scope.find(name), Some(Meaning::State(_)));
            let is_own = of.is_none_or(|own| own == name);
            (is_state && is_own).then(|| name.clone())
        }
        _ => None,
    };
    while let Some(ast) = open.pop() {
        match &ast.kind {
            Kind::Arithmetic(Arithmetic::Multiply, a, b) => {
                for side in [a, b] {
                    if let Kind::Call(Function::Plain(Unary::Sign), arguments) = &side.kind
                        && let [argument] = arguments.as_slice()
                        && let Some(name) = state(argument)
                    {
                        notes.push(format!(
                            "`sign({name})` is every number in [-1, 1] at {name} = 0, so `{name}` can rest there \
                             where one of them balances the equation; friction({name}, drive, level) says \
                             the same with rest as a mode of its own"
                        ));
                    }
                }
            }
            Kind::Call(Function::Plain(Unary::Tanh), arguments) => {
                if let [argument] = arguments.as_slice()
                    && let Some(name) = steep(argument).and_then(state)
                {
                    notes.push(format!(
                        "`tanh` of a steep line is smooth, and zero at {name} = 0 alone: where a force acts `{name}` creeps \
                         and never rests; dry friction is friction({name}, drive, level)"
                    ));
                }
            }
            _ => {}
        }
        open.extend(ast.kind.children());
    }
    notes
}

/// What is multiplied by a large number, or divided by a small one.
fn steep(ast: &Ast) -> Option<&Ast> {
    let least = BigRational::from_integer(STEEP.into());
    let large = |ast: &Ast| match &ast.kind {
        Kind::Number(number) => number.to_rational() >= least,
        _ => false,
    };
    match &ast.kind {
        Kind::Arithmetic(Arithmetic::Multiply, a, b) if large(a) => Some(b),
        Kind::Arithmetic(Arithmetic::Multiply, a, b) if large(b) => Some(a),
        Kind::Arithmetic(Arithmetic::Divide, a, b) => match &b.kind {
            Kind::Number(number) => {
                let number = number.to_rational();
                (number > BigRational::from_integer(0.into())
                    && number * least <= BigRational::from_integer(1.into()))
                .then_some(a)
            }
            _ => None,
        },
        _ => None,
    }
}
