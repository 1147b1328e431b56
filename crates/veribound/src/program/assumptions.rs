//! What a run assumes beside the model file: flags that weaken it.
//!
//! Every flag here lets in more solutions than the model file does (a parameter that may change, an
//! input that may be further off), so whatever is proved with it is proved of the model file's own
//! solutions too. Flags that would shut solutions out are refused.

use super::arguments::Weakening;
use super::flags::{ErrorBoundFlag, InputErrorFlag, ResetFlag};
use super::message::{flag_problem, list};
use veribound_interval::Decimal;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_model::{ErrorBound, Hold, Model, Output, Reset};

/// Changes the model as the flags say; gives a sentence for every change.
pub fn weaken(model: &mut Model, flags: &Weakening) -> Result<Vec<String>, Diagnostics> {
    let mut said = Vec::new();
    let mut problems = Vec::new();
    for flag in &flags.reset {
        match reset(model, flag) {
            Ok(change) => said.push(change),
            Err(problem) => problems.push(problem),
        }
    }
    for flag in &flags.input_error {
        match input_error(model, flag) {
            Ok(change) => said.push(change),
            Err(problem) => problems.push(problem),
        }
    }
    for flag in &flags.output_error {
        match output_error(model, flag) {
            Ok(change) => said.push(change),
            Err(problem) => problems.push(problem),
        }
    }
    if problems.is_empty() {
        Ok(said)
    } else {
        Err(Diagnostics(problems))
    }
}

/// Refuses outputs that may have outliers, of which an observer could use no sample.
pub fn refuse_outliers(model: &Model) -> Result<(), Diagnostic> {
    let mut outputs = model.outputs.iter();
    let may_miss = |output: &&Output| output.outliers.is_some_and(|outliers| outliers.most > 0);
    let Some(output) = outputs.find(may_miss) else {
        return Ok(());
    };
    let message = format!(
        "the output `{}` may have outliers, and an observer, which goes sample by sample, can use no sample that may be one",
        output.name
    );
    Err(Diagnostic::new("E0616", message)
        .help("use `veribound identify`, which reads samples together, or remove `outliers` from the model file"))
}

fn reset(model: &mut Model, flag: &ResetFlag) -> Result<String, Diagnostic> {
    let part = |range: &std::ops::Range<usize>| flag.text.get(range.clone()).unwrap_or_default();
    let (name, trigger) = (part(&flag.param), part(&flag.trigger));
    let typed = |range| ("--reset", flag.text.as_str(), range);
    let Some(param) = model.params.iter().position(|param| param.name == name) else {
        let known = list(model.params.iter().map(|param| param.name.as_str()));
        return Err(flag_problem(
            "E0601",
            format!("the model has no parameter `{name}`"),
            typed(flag.param.clone()),
            "not in [params]",
            format!("its parameters are {known}"),
        ));
    };
    let event_time = |event: &str| {
        let resets = model
            .signals
            .iter()
            .enumerate()
            .flat_map(|(at, signal)| signal.resets.iter().map(move |reset| (at, reset)));
        resets
            .into_iter()
            .find(|(_, reset)| reset.event == event)
            .map(|(at, reset)| {
                (
                    at,
                    flag.lasts.clone().unwrap_or_else(|| reset.lasts.clone()),
                )
            })
    };
    let by_signal = model
        .signals
        .iter()
        .position(|signal| signal.name == trigger);
    let by_signal = by_signal.map(|at| (at, flag.lasts.clone().unwrap_or_else(Decimal::zero)));
    let Some((signal, lasts)) = by_signal.or_else(|| event_time(trigger)) else {
        let signals = list(model.signals.iter().map(|signal| signal.name.as_str()));
        return Err(flag_problem(
            "E0602",
            format!("the model has no signal or event `{trigger}`"),
            typed(flag.trigger.clone()),
            "not in [signals] or [events]",
            format!("its signals are {signals}"),
        ));
    };
    let change = format!(
        "{name} may take a new value at every sample at which {} has been true for {lasts} s \
         (--reset)",
        model
            .signals
            .get(signal)
            .map_or("", |signal| signal.name.as_str()),
    );
    if let Some(signal) = model.signals.get_mut(signal) {
        signal.resets.push(Reset {
            event: trigger.to_owned(),
            param,
            lasts,
        });
    }
    Ok(change)
}

