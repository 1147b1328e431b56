//! Verdicts of identifications in words.

use super::super::ending::Ending;
use super::super::message::{complain, remark};
use super::super::numbers::{counted, show_time};
use super::super::verdict::{NOTHING_EXPLAINS, at_line};
use super::{Data, Findings};
use veribound_data::Verdict;
use veribound_estimate::identify::{Conclusion, Limit, Refuted};
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;

/// The verdict, and why where that is not plain.
pub fn in_words(found: &Findings) -> (Verdict, Option<String>) {
    match found.identified.conclusion {
        Conclusion::Consistent => (Verdict::Consistent, None),
        Conclusion::Inconsistent(_) => (Verdict::Inconsistent, Some(NOTHING_EXPLAINS.to_owned())),
        Conclusion::Undecided => (Verdict::Undecided, Some(why_undecided(found))),
    }
}

/// What stood in the way of a proof.
fn why_undecided(found: &Findings) -> String {
    let sets = found.identified.sets;
    let sets = counted(sets, "set was looked at", "sets were looked at");
    if found.identified.interrupted {
        format!("interrupted after {sets}")
    } else if found.identified.limits.contains(&Limit::Enclosure) {
        "solutions could not be enclosed to the end of the record".to_owned()
    } else if found.identified.limits.contains(&Limit::Inputs) {
        format!("{sets}, and no course of the inputs is proved to agree with the record")
    } else {
        format!("{sets}, and no point is proved to agree with the record")
    }
}

/// Which samples refute the model, in one sentence.
pub fn refuted_by(data: &Data, refuted: &Refuted) -> String {
    let name = data.name(refuted.record);
    let lines = data.lines(refuted.record, &refuted.samples);
    let by = match lines.as_slice() {
        [] => String::new(),
        [_] => "; this line refutes alone".to_owned(),
        lines => format!("; {} refute together", these(lines)),
    };
    format!(
        "nothing agrees with {name} up to t = {} s (line {}){by}",
        show_time(&refuted.time),
        refuted.line
    )
}

/// So many lines are named one by one.
const NAMED: usize = 8;

/// `lines 3, 5 and 9`, or how many where they are many.
fn these(lines: &[usize]) -> String {
    let text = |lines: &[usize]| {
        let texts: Vec<String> = lines.iter().map(usize::to_string).collect();
        texts.join(", ")
    };
    match lines {
        [all @ .., last] if lines.len() <= NAMED => format!("lines {} and {last}", text(all)),
        _ => {
            let first = lines.get(..NAMED - 1).unwrap_or(lines);
            let others = lines.len() - first.len();
            format!("lines {} and {others} others", text(first))
        }
    }
}

/// Why a run did not end consistent.
pub fn problem(model: &Model, data: &Data, found: &Findings) -> Option<Diagnostic> {
    match &found.identified.conclusion {
        Conclusion::Inconsistent(refuted) => Some(inconsistent(model, data, refuted)),
        Conclusion::Undecided if found.ending == Ending::Undecided => Some(undecided(found)),
        _ => None,
    }
}

/// Tells on stderr why a run did not end consistent.
pub fn explain(model: &Model, data: &Data, found: &Findings, at_length: bool) {
    if let Some(problem) = problem(model, data, found) {
        complain(&problem.into());
    }
    if found.ending == Ending::Interrupted && at_length {
        remark("interrupted: the files tell what was proved until then");
    }
}

/// The message of a proved contradiction.
fn inconsistent(model: &Model, data: &Data, refuted: &Refuted) -> Diagnostic {
    let problem = Diagnostic::new("E0301", format!("{NOTHING_EXPLAINS} (proved)"));
    let label = format!(
        "t = {} s: read up to here, the record refutes the model",
        show_time(&refuted.time)
    );
    let label = match data.lines(refuted.record, &refuted.samples).as_slice() {
        [] => label,
        [_] => format!("{label}, by this line alone"),
        lines => format!("{label}, by {} together", these(lines)),
    };
    let problem = match data.records.get(refuted.record) {
        Some(record) => at_line(problem, record, refuted.line, label),
        None => problem,
    };
    let inputs = if model.recorded_inputs().next().is_some() {
        ", `--input-error`"
    } else {
        ""
    };
    problem.help(format!(
        "widen what is not certain: the error bounds of the outputs (`--output-error`), the priors, \
         disturbances{inputs}, or `--reset` for a parameter that changes"
    ))
}

