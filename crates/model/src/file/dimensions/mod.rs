//! Units of equations: what is added, compared or measured has to be of one kind.
//!
//! Equations are evaluated with the numbers as written, so not only the dimension counts but the
//! scale too: `x` in mm with `x' = v`, `v` in m/s, is wrong by 1000. The rules:
//!
//! - A state, input, parameter or output with a unit has that unit. One without a unit, and
//!   everything it is multiplied with, fits everywhere.
//! - A number that is added or compared (`omega > 0.2`) is in the unit of what is beside it.
//! - A number in a product (`2*x`, `0.3*sqrt(h)`) may be a conversion, so that the scale is not
//!   checked, and it may be a rate or coefficient with a unit that nobody wrote down. Where only
//!   that makes the equation right, a note says so and the equation is taken. So it is with plain
//!   numbers that are calculated, whose factor 1 is not written (`omega' = -sin(phi)`).
//! - The derivative of `x` is in the unit of `x` per second; an output with a unit is in it.
//! - `rad` is 1 where a strict check would fail (`m/m`, torques in `N*m/rad`), but deg is
//!   `pi/180` of it: angles in deg are not added to angles in rad, and not given to `sin`.
//! - `°C` is K, as for differences; where the zero of the scale is, is not checked.
//! - `exp`, the hyperbolic and the trigonometric functions take plain numbers and angles in rad. Logarithms
//!   take anything, and what they give fits everywhere: `exp(a*log(x))` is how powers are written.
//! - Functions that this file does not know give what fits everywhere.
//!
//! A [let] has the unit of its expression; a [let] that is a number fits everywhere.

mod messages;
mod parts;
mod value;

use crate::file::equations::{Definition, WrittenMode};
use crate::file::jumps::ReadJump;
use crate::file::measured::{ReadOutput, ReadSignal};
use crate::file::quantities::ReadParam;
use crate::file::reader::Reader;
use crate::file::scope::{Equation, Meaning, Scope};
use crate::file::text::Text;
use crate::graph::Unary;
use crate::model::{Input, State};
use crate::syntax::Problem;
use crate::syntax::ast::{Arithmetic, Ast, Function, Kind};
use crate::units::Unit;
use messages::{Demand, Term, Verdict};
use num_rational::Ratio;
use num_traits::One;
use parts::{Parts, terms};
use value::Value;
use veribound_interval::Decimal;

/// Everything in the file that has a unit or an equation.
pub(crate) struct Written<'f> {
    pub scope: &'f Scope,
    pub states: &'f [State],
    pub inputs: &'f [Input],
    pub params: &'f [ReadParam],
    pub definitions: &'f [Definition],
    /// Definitions in the order in which they need each other, those in circles left out.
    pub order: &'f [usize],
    pub modes: &'f [WrittenMode],
    pub jumps: &'f [ReadJump],
    pub outputs: &'f [ReadOutput],
    pub signals: &'f [ReadSignal],
}

