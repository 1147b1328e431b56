//! One row: checks and values of everything the model needs.

use super::RecordOptions;
use super::cell;
use super::header::Place;
use super::layout::{Layout, Source};
use super::messages::{self, Need};
use super::problems::Problems;
use crate::reader::fields::{self, content};
use crate::reader::{Line, bad_quotes, is_comment};
use std::ops::Range;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::model::Sample;

/// What a line holds.
#[derive(Debug)]
pub(crate) enum Row {
    /// No sample: a comment, or only blanks and separators.
    Nothing,
    /// A sample before the window.
    Before,
    /// A sample after the window.
    After,
    /// A sample of the window.
    Sample(Sample),
    /// Something is wrong, and is among the problems.
    Bad,
}

/// Reads rows in their order.
#[derive(Debug)]
pub(crate) struct Rows {
    ranges: Vec<Range<usize>>,
    previous: Option<(Decimal, usize)>,
    /// For every input what was last recorded, and every value that it could have.
    inputs: Vec<(Interval, Interval)>,
}

impl Rows {
    pub(crate) fn new() -> Self {
        Rows {
            ranges: Vec::new(),
            previous: None,
            inputs: Vec::new(),
        }
    }

    /// Time of the last row that had one.
    pub(crate) fn time(&self) -> Option<&Decimal> {
        self.previous.as_ref().map(|(time, _)| time)
    }

    /// Reads one line.
    pub(crate) fn read(
        &mut self,
        line: Line<'_>,
        layout: &Layout,
        options: &RecordOptions,
        problems: &mut Problems,
    ) -> Row {
        if is_comment(line.text) {
            return Row::Nothing;
        }
        if let Err(error) = fields::split(line.text, layout.header.separator, &mut self.ranges) {
            problems.add("E0406", 0, || bad_quotes(line, error));
            return Row::Bad;
        }
        if self.ranges.iter().all(|range| range.is_empty()) {
            return Row::Nothing;
        }
        if self.ranges.len() != layout.header.columns.len() {
            problems.add("E0407", 0, || {
                messages::ragged(line, &self.ranges, &layout.header)
            });
            return Row::Bad;
        }
        let mut cells = Cells {
            line,
            ranges: &self.ranges,
            layout,
            problems,
            is_good: true,
        };
        let Ok(time) = cells.required(layout.time, Need::Time) else {
            return Row::Bad;
        };
        if let Some(before) = &self.previous {
            cells.must_follow(&time, before);
        }
        self.previous = Some((time.clone(), line.number));
        if options.from.as_ref().is_some_and(|from| time < *from) {
            return if cells.is_good { Row::Before } else { Row::Bad };
        }
        if options.to.as_ref().is_some_and(|to| time > *to) {
            return if cells.is_good { Row::After } else { Row::Bad };
        }
        let sample = Sample {
            time,
            inputs: cells.inputs(&mut self.inputs),
            outputs: cells.outputs(),
            signals: cells.signals(),
            line: line.number,
        };
        if cells.is_good {
            Row::Sample(sample)
        } else {
            Row::Bad
        }
    }
}

/// The fields of a row, and where its problems go.
struct Cells<'a> {
    line: Line<'a>,
    ranges: &'a [Range<usize>],
    layout: &'a Layout,
    problems: &'a mut Problems,
    is_good: bool,
}

/// Nothing to use: the reason is among the problems.
struct Reported;

