//! What a model file was understood to say, as text.

mod bounds;
mod expressions;
mod rows;
mod structure;

pub(crate) use bounds::spell;

use crate::graph::Names;
use crate::model::{ErrorBound, Guard, Hold, Model, Outliers, Relation, Signal};
use rows::{blanks, length, section};
use std::fmt::Write;
use veribound_interval::{Decimal, Interval};

impl Model {
    /// Everything the model says, in the user's names: quantities, modes with guards and
    /// derivatives, outputs with their bounds, signals, and what was proved about the guards. It proves that,
    /// as [`Model::facts`] and [`Model::overlaps`] do.
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
        let overlaps = self.overlaps();
        self.describe_overlaps(&overlaps, &names, &mut out);
        out.push('\n');
        let notes = self.notes.iter().map(|note| format!("note  {note}"));
        for line in self.findings(&overlaps).into_iter().chain(notes) {
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
            let mut error = bound(&input.error);
            match input.hold {
                Hold::Free => {}
                Hold::Sample => error.push_str(", constant from each sample to the next"),
                Hold::Level => error.push_str(", constant while the recorded value is"),
            }
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
            let held = match input.hold {
                Hold::Free => "any function of time",
                Hold::Sample | Hold::Level => "constant from each sample to the next",
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
            let mut error = bound(&output.error);
            if let Some(Outliers { most, of }) = output.outliers {
                let more = format!(", at most {most} of {of} samples in a row are outliers");
                error.push_str(&more);
            }
            vec![
                output.name.clone(),
                output.unit.clone(),
                format!("= {}", self.shown(output.expr, names)),
                error,
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
