//! The course of a record, as far as an identification leaves it open.

use super::super::files::{figure_meta, push};
use super::{Data, Findings};
use veribound_data::Record;
use veribound_estimate::identify::{AfterReset, Conclusion};
use veribound_estimate::{Estimate, Observer, ObserverOptions, Verdict};
use veribound_flow::engine::Engine;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::{Model, Sample};
use veribound_report::{Course, FigureMeta, History, Zoom};

/// Samples between two questions whether to go on.
const ASKS: usize = 64;

/// The courses of all records, for the page, as long as `go_on` says so. None of a model that is refuted, or where the
/// user wanted an end.
pub fn all(
    model: &Model,
    data: &Data,
    found: &Findings,
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<Course>, Diagnostic> {
    let is_refuted = matches!(found.identified.conclusion, Conclusion::Inconsistent(_));
    if is_refuted || found.identified.interrupted {
        return Ok(Vec::new());
    }
    let records = data.records.iter().enumerate();
    let one = |(number, record): (usize, &Record)| {
        let meta = FigureMeta {
            page: true,
            ..figure_meta(model, Zoom::Off, None)
        };
        let mut history = History::new(meta);
        let mut each = |sample: &Sample, estimate: &Estimate| {
            push(&mut history, model, (sample, estimate), 0.0)
        };
        let passed = follow((model, data, found), number, &mut each, go_on)?;
        let samples = data.samples.get(number).map_or(0, Vec::len);
        Ok(Course {
            record: (data.records.len() > 1).then(|| record.path().display().to_string()),
            is_whole: passed == samples,
            history,
        })
    };
    records.map(one).collect()
}

/// Goes once through a record with all that is left, and tells `each` what is known after every sample; the number of
/// samples that were passed.
///
/// Guarantee: every solution with a start and parameters inside the outer bounds that agrees with the samples up to one
/// lies in the estimate of that sample. Parameters have their bounds from all records.
fn follow(
    (model, data, found): (&Model, &Data, &Findings),
    record: usize,
    each: &mut dyn FnMut(&Sample, &Estimate) -> Result<(), Diagnostic>,
    go_on: &dyn Fn() -> bool,
) -> Result<usize, Diagnostic> {
    let samples = data.samples.get(record).map_or(&[][..], Vec::as_slice);
    let later = found.identified.resets.get(record);
    let later = later.map_or(&[][..], Vec::as_slice);
    let first: Vec<Interval> = found.params(model).iter().map(|both| both.outer).collect();
    let mut observer = Observer::new(&left(model, found, record), options(found));
    let mut is_reset = vec![false; model.params.len()];
    for (position, sample) in samples.iter().enumerate() {
        if position % ASKS == 0 && !go_on() {
            return Ok(position);
        }
        // What is not proved any further ends the course.
        let Ok(Verdict::Consistent(mut estimate)) = observer.step(sample) else {
            return Ok(position);
        };
        let is_last = position + 1 == samples.len();
        let known = is_reset.iter_mut().zip(&estimate.resets);
        known.for_each(|(known, now)| *known |= *now);
        for (param, bounds) in estimate.params.iter_mut().enumerate() {
            let known = match is_reset.get(param) {
                Some(false) => first.get(param).copied(),
                _ => value_after_reset(later, param, (&sample.time, is_last)),
            };
            *bounds = bounds.intersect(known.unwrap_or(Interval::ENTIRE));
        }
        each(sample, &estimate)?;
    }
    Ok(samples.len())
}

/// Bounds of the value that a parameter has at a time after its first reset, where they are told.
fn value_after_reset(
    later: &[AfterReset],
    param: usize,
    (time, is_last): (&Decimal, bool),
) -> Option<Interval> {
    let mut own = later.iter().filter(|value| value.param == param);
    let holds = |value: &&AfterReset| {
        value.from <= *time && (*time < value.until || is_last && *time == value.until)
    };
    own.find(holds).map(|value| value.bounds.outer)
}

/// The model with no more than what is left of starts and parameters. A parameter that can be reset keeps its prior,
/// which its next value may have.
fn left(model: &Model, found: &Findings, record: usize) -> Model {
    let mut left = model.clone();
    let resettable = |at: usize| {
        let mut resets = model.signals.iter().flat_map(|signal| &signal.resets);
        resets.any(|reset| reset.param == at)
    };
    let params = left.params.iter_mut().zip(found.params(model)).enumerate();
    for (at, (param, both)) in params {
        if !resettable(at) {
            param.bounds = both.outer;
        }
    }
    for (state, both) in left.states.iter_mut().zip(found.start(model, record)) {
        state.init = both.outer;
    }
    left
}

/// One box; what is left is small where something is proved to agree, and then forms keep how it depends on parameters.
fn options(found: &Findings) -> ObserverOptions {
    let is_small = found.identified.conclusion == Conclusion::Consistent;
    ObserverOptions {
        boxes: 1,
        bisections: 0,
        engine: if is_small {
            Engine::Forms
        } else {
            Engine::Boxes
        },
        ..ObserverOptions::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::ending::Ending;
    use super::*;
    use std::fs;
    use veribound_data::RecordOptions;
    use veribound_estimate::identify::{IdentifyOptions, identify};
    use veribound_model::diagnostic::Diagnostics;

    /// What decays with an unknown rate, and is lifted by an unknown height where the signal is true.
    const TANK: &str = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1.1]\nparams.k = [0, 2]\nparams.c = [0, 1]\n\
        signals.new = { from = \"column\" }\nder.x = \"-k*x\"\noutputs.y = \"x + c +- 0.01\"\n";

    const LIFT: &str = "events.lift = { when = \"new\", lasts = 0, action = \"reset c\" }\n";

    /// Three seconds with the rate 0.7 and heights of 0.5, and of 0.25 from 1.5 s on if the signal says so.
    fn run(is_reset: bool) -> Result<(Model, Data, Findings), Diagnostics> {
        let place = tempfile::tempdir().unwrap();
        let model = [TANK, if is_reset { LIFT } else { "" }].concat();
        let model = Model::from_text("m.toml", &model)?;
        let path = place.path().join("r.csv");
        let row = |k: u32| {
            let t = f64::from(k) * 0.1;
            let now = is_reset && k >= 15;
            let y = (-0.7 * t).exp() + if now { 0.25 } else { 0.5 };
            format!("{t:.1},{y:.4},{}\n", u8::from(is_reset && k == 15))
        };
        let rows: String = (0..=30).map(row).collect();
        fs::write(&path, format!("t,y,new\n{rows}")).unwrap();
        let record = Record::open(&path, &model, RecordOptions::default())?;
        let samples = vec![record.all_samples()?];
        let data = Data {
            records: vec![record],
            samples,
        };
        let options = IdentifyOptions::default();
        let identified = identify(&model, &data.samples, &options, &|_| true);
        let found = Findings {
            identified,
            least: None,
            least_disturbance: None,
            seconds: 0.0,
            ending: Ending::Done,
        };
        Ok((model, data, found))
    }

    fn courses(run: &(Model, Data, Findings)) -> Vec<(Decimal, Estimate)> {
        let (model, data, found) = run;
        let mut all = Vec::new();
        let mut each = |sample: &Sample, estimate: &Estimate| {
            all.push((sample.time.clone(), estimate.clone()));
            Ok(())
        };
        let passed = follow((model, data, found), 0, &mut each, &|| true).unwrap();
        assert_eq!((passed, all.len()), (31, 31));
        all
    }

    /// Points that are proved to agree are on the border of what is left: what they do lies in the course.
    #[test]
    fn what_agrees_with_the_record_lies_in_its_course() {
        let run = run(false).unwrap();
        let (all, found) = (courses(&run), &run.2.identified);
        assert!(found.points.len() > 2);
        for (sample, (_, now)) in run.1.samples[0].iter().zip(&all) {
            assert!(now.outputs[0].is_subset_of(sample.outputs[0].unwrap()));
        }
        for point in &found.points {
            assert!(
                all[0].1.params[0]
                    .intersect(point[0])
                    .is_subset_of(point[0])
            );
            // Its start is not told; one start must fit at all times.
            let mut start = found.starts[0][0].outer;
            for (time, now) in &all {
                let grown = (point[0] * time.to_interval()).exp();
                start = start.intersect((now.outputs[0] - point[1]) * grown);
                assert!(!start.is_empty(), "{point:?} leaves the course at {time}");
                assert!(!now.params[0].intersect(point[0]).is_empty());
            }
        }
        // The ends of the inner bounds are reached, so no course without them is true.
        for (inner, param) in found.params.iter().zip(&all[30].1.params) {
            assert!(inner.inner.unwrap().is_subset_of(*param));
        }
    }

    #[test]
    fn a_value_after_a_reset_has_its_own_bounds() {
        let run = run(true).unwrap();
        let (all, found) = (courses(&run), &run.2.identified);
        let later = &found.resets[0][0];
        assert_eq!((later.param, later.from.to_string()), (1, "1.5".to_owned()));
        for (position, (_, now)) in all.iter().enumerate() {
            let (truth, other) = if position < 15 {
                (0.5, 0.25)
            } else {
                (0.25, 0.5)
            };
            assert!(
                now.params[1].contains(truth) && !now.params[1].contains(other),
                "{position}"
            );
            assert!(now.params[0].contains(0.7) && now.params[0].width() < 0.2);
            assert_eq!(now.resets[1], position == 15);
        }
        let from = |time: &str, is_last| {
            let time = Decimal::parse(time).unwrap();
            value_after_reset(&found.resets[0], 1, (&time, is_last)).is_some()
        };
        assert!(!from("1.4", false) && from("1.5", false) && from("2.9", false));
        assert!(from("3", true) && !from("3", false));
    }
}