fn input_error(model: &mut Model, flag: &InputErrorFlag) -> Result<String, Diagnostic> {
    let (flag, hold) = (&flag.error, flag.hold);
    let known = list(model.recorded_inputs().map(|input| input.name.as_str()));
    let named = |name: &str| name == flag.name;
    let mut inputs = model.inputs.iter_mut();
    let Some(input) = inputs.find(|input| named(&input.name) && input.within.is_none()) else {
        return Err(flag_problem(
            "E0603",
            format!("the model has no input `{}`", flag.name),
            ("--input-error", flag.text.as_str(), 0..flag.name.len()),
            "not in [inputs]",
            format!("its inputs are {known}"),
        ));
    };
    let is_exact = input.error.absolute.is_zero() && input.error.relative.is_zero();
    if !is_exact && strictness(hold) > strictness(input.hold) {
        return Err(flag_problem(
            "E0604",
            format!(
                "the model file lets the error of `{}` change more often; a flag cannot take that back",
                flag.name
            ),
            ("--input-error", flag.text.as_str(), 0..flag.text.len()),
            "more is known than the model file says",
            "write hold in the model file if it is so",
        ));
    }
    let mut change = grow("--input-error", flag, &mut input.error, &input.unit)?;
    input.hold = hold;
    match hold {
        Hold::Free => {}
        Hold::Sample => change.push_str(", by the same from each sample to the next"),
        Hold::Level => change.push_str(", by the same as long as the recorded value is the same"),
    }
    Ok(change)
}

/// How much is said of the course of an error.
fn strictness(hold: Hold) -> u8 {
    match hold {
        Hold::Free => 0,
        Hold::Sample => 1,
        Hold::Level => 2,
    }
}

fn output_error(model: &mut Model, flag: &ErrorBoundFlag) -> Result<String, Diagnostic> {
    let known = list(model.outputs.iter().map(|output| output.name.as_str()));
    let mut outputs = model.outputs.iter_mut();
    let Some(output) = outputs.find(|output| output.name == flag.name) else {
        return Err(flag_problem(
            "E0601",
            format!("the model has no output `{}`", flag.name),
            ("--output-error", flag.text.as_str(), 0..flag.name.len()),
            "not in [outputs]",
            format!("its outputs are {known}"),
        ));
    };
    grow("--output-error", flag, &mut output.error, &output.unit)
}

