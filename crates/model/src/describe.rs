//! What a model file was understood to say, as text.

use crate::facts::ModeFacts;
use crate::graph::{Binary, ExprId, Names, Node};
use crate::model::{Coverage, ErrorBound, Guard, Model, Relation, Signal};
use std::collections::HashMap;
use std::fmt::Write;
use veribound_interval::{Decimal, Interval, text};

/// Longer expressions are not printed: sharing inside of them can make the text exponential.
const LONGEST_SHOWN: usize = 400;

impl Model {
    /// Everything the model says, in the user's names: quantities, modes with guards and
    /// derivatives, outputs with their bounds, signals, and what was proved about the guards.
    pub fn describe(&self) -> String {
        let names = self.names();
        let mut out = format!("{}\n  {}\n", self.name, self.counts());
        self.describe_quantities(&mut out);
        self.describe_outputs(&names, &mut out);
        self.describe_signals(&names, &mut out);
        section(&mut out, "modes", Vec::new());
        let width = self
            .modes
            .iter()
            .map(|mode| length(&mode.name))
            .max()
            .unwrap_or(0);
        for mode in 0..self.modes.len() {
            self.describe_mode(mode, width, &names, &mut out);
        }
        self.describe_jumps(&names, &mut out);
        self.describe_facts(&mut out);
        out.push('\n');
        let line = match &self.coverage {
            _ if self.modes.iter().all(|mode| mode.guard == Guard::Always) => {
                let switches = if self.jumps.is_empty() {
                    "no switches"
                } else {
                    "and jumps"
                };
                format!("ok    one smooth mode, {switches}")
            }
            Coverage::Everywhere => "ok    the guards leave no gap (proved)".to_string(),
            Coverage::InDomain { .. } => {
                "ok    the guards leave no gap in the domain (proved)".to_string()
            }
            Coverage::Unproved(place) => {
                format!(
                    "note  that the guards leave no gap is not proved within the budget: {place}"
                )
            }
        };
        let notes = self.notes.iter().map(|note| format!("note  {note}"));
        for line in std::iter::once(line).chain(notes) {
            out.push_str("  ");
            out.push_str(&line);
            out.push('\n');
        }
        out
    }

    fn counts(&self) -> String {
        let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
        let mut parts = vec![
            count(self.states.len(), "state"),
            count(self.recorded_inputs().count(), "input"),
            count(self.params.len(), "parameter"),
            count(self.outputs.len(), "output"),
            count(self.modes.len(), "mode"),
        ];
        for (n, what) in [
            (self.jumps.len(), "jump"),
            (self.signals.len(), "signal"),
            (self.disturbances().count(), "disturbance"),
        ] {
            if n > 0 {
                parts.push(count(n, what));
            }
        }
        parts.join(", ")
    }

    fn describe_quantities(&self, out: &mut String) {
        let domain = |domain: Option<Interval>| {
            domain.map_or(String::new(), |domain| format!("domain {}", spell(domain)))
        };
        let states = self.states.iter().map(|state| {
            let init = format!("starts in {}", spell(state.init));
            vec![
                state.name.clone(),
                state.unit.clone(),
                init,
                domain(state.domain),
            ]
        });
        section(out, "states", states.collect());
        let inputs = self.recorded_inputs().map(|input| {
            let error = bound(&input.error);
            let column = column(&input.column);
            vec![
                input.name.clone(),
                input.unit.clone(),
                error,
                column,
                domain(input.domain),
            ]
        });
        section(out, "inputs (held from sample to sample)", inputs.collect());
        let disturbances = self.disturbances().map(|(input, bounds)| {
            let bounds = format!("in {}", spell(bounds));
            let held = if input.is_held {
                "constant from each sample to the next"
            } else {
                "any function of time"
            };
            vec![
                input.name.clone(),
                input.unit.clone(),
                bounds,
                held.to_string(),
            ]
        });
        let disturbances: Vec<Vec<String>> = disturbances.collect();
        if !disturbances.is_empty() {
            section(out, "disturbances", disturbances);
        }
        let params = self.params.iter().map(|param| {
            let nominal = param.nominal.as_ref();
            let nominal = nominal.map_or(String::new(), |value| format!("nominal {value}"));
            let bounds = spell(param.bounds);
            let prior = if bounds.starts_with('[') {
                "prior"
            } else {
                "fixed"
            };
            let prior = format!("{prior} {bounds}");
            vec![param.name.clone(), param.unit.clone(), prior, nominal]
        });
        section(out, "parameters", params.collect());
    }