/// Reports every equation whose units do not fit. Gives what a user should know of the others.
pub(crate) fn check(reader: &mut Reader, written: &Written) -> Vec<String> {
    let mut notes = unknown_symbols(written);
    let mut checker = Checker::new(written);
    for &index in written.order {
        let definition = written.definitions.get(index);
        let Some(equation) = definition.and_then(|definition| definition.equation.as_ref()) else {
            continue;
        };
        let value = checker.equation(reader, equation, |checker| checker.value(&equation.ast));
        if let Some(slot) = checker.lets.get_mut(index) {
            *slot = value.named();
        }
    }
    for mode in written.modes {
        if let Some(guard) = &mode.guard {
            checker.equation(reader, guard, |checker| checker.value(&guard.ast));
        }
        for (state, equation) in written.states.iter().zip(&mode.der) {
            if let Some(equation) = equation {
                let demand = derivative(state);
                checker.equation(reader, equation, |checker| {
                    checker.whole(&equation.ast, demand.as_ref());
                });
            }
        }
    }
    for jump in written.jumps {
        if let Some(when) = &jump.when {
            checker.equation(reader, when, |checker| checker.value(&when.ast));
        }
        for (state, equation) in &jump.set {
            let demand = written.states.get(*state).and_then(new_value);
            checker.equation(reader, equation, |checker| {
                checker.whole(&equation.ast, demand.as_ref());
            });
        }
    }
    for output in written.outputs {
        let equation = &output.equation;
        let demand = measured(output);
        checker.equation(reader, equation, |checker| {
            checker.whole(&equation.ast, demand.as_ref());
        });
    }
    for equation in written.signals.iter().flat_map(|signal| &signal.proves) {
        checker.equation(reader, equation, |checker| checker.value(&equation.ast));
    }
    for note in checker.notes {
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    notes
}

fn holds_friction(ast: &Ast) -> bool {
    let mut open = vec![ast];
    while let Some(ast) = open.pop() {
        if matches!(ast.kind, Kind::Call(Function::Friction, _)) {
            return true;
        }
        open.extend(ast.kind.children());
    }
    false
}

/// A unit as written; none where none is written or where it was reported already.
fn unit(text: &str) -> Option<Unit> {
    (!text.trim().is_empty())
        .then(|| Unit::parse(text))
        .flatten()
}

fn derivative(state: &State) -> Option<Demand> {
    let second = Unit::parse("s")?;
    Some(Demand {
        unit: unit(&state.unit)?.over(&second)?,
        by: format!("`{}'` needs", state.name),
    })
}

fn new_value(state: &State) -> Option<Demand> {
    Some(Demand {
        unit: unit(&state.unit)?,
        by: format!("the state `{}` is in", state.name),
    })
}

fn measured(output: &ReadOutput) -> Option<Demand> {
    Some(Demand {
        unit: unit(&output.unit)?,
        by: format!("the output `{}` is in", output.name),
    })
}

fn unknown_symbols(written: &Written) -> Vec<String> {
    let states = written.states.iter().map(|state| &state.unit);
    let inputs = written.inputs.iter().map(|input| &input.unit);
    let params = written.params.iter().map(|read| &read.param.unit);
    let outputs = written.outputs.iter().map(|output| &output.unit);
    let mut notes = Vec::new();
    for unit in states.chain(inputs).chain(params).chain(outputs) {
        let unit = Unit::parse(unit);
        for symbol in unit.iter().flat_map(Unit::unknown_symbols) {
            let note = format!("the unit `{symbol}` is not a known one and stands for itself");
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
    }
    notes
}

struct Checker<'f> {
    scope: &'f Scope,
    states: Vec<Value>,
    inputs: Vec<Value>,
    params: Vec<Value>,
    lets: Vec<Value>,
    /// The text of the equation under examination, and what is wrong in it.
    text: String,
    problems: Vec<Problem>,
    notes: Vec<String>,
}

impl<'f> Checker<'f> {
    fn new(written: &Written<'f>) -> Self {
        let value = |text: &String| unit(text).map_or(Value::Free, Value::of);
        let states = written.states.iter();
        let inputs = written.inputs.iter();
        let params = written.params.iter();
        Checker {
            scope: written.scope,
            states: states.map(|state| value(&state.unit)).collect(),
            inputs: inputs.map(|input| value(&input.unit)).collect(),
            params: params.map(|read| value(&read.param.unit)).collect(),
            lets: vec![Value::Free; written.definitions.len()],
            text: String::new(),
            problems: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Examines one equation and reports what is wrong in it.
    fn equation<T>(
        &mut self,
        reader: &mut Reader,
        equation: &Equation,
        examine: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let text: &Text = &equation.text;
        self.text.clone_from(&text.value);
        let result = examine(self);
        for problem in self.problems.drain(..) {
            reader.report_in(text, problem);
        }
        result
    }

    /// A whole right-hand side or output: each term by itself where it is known what is needed.
    fn whole(&mut self, ast: &Ast, demand: Option<&Demand>) {
        let Some(demand) = demand else {
            self.value(ast);
            return;
        };
        for term in terms(ast) {
            if let Some(Parts { beside, results }) = Parts::of(&term.kind) {
                self.alike(&beside);
                for result in results {
                    self.whole(result, Some(demand));
                }
            } else {
                let value = self.value(term);
                self.require(term, &value, demand, "E0220");
            }
        }
    }

    fn value(&mut self, ast: &Ast) -> Value {
        if let Kind::Call(Function::Friction, arguments) = &ast.kind
            && let [velocity, drive, level, ..] = arguments.as_slice()
            && self.are_swapped(velocity, drive, level)
        {
            return Value::Free;
        }
        if let Some(Parts { beside, results }) = Parts::of(&ast.kind) {
            self.alike(&beside);
            return self.alike(&results);
        }
        match &ast.kind {
            Kind::Number(_) => Value::Number,
            Kind::Name(name) => self.named(name),
            Kind::Negate(_) | Kind::Arithmetic(Arithmetic::Add | Arithmetic::Subtract, _, _) => {
                self.alike(&[ast])
            }
            Kind::Arithmetic(Arithmetic::Multiply, a, b) => {
                let (a, b) = (self.value(a), self.value(b));
                a.times(&b)
            }
            Kind::Arithmetic(Arithmetic::Divide, a, b) => {
                let inverse = self.value(b).power(-Ratio::one());
                match &a.kind {
                    // `1/x` is no more than the inverse.
                    Kind::Number(number) if *number == Decimal::from_i64(1) => inverse,
                    _ => self.value(a).times(&inverse),
                }
            }
            Kind::Power(base, exponent) => {
                let base = self.value(base);
                parts::exponent(exponent).map_or(Value::Free, |power| base.power(power))
            }
            Kind::Call(function, arguments) => self.call(*function, arguments, ast),
            Kind::Compare(_, a, b) => {
                self.alike(&[a, b]);
                Value::Free
            }
            other => {
                for child in other.children() {
                    self.value(child);
                }
                Value::Free
            }
        }
    }

    fn named(&self, name: &str) -> Value {
        let found = match self.scope.find(name) {
            Some(Meaning::State(i)) => self.states.get(i),
            Some(Meaning::Input(i)) => self.inputs.get(i),
            Some(Meaning::Param(i)) => self.params.get(i),
            Some(Meaning::Let(i)) => self.lets.get(i),
            _ if name == "pi" => return Value::Number,
            _ => None,
        };
        found.cloned().unwrap_or(Value::Free)
    }

    fn call(&mut self, function: Function, arguments: &[Ast], ast: &Ast) -> Value {
        match (function, arguments) {
            (Function::Plain(Unary::Sign), [a]) => {
                self.value(a);
                Value::of(Unit::plain())
            }
            (Function::Plain(Unary::Sqrt), [a]) => self.value(a).power(Ratio::new(1, 2)),
            (Function::Plain(Unary::Cbrt), [a]) => self.value(a).power(Ratio::new(1, 3)),
            (Function::Atan2, [y, x]) => {
                self.alike(&[y, x]);
                Value::of(Unit::plain())
            }
            (Function::Plain(Unary::Sin | Unary::Cos | Unary::Tan), [a]) => {
                self.plain_argument(a, ast, "an angle in rad or a plain number");
                Value::of(Unit::plain())
            }
            (Function::Plain(Unary::Ln) | Function::LogTo(_), all) => {
                for argument in all {
                    self.value(argument);
                }
                Value::Free
            }
            (Function::Plain(_), [a]) => {
                // What `exp(a*log(x))` is in is known to nobody here.
                match self.plain_argument(a, ast, "a plain number") {
                    Value::Free => Value::Free,
                    _ => Value::of(Unit::plain()),
                }
            }
            (_, all) => {
                for argument in all {
                    self.value(argument);
                }
                Value::Free
            }
        }
    }

    /// Reports the first arguments of `friction` where units prove that they are swapped.
    fn are_swapped(&mut self, velocity: &Ast, drive: &Ast, level: &Ast) -> bool {
        // A look ahead into frictions inside of frictions would be one into looks ahead.
        if [velocity, drive, level].into_iter().any(holds_friction) {
            return false;
        }
        let (problems, notes) = (self.problems.len(), self.notes.len());
        let units = [velocity, drive, level].map(|argument| self.value(argument));
        // This was a look ahead.
        self.problems.truncate(problems);
        self.notes.truncate(notes);
        let [
            Value::Known { unit: first, .. },
            Value::Known { unit: second, .. },
            Value::Known { unit: level, .. },
        ] = units
        else {
            return false;
        };
        if !first.agrees_with(&level) || second.agrees_with(&level) {
            return false;
        }
        let spelled = |ast: &Ast| self.text.get(ast.range.clone()).unwrap_or("").to_string();
        let (drive, velocity_text) = (spelled(velocity), spelled(drive));
        self.problems.push(Problem::new(
            "E0220",
            "the first two arguments of `friction` are swapped",
            velocity.range.clone(),
            format!("in {}, as the level is", first.spell()),
            format!("the velocity comes first: friction({velocity_text}, {drive}, level)"),
        ));
        true
    }

    fn plain_argument(&mut self, argument: &Ast, call: &Ast, takes: &str) -> Value {
        let value = self.value(argument);
        let text = self.text.get(call.range.clone()).unwrap_or("");
        let name = text.split('(').next().unwrap_or("").trim();
        let demand = Demand {
            unit: Unit::plain(),
            by: format!("`{name}` takes {takes}"),
        };
        self.require(argument, &value, &demand, "E0222");
        value
    }

    /// What the terms of sums have in common; reports those that differ from the others.
    fn alike(&mut self, parts: &[&Ast]) -> Value {
        let all: Vec<&Ast> = parts.iter().flat_map(|part| terms(part)).collect();
        if let [one] = *all.as_slice() {
            return self.value(one);
        }
        let terms = &all;
        let values: Vec<Value> = terms.iter().map(|term| self.value(term)).collect();
        let best = values
            .iter()
            .zip(terms)
            .min_by_key(|(value, _)| value.rank());
        let Some((Value::Known { unit, has_number }, first)) = best else {
            let all_numbers = values.iter().all(|v| matches!(v, Value::Number));
            return match all_numbers {
                true => Value::Number,
                false => Value::Free,
            };
        };
        let beside = self.text.get(first.range.clone()).unwrap_or("");
        let demand = Demand {
            unit: unit.clone(),
            by: format!("`{beside}` beside it is in"),
        };
        let mut common = Value::Known {
            unit: unit.clone(),
            has_number: *has_number,
        };
        for (value, term) in values.iter().zip(terms) {
            // Two terms with numbers: nothing says which of the numbers has a unit.
            let is_open = *has_number && !value.may_be(unit);
            if is_open || !self.require(term, value, &demand, "E0220") {
                common = Value::Free;
            }
        }
        common
    }

    /// Whether the term fits, or a number in it can make it fit.
    fn require(&mut self, ast: &Ast, value: &Value, demand: &Demand, code: &'static str) -> bool {
        let term = Term {
            text: self.text.get(ast.range.clone()).unwrap_or(""),
            range: ast.range.clone(),
            is_sum: terms(ast).len() > 1,
        };
        match messages::compare(&term, value, demand, code) {
            Verdict::Fits => true,
            Verdict::Note(note) => {
                self.notes.push(note);
                true
            }
            Verdict::Wrong(problem) => {
                self.problems.push(problem);
                false
            }
        }
    }
}