/// The message of a run that ended without a proof.
fn undecided(found: &Findings) -> Diagnostic {
    let message = "it is not proved whether any parameters agree with the record";
    let help = if found.identified.limits.contains(&Limit::Enclosure) {
        "narrow the priors or start intervals, or read less of the record (`--to`); the bounds hold as \
         they are"
    } else if found.identified.limits.contains(&Limit::Inputs) {
        "smaller errors of inputs, or such that stay the same for a while (`hold`), tell more; the bounds hold as they are"
    } else {
        "allow for more sets (`--sets`), or narrow the priors; the bounds hold as they are"
    };
    Diagnostic::new("E0303", format!("{message}: {}", why_undecided(found))).help(help)
}

#[cfg(test)]
mod tests {
    use super::super::told::tests::{data, found, model};
    use super::*;
    use veribound_interval::Decimal;
    use veribound_model::diagnostic::Diagnostics;

    fn refuted(samples: &[usize]) -> Refuted {
        Refuted {
            record: 0,
            samples: samples.to_vec(),
            time: Decimal::parse("0.3").unwrap(),
            line: 5,
        }
    }

    #[test]
    fn samples_that_refute_together_are_told_word_for_word() {
        let place = tempfile::tempdir().unwrap();
        let (model, data) = (model(), data(place.path(), &[5]));
        let path = data.name(0);
        let problem = inconsistent(&model, &data, &refuted(&[0, 1, 3]));
        let said = Diagnostics::from(problem).render(false);
        let wanted = format!(
            "error[E0301]: no parameter in the prior explains the data (proved)\n --> {path}:5:1\n  |\n5 | \
             0.3,1,0.6\n  | ^^^^^^^^^ t = 0.3 s: read up to here, the record refutes the model, by lines 2, 3 and 5 \
             together\n  |\n  = help: widen what is not certain: the error bounds of the outputs (`--output-error`), \
             the priors, disturbances, `--input-error`, or `--reset` for a parameter that changes\n"
        );
        assert_eq!(said, wanted);
        assert_eq!(
            refuted_by(&data, &refuted(&[0, 1, 3])),
            format!(
                "nothing agrees with {path} up to t = 0.3 s (line 5); lines 2, 3 and 5 refute together"
            )
        );
        assert_eq!(
            refuted_by(&data, &refuted(&[3])),
            format!("nothing agrees with {path} up to t = 0.3 s (line 5); this line refutes alone")
        );
        assert_eq!(
            refuted_by(&data, &refuted(&[])),
            format!("nothing agrees with {path} up to t = 0.3 s (line 5)")
        );
    }

    #[test]
    fn many_lines_are_counted() {
        let lines: Vec<usize> = (1..=20).collect();
        assert_eq!(these(&lines), "lines 1, 2, 3, 4, 5, 6, 7 and 13 others");
        assert_eq!(these(&[3, 4]), "lines 3 and 4");
    }

    #[test]
    fn an_open_end_is_told_word_for_word() {
        let mut found = found();
        found.identified.conclusion = Conclusion::Undecided;
        found.identified.limits = vec![Limit::Budget, Limit::Record];
        let said = Diagnostics::from(undecided(&found)).render(false);
        let wanted = "error[E0303]: it is not proved whether any parameters agree with the record: 12 sets were \
            looked at, and no point is proved to agree with the record\n |\n = help: allow for more sets \
            (`--sets`), or narrow the priors; the bounds hold as they are\n";
        assert_eq!(said, wanted);
        found.identified.limits = vec![Limit::Enclosure, Limit::Budget];
        let said = Diagnostics::from(undecided(&found)).render(false);
        let wanted = "error[E0303]: it is not proved whether any parameters agree with the record: solutions \
            could not be enclosed to the end of the record\n |\n = help: narrow the priors or start intervals, or \
            read less of the record (`--to`); the bounds hold as they are\n";
        assert_eq!(said, wanted);
        found.identified.interrupted = true;
        assert_eq!(
            in_words(&found).1.unwrap(),
            "interrupted after 12 sets were looked at"
        );
    }
}