    fn describe_outputs(&self, names: &Names, out: &mut String) {
        let outputs = self.outputs.iter().map(|output| {
            vec![
                output.name.clone(),
                output.unit.clone(),
                format!("= {}", self.shown(output.expr, names)),
                bound(&output.error),
                column(&output.column),
            ]
        });
        section(out, "outputs", outputs.collect());
    }

    fn describe_signals(&self, names: &Names, out: &mut String) {
        if self.signals.is_empty() {
            return;
        }
        let rows = self.signals.iter().map(|signal| {
            vec![
                signal.name.clone(),
                self.meaning(signal, names),
                column(&signal.column),
            ]
        });
        section(out, "signals", rows.collect());
    }

    fn meaning(&self, signal: &Signal, names: &Names) -> String {
        let mut parts = Vec::new();
        let proofs: Vec<String> = signal
            .proves_zero
            .iter()
            .map(|expr| self.shown_comparison(*expr, Relation::Equal, names))
            .collect();
        if !proofs.is_empty() {
            parts.push(format!(
                "proves {} after {} s",
                proofs.join(", "),
                signal.latency
            ));
        }
        for reset in &signal.resets {
            let param = self
                .params
                .get(reset.param)
                .map_or("", |param| param.name.as_str());
            parts.push(format!(
                "true for {} s ({}): resets {param}",
                reset.lasts, reset.event
            ));
        }
        if parts.is_empty() {
            "recorded only".to_string()
        } else {
            parts.join("; ")
        }
    }

    fn describe_mode(&self, number: usize, width: usize, names: &Names, out: &mut String) {
        let Some(mode) = self.modes.get(number) else {
            return;
        };
        let guard = match &mode.guard {
            Guard::Always => "always".to_string(),
            guard => format!("when {}", self.shown_guard(guard, names, false)),
        };
        let name = &mode.name;
        // Writing to a string cannot fail.
        let _ = writeln!(out, "  {name}{}  {guard}", blanks(name, width));
        let longest = self
            .states
            .iter()
            .map(|state| length(&state.name))
            .max()
            .unwrap_or(0);
        for (state, e) in self.governed(number) {
            let Some(state) = self.states.get(state) else {
                continue;
            };
            let gap = blanks(&state.name, longest);
            let _ = writeln!(
                out,
                "  {}  {}'{gap} = {}",
                " ".repeat(width),
                state.name,
                self.shown(e, names)
            );
        }
    }

    fn describe_jumps(&self, names: &Names, out: &mut String) {
        if self.jumps.is_empty() {
            return;
        }
        let rows = self.jumps.iter().map(|jump| {
            let set = jump.set.iter().filter_map(|(state, value)| {
                let state = &self.states.get(*state)?.name;
                Some(format!("{state} becomes {}", self.shown(*value, names)))
            });
            vec![
                jump.name.clone(),
                format!("when {}:", self.shown_guard(&jump.guard, names, false)),
                set.collect::<Vec<_>>().join(", "),
            ]
        });
        section(out, "jumps", rows.collect());
    }

    /// What is proved about the right-hand sides; modes of which the same is known share a line.
    fn describe_facts(&self, out: &mut String) {
        let facts = self.facts();
        let mut rows: Vec<(Vec<&str>, [String; 2])> = Vec::new();
        for (mode, facts) in self.modes.iter().zip(&facts.modes) {
            let told = [properties(facts, self.states.len()), self.slopes(facts)];
            match rows.iter_mut().find(|(_, known)| *known == told) {
                Some((names, _)) => names.push(&mode.name),
                None => rows.push((vec![&mode.name], told)),
            }
        }
        let rows = rows.into_iter().flat_map(|(names, [properties, slopes])| {
            let slopes = vec![String::new(), slopes];
            [vec![names.join(", "), properties], slopes]
        });
        let rows = rows.filter(|row| row.iter().any(|cell| !cell.is_empty()));
        section(out, "structure (proved)", rows.collect());
        for state in &facts.switching {
            let name = self.states.get(*state).map_or("", |state| &state.name);
            // Writing to a string cannot fail.
            let _ = writeln!(
                out,
                "  {name}' switches: where guards touch or overlap it is the convex hull of their modes"
            );
        }
    }