/// Takes a larger error bound; gives the sentence that says so.
fn grow(
    name: &str,
    flag: &ErrorBoundFlag,
    error: &mut ErrorBound,
    unit: &str,
) -> Result<String, Diagnostic> {
    let (own, kind) = if flag.is_relative {
        (&mut error.relative, "times the recorded value")
    } else {
        (&mut error.absolute, unit)
    };
    if flag.bound < *own {
        return Err(flag_problem(
            "E0604",
            format!(
                "the model file allows `{}` an error of {own} {kind}; a flag cannot take that back",
                flag.name
            ),
            (name, flag.text.as_str(), 0..flag.text.len()),
            "less than the model file says",
            "change the error bound in the model file if it is too large",
        ));
    }
    let change = format!(
        "{} may be off by {} {kind}, {own} in the model file ({name})",
        flag.name, flag.bound
    );
    *own = flag.bound.clone();
    Ok(change)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model() -> Model {
        let text = "format = 1\nstates = [\"phi\"]\ninit.phi = 0\n\
            inputs.u = { unit = \"V\", error = { relative = 0.05 } }\n\
            [params]\na = [1, 2]\n\
            [der]\nphi = \"a * u\"\n\
            [signals]\nstill = { from = \"column\", type = \"bool\" }\n\
            [events.stop]\nwhen = \"still\"\nlasts = 0.5\naction = \"reset a\"\n\
            [outputs]\ny = \"phi +- 0.1\"\n";
        Model::from_text("x.toml", text).unwrap()
    }

    fn flags(reset: &[&str], input_error: &[&str]) -> Weakening {
        Weakening {
            reset: reset.iter().map(|text| text.parse().unwrap()).collect(),
            input_error: input_error
                .iter()
                .map(|text| text.parse().unwrap())
                .collect(),
            output_error: Vec::new(),
        }
    }

    fn number(text: &str) -> Decimal {
        Decimal::parse(text).unwrap()
    }

    #[test]
    fn a_reset_is_added_to_those_of_the_model() {
        let mut model = model();
        let said = weaken(
            &mut model,
            &flags(&["a@still:0.2", "a@stop", "a@still"], &[]),
        )
        .unwrap();
        let lasts: Vec<Decimal> = model.signals[0]
            .resets
            .iter()
            .map(|reset| reset.lasts.clone())
            .collect();
        assert_eq!(lasts, ["0.5", "0.2", "0.5", "0"].map(number));
        assert_eq!(said.len(), 3);
        assert!(
            said[0].contains("still has been true for 0.2 s"),
            "{}",
            said[0]
        );
    }

    #[test]
    fn an_input_error_can_only_grow() {
        let mut weaker = model();
        weaken(&mut weaker, &flags(&[], &["u=10%", "u=0.02"])).unwrap();
        assert_eq!(weaker.inputs[0].error.relative, number("0.1"));
        assert_eq!(weaker.inputs[0].error.absolute, number("0.02"));
        let refused = weaken(&mut model(), &flags(&[], &["u=1%"])).unwrap_err();
        assert_eq!(refused.0[0].code, "E0604");
    }

    #[test]
    fn the_course_of_an_error_cannot_be_known_better() {
        let refused = weaken(&mut model(), &flags(&[], &["u=10%@level"])).unwrap_err();
        assert_eq!(refused.0[0].code, "E0604");
        let mut exact = model();
        exact.inputs[0].error.relative = number("0");
        let said = weaken(&mut exact, &flags(&[], &["u=10%@level"])).unwrap();
        assert_eq!(exact.inputs[0].hold, Hold::Level);
        assert!(
            said[0].ends_with("as long as the recorded value is the same"),
            "{}",
            said[0]
        );
        weaken(&mut exact, &flags(&[], &["u=20%"])).unwrap();
        assert_eq!(exact.inputs[0].hold, Hold::Free);
    }

    #[test]
    fn so_can_an_output_error() {
        let mut weaker = model();
        let mut asked = flags(&[], &[]);
        asked.output_error = vec!["y=0.2".parse().unwrap(), "y=1%".parse().unwrap()];
        let said = weaken(&mut weaker, &asked).unwrap();
        assert_eq!(weaker.outputs[0].error.absolute, number("0.2"));
        assert_eq!(weaker.outputs[0].error.relative, number("0.01"));
        assert!(said[0].ends_with("(--output-error)"), "{}", said[0]);
        asked.output_error = vec!["y=0.05".parse().unwrap(), "z=1".parse().unwrap()];
        let refused = weaken(&mut model(), &asked).unwrap_err();
        let codes: Vec<&str> = refused.0.iter().map(|problem| problem.code).collect();
        assert_eq!(codes, ["E0604", "E0601"]);
    }

    #[test]
    fn names_that_the_model_does_not_have_are_refused_together() {
        let refused = weaken(&mut model(), &flags(&["b@still", "a@x"], &["w=1%"])).unwrap_err();
        let codes: Vec<&str> = refused.0.iter().map(|problem| problem.code).collect();
        assert_eq!(codes, ["E0601", "E0602", "E0603"]);
    }
}