impl Cells<'_> {
    /// What inputs may be. Two samples in a row that recorded other values have other bounds, too: who takes the error of
    /// an input for constant while the same is recorded sees it by these.
    fn inputs(&mut self, last: &mut Vec<(Interval, Interval)>) -> Vec<Interval> {
        let layout = self.layout;
        let count = layout.inputs.len() + layout.disturbances.len();
        let mut values = Vec::with_capacity(count);
        for source in &layout.inputs {
            let recorded = match source.place {
                Place::Value(at) => self
                    .required(at, Need::Input)
                    .map(|value| source.enclose(&value)),
                Place::Bounds(lo, hi) => self.between(source, (lo, hi), Need::InputBound),
            };
            let Ok(recorded) = recorded else { continue };
            let position = values.len();
            let mut value = source.error.enclose(recorded);
            let before = last.get(position);
            if before.is_some_and(|before| before.0 != recorded && before.1 == value) {
                // The difference is lost beside a large error.
                value = Interval::new(value.lo(), value.hi().next_up()).unwrap_or(value);
            }
            values.push(value);
            match last.get_mut(position) {
                Some(before) => *before = (recorded, value),
                None => last.push((recorded, value)),
            }
        }
        values.extend(&layout.disturbances);
        values
    }

    fn outputs(&mut self) -> Vec<Option<Interval>> {
        let layout = self.layout;
        let mut values = Vec::with_capacity(layout.outputs.len());
        for source in &layout.outputs {
            let recorded = match source.place {
                Place::Value(at) => {
                    let number = self.number(at);
                    number.map(|value| value.map(|value| source.enclose(&value)))
                }
                Place::Bounds(lo, hi) if self.is_missing(lo) && self.is_missing(hi) => Ok(None),
                Place::Bounds(lo, hi) => {
                    self.between(source, (lo, hi), Need::OutputBound).map(Some)
                }
            };
            values.extend(recorded.map(|value| value.map(|v| source.error.enclose(v))));
        }
        values
    }

    fn signals(&mut self) -> Vec<Option<bool>> {
        let layout = self.layout;
        let mut values = Vec::with_capacity(layout.signals.len());
        for (name, at) in &layout.signals {
            let range = self.range(*at);
            let text = content(self.line.text, range.clone());
            let value = cell::signal(&text);
            if value.is_none() {
                let line = self.line;
                self.problem("E0417", *at, || {
                    messages::no_signal(line, range, name, &text)
                });
            }
            values.extend(value);
        }
        values
    }

    /// The smallest interval around two recorded bounds, in the unit of the model.
    fn between(
        &mut self,
        source: &Source,
        (lo, hi): (usize, usize),
        need: Need,
    ) -> Result<Interval, Reported> {
        let (lower, upper) = (self.required(lo, need), self.required(hi, need));
        let (lower, upper) = (lower?, upper?);
        if lower > upper {
            let (line, range) = (self.line, self.range(hi));
            return Err(self.problem("E0418", hi, || {
                messages::reversed(line, range, &source.name, (&lower, &upper))
            }));
        }
        Ok(source.enclose(&lower).hull(source.enclose(&upper)))
    }

    /// A number that must be there.
    fn required(&mut self, at: usize, need: Need) -> Result<Decimal, Reported> {
        if let Some(number) = self.number(at)? {
            return Ok(number);
        }
        let (line, range, layout) = (self.line, self.range(at), self.layout);
        Err(self.problem("E0414", at, || {
            messages::missing(line, range, need, layout.header.text_of(at))
        }))
    }

    /// A number, or `None` where it is missing.
    fn number(&mut self, at: usize) -> Result<Option<Decimal>, Reported> {
        let range = self.range(at);
        let text = content(self.line.text, range.clone());
        cell::number(&text).map_err(|fault| {
            let (line, layout) = (self.line, self.layout);
            self.problem(fault.code(), at, || {
                messages::no_number(line, range, layout.header.text_of(at), (&text, fault))
            })
        })
    }

    fn is_missing(&self, at: usize) -> bool {
        cell::number(&content(self.line.text, self.range(at))) == Ok(None)
    }

    /// Checks that `time` is later than the stamp before it.
    fn must_follow(&mut self, time: &Decimal, before: &(Decimal, usize)) {
        if *time > before.0 {
            return;
        }
        let (line, at) = (self.line, self.layout.time);
        let range = self.range(at);
        self.problem("E0415", at, || {
            messages::not_later(line, range, time, before)
        });
    }

    fn problem(
        &mut self,
        code: &'static str,
        column: usize,
        make: impl FnOnce() -> Diagnostic,
    ) -> Reported {
        self.is_good = false;
        self.problems.add(code, column, make);
        Reported
    }

    fn range(&self, at: usize) -> Range<usize> {
        self.ranges.get(at).cloned().unwrap_or_default()
    }
}