    /// Which derivatives rise or fall with which states.
    fn slopes(&self, facts: &ModeFacts) -> String {
        let mut parts = Vec::new();
        for (state, row) in facts.rows() {
            let Some(state) = self.states.get(state) else {
                continue;
            };
            let with = |wanted: Slope| {
                let both = self.states.iter().zip(row);
                let named = both.filter(|(_, slope)| Slope::of(**slope) == wanted);
                let names: Vec<&str> = named.map(|(other, _)| other.name.as_str()).collect();
                names.join(", ")
            };
            for (slope, verb) in [(Slope::Rising, "rises"), (Slope::Falling, "falls")] {
                let names = with(slope);
                if !names.is_empty() {
                    parts.push(format!("{}' {verb} with {names}", state.name));
                }
            }
        }
        parts.join("; ")
    }

    fn shown_guard(&self, guard: &Guard, names: &Names, is_inside: bool) -> String {
        let (list, word) = match guard {
            Guard::Always => return "true".to_string(),
            Guard::Atom { expr, relation } => {
                return self.shown_comparison(*expr, *relation, names);
            }
            Guard::All(list) => (list, " and "),
            Guard::Any(list) => (list, " or "),
        };
        let parts: Vec<String> = list
            .iter()
            .map(|part| self.shown_guard(part, names, true))
            .collect();
        let text = parts.join(word);
        if is_inside { format!("({text})") } else { text }
    }

    /// `a relation b` for `a - b relation 0`.
    fn shown_comparison(&self, expr: ExprId, relation: Relation, names: &Names) -> String {
        let symbol = match relation {
            Relation::Less => "<",
            Relation::LessEqual => "<=",
            Relation::Greater => ">",
            Relation::GreaterEqual => ">=",
            Relation::Equal => "==",
            Relation::NotEqual => "!=",
        };
        match *self.graph.node(expr) {
            Node::Binary(Binary::Sub, a, b) => {
                format!("{} {symbol} {}", self.shown(a, names), self.shown(b, names))
            }
            Node::Binary(Binary::Add, a, b) if self.graph.as_constant(b).is_some() => {
                format!(
                    "{} {symbol} -{}",
                    self.shown(a, names),
                    self.shown(b, names)
                )
            }
            Node::Binary(Binary::Add, b, a) if self.graph.as_constant(b).is_some() => {
                format!(
                    "{} {symbol} -{}",
                    self.shown(a, names),
                    self.shown(b, names)
                )
            }
            _ => format!("{} {symbol} 0", self.shown(expr, names)),
        }
    }

    /// The expression, or its size where it is too long to be read.
    fn shown(&self, e: ExprId, names: &Names) -> String {
        let mut sizes: HashMap<ExprId, usize> = HashMap::new();
        for at in self.graph.reachable(&[e]) {
            let size = |e: &ExprId| sizes.get(e).copied().unwrap_or(0);
            let total = match self.graph.node(at) {
                Node::Constant(value) => {
                    // A fraction without a short decimal is printed with all its digits.
                    1 + (value.numer().bits().max(value.denom().bits()) / 64) as usize
                }
                Node::Pi | Node::Var(_) => 1,
                Node::Unary(_, a) | Node::Power(a, _) => size(a).saturating_add(1),
                Node::Binary(_, a, b) => size(a).saturating_add(size(b)).saturating_add(1),
            };
            sizes.insert(at, total);
        }
        match sizes.get(&e) {
            Some(size) if *size > LONGEST_SHOWN => format!("(an expression of {size} terms)"),
            _ => self.graph.show(e, names),
        }
    }
}

/// How a derivative changes with a state.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Slope {
    None,
    Rising,
    Falling,
    Unknown,
}

impl Slope {
    fn of(slope: Interval) -> Slope {
        match (slope.lo() >= 0.0, slope.hi() <= 0.0) {
            (true, true) => Slope::None,
            (true, false) => Slope::Rising,
            (false, true) => Slope::Falling,
            (false, false) => Slope::Unknown,
        }
    }
}

/// The properties of a mode that engines look for.
fn properties(facts: &ModeFacts, states: usize) -> String {
    let mut parts = vec![match (facts.affine_in_states, facts.affine_in_params) {
        (true, true) => "affine in the states, and in the parameters".to_string(),
        (true, false) => "affine in the states".to_string(),
        (false, true) => "affine in the parameters".to_string(),
        (false, false) => "not affine".to_string(),
    }];
    if facts.is_cooperative() {
        parts.push("cooperative".to_string());
    }
    let expansion = facts.expansion();
    if expansion.is_finite() && facts.states.len() == states {
        let rate = text::upper(expansion, 3);
        parts.push(format!("solutions part at most like exp({rate} t)"));
    }
    parts.join("; ")
}

/// A heading and aligned rows; empty columns take no room.
fn section(out: &mut String, title: &str, rows: Vec<Vec<String>>) {
    out.push('\n');
    out.push_str(title);
    if rows.is_empty() && title != "modes" {
        out.push_str(": none");
    }
    out.push('\n');
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns)
        .map(|i| {
            rows.iter()
                .filter_map(|row| row.get(i))
                .map(|cell| length(cell))
                .max()
                .unwrap_or(0)
        })
        .collect();
    for row in &rows {
        let mut line = String::from(" ");
        for (cell, width) in row.iter().zip(&widths) {
            if *width > 0 {
                line.push(' ');
                line.push_str(cell);
                line.push_str(&blanks(cell, *width));
                line.push(' ');
            }
        }
        out.push_str(line.trim_end());
        out.push('\n');
    }
}

fn length(text: &str) -> usize {
    text.chars().count()
}

fn blanks(text: &str, width: usize) -> String {
    " ".repeat(width.saturating_sub(length(text)))
}

fn column(column: &Option<String>) -> String {
    column
        .as_ref()
        .map_or(String::new(), |name| format!("column {name}"))
}

fn bound(error: &ErrorBound) -> String {
    let zero = Decimal::zero();
    match (error.absolute == zero, error.relative == zero) {
        (true, true) => "exact".to_string(),
        (false, true) => format!("error +- {}", error.absolute),
        (true, false) => format!("error +- {} of the value", error.relative),
        (false, false) => format!(
            "error +- ({} + {} of the value)",
            error.absolute, error.relative
        ),
    }
}

/// Bounds in the shortest decimals whose enclosure they are: what a user wrote as `[-6.0, -0.05]`
/// and was enclosed outward is `[-6, -0.05]` again. Other bounds are rounded outward.
pub(crate) fn spell(interval: Interval) -> String {
    if interval.is_empty() {
        return "[empty]".to_string();
    }
    let lo = shortest(interval.lo(), interval.lo().next_up(), |d| {
        d.to_interval().lo()
    })
    .unwrap_or_else(|| text::lower(interval.lo(), 17));
    let hi = shortest(interval.hi(), interval.hi().next_down(), |d| {
        d.to_interval().hi()
    })
    .unwrap_or_else(|| text::upper(interval.hi(), 17));
    if lo == hi {
        lo
    } else {
        format!("[{lo}, {hi}]")
    }
}

/// The shortest decimal near `end` whose enclosure ends at `end`; `inside` is the next float inward.
fn shortest(end: f64, inside: f64, enclosure_end: impl Fn(&Decimal) -> f64) -> Option<String> {
    // Minus zero is written as zero.
    [end, inside]
        .into_iter()
        .filter(|x| x.is_finite())
        .filter_map(|x| {
            // The shortest text of a float is only a guess here; the check below is exact.
            let x = if x == 0.0 { 0.0 } else { x };
            let plain = if x == 0.0 || (1e-4..1e9).contains(&x.abs()) {
                format!("{x}")
            } else {
                format!("{x:e}")
            };
            let decimal = Decimal::parse(&plain).ok()?;
            (enclosure_end(&decimal) == end).then_some(plain)
        })
        .min_by_key(String::len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_spelled_as_written() {
        for (lo, hi) in [
            ("-6", "-0.05"),
            ("0.08", "0.35"),
            ("1e-9", "0.1"),
            ("-0.2", "0.7"),
        ] {
            let (a, b) = (Decimal::parse(lo).unwrap(), Decimal::parse(hi).unwrap());
            let spelled = spell(a.to_interval().hull(b.to_interval()));
            assert_eq!(spelled, format!("[{lo}, {hi}]"));
        }
        assert_eq!(spell(Interval::ZERO), "0");
        assert_eq!(spell(Interval::new(-0.0, 2.0).unwrap()), "[0, 2]");
        assert_eq!(spell(Decimal::parse("0.1").unwrap().to_interval()), "0.1");
    }
}
