//! Instances as text, each byte with its place in the file.

use super::index::{Bindings, spelled};
use super::numbers;
use super::origin::{Byte, Origin};
use super::parts::{Binder, Fold, Part};
use crate::file::LARGEST_FILE;
use crate::file::text::Text;
use crate::syntax::Problem;
use std::ops::Range;

/// The code of what is too much for a reader.
pub(super) const TOO_MUCH: &str = "E0245";

/// How numbers stand in a string.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Manner {
    /// Behind the letters of a name.
    Name,
    /// Behind the letters of a name, or as numbers.
    Expression,
    /// As they are: the string has a meaning outside of the model.
    Free,
}

/// One string without templates.
pub(super) struct One {
    pub value: String,
    bytes: Vec<Byte>,
    /// It stands in the file like this.
    is_copy: bool,
}

/// All strings without templates so far.
pub(super) struct Written {
    pub text: String,
    pub origin: Origin,
    steps: usize,
}

impl Written {
    /// Behind a file of `length` bytes.
    pub fn new(length: usize) -> Written {
        // A blank between the two keeps the end of the file a place of its own.
        Written {
            text: String::from("\n"),
            origin: Origin {
                length,
                bytes: vec![byte(length..length, 0)],
                instances: vec![String::new()],
            },
            steps: 0,
        }
    }

    /// Where the next string begins.
    pub fn start(&self) -> usize {
        self.origin.length + self.text.len()
    }

    /// Counts what is done for the template at `range`.
    pub fn step(&mut self, range: &Range<usize>) -> Result<(), Problem> {
        self.steps += 1;
        if self.steps <= LARGEST_FILE {
            return Ok(());
        }
        Err(Problem::new(
            TOO_MUCH,
            format!("the templates stand for more than {LARGEST_FILE} bytes of text"),
            range.clone(),
            "reached here",
            "make the sizes smaller, or sums shorter with names in [let]",
        ))
    }

    fn instance(&mut self, bindings: &Bindings) -> u32 {
        if bindings.is_empty() {
            return 0;
        }
        let own = spelled(bindings);
        let instances = &mut self.origin.instances;
        if instances.last() != Some(&own) {
            instances.push(own);
        }
        (instances.len() - 1) as u32
    }

    /// A string with numbers for its braces; ranges in it are bound.
    pub fn render(
        &mut self,
        text: &Text,
        parts: &[Part],
        manner: Manner,
        bindings: &Bindings,
        sizes: &Bindings,
    ) -> Result<One, Problem> {
        let mut one = One {
            value: String::new(),
            bytes: Vec::new(),
            is_copy: bindings.is_empty(),
        };
        if let ([Part::Plain(_)], true) = (parts, one.is_copy) {
            one.value.clone_from(&text.value);
            return Ok(one);
        }
        self.parts(text, parts, manner, &mut bindings.clone(), sizes, &mut one)?;
        Ok(one)
    }

    fn parts(
        &mut self,
        text: &Text,
        parts: &[Part],
        manner: Manner,
        bindings: &mut Bindings,
        sizes: &Bindings,
        one: &mut One,
    ) -> Result<(), Problem> {
        let instance = self.instance(bindings);
        for part in parts {
            match part {
                Part::Plain(range) => {
                    let plain = text.value.get(range.clone()).unwrap_or("");
                    for (at, symbol) in plain.char_indices() {
                        let inside = range.start + at..range.start + at + symbol.len_utf8();
                        self.step(&inside)?;
                        one.push(symbol, text.place(inside), instance);
                    }
                }
                Part::Index(index, range) => {
                    let value = index.value(bindings, sizes)?;
                    let spelled = number(value, manner, &one.value, range)
                        .map_err(|problem| told(problem, bindings))?;
                    one.is_copy = false;
                    self.insert(&spelled, text, range, instance, one)?;
                }
                Part::Range(binder) => {
                    let value = bindings.iter().find(|(name, _)| *name == binder.name);
                    let value = value.map_or(0, |(_, value)| *value);
                    let spelled = number(value, manner, &one.value, &binder.range)
                        .map_err(|problem| told(problem, bindings))?;
                    one.is_copy = false;
                    self.insert(&spelled, text, &binder.range, instance, one)?;
                }
                Part::Fold(fold, binder, body) => {
                    one.is_copy = false;
                    self.fold(text, (*fold, binder, body), bindings, sizes, one)?;
                }
            }
        }
        Ok(())
    }

    fn fold(
        &mut self,
        text: &Text,
        (fold, binder, body): (Fold, &Binder, &[Part]),
        bindings: &mut Bindings,
        sizes: &Bindings,
        one: &mut One,
    ) -> Result<(), Problem> {
        let outer = self.instance(bindings);
        let numbers =
            numbers(binder, bindings, sizes).map_err(|problem| told(problem, bindings))?;
        let range = &binder.range;
        if numbers.is_empty() {
            let Some(value) = fold.of_nothing() else {
                let problem = Problem::new(
                    "E0242",
                    "a range is empty, and nothing has no value here",
                    range.clone(),
                    "no number lies in here",
                    "write a range with a number in it; only sum, product and all can do without",
                );
                return Err(told(problem, bindings));
            };
            return self.insert(value, text, range, outer, one);
        }
        let [before, between, behind] = match numbers.clone().count() {
            1 => ["(", "", ")"],
            _ => fold.joints(),
        };
        self.insert(before, text, range, outer, one)?;
        let first = *numbers.start();
        for value in numbers {
            self.step(range)?;
            if value > first {
                self.insert(between, text, range, outer, one)?;
            }
            bindings.push((binder.name.clone(), value));
            let done = self.parts(text, body, Manner::Expression, bindings, sizes, one);
            bindings.pop();
            done?;
        }
        self.insert(behind, text, range, outer, one)
    }

    /// Text that stands for the template at `range`.
    fn insert(
        &mut self,
        inserted: &str,
        text: &Text,
        range: &Range<usize>,
        instance: u32,
        one: &mut One,
    ) -> Result<(), Problem> {
        for symbol in inserted.chars() {
            self.step(range)?;
            one.push(symbol, text.place(range.clone()), instance);
        }
        Ok(())
    }

    /// Appends `one` in quotes and gives its place; what stands in the file like this, at `range`,
    /// keeps its place there.
    pub fn span(&mut self, one: &One, range: &Range<usize>) -> Range<usize> {
        if one.is_copy {
            return range.clone();
        }
        let start = self.start();
        let instance = one.bytes.first().map_or(0, |byte| byte.instance);
        let quote = |at: usize| byte(at..at + 1, instance);
        self.append('"', quote(range.start));
        for (at, symbol) in one.value.char_indices() {
            let Some(&from) = one.bytes.get(at) else {
                continue;
            };
            match symbol {
                '"' | '\\' => {
                    self.append('\\', from);
                    self.append(symbol, from);
                }
                _ if symbol.is_control() => {
                    for symbol in format!("\\u{:04x}", symbol as u32).chars() {
                        self.append(symbol, from);
                    }
                }
                _ => self.append(symbol, from),
            }
        }
        self.append('"', quote(range.end.max(1) - 1));
        start..self.start()
    }

    /// Appends `raw`, which stands at `range` of the file, and gives its place.
    pub fn copy(&mut self, raw: &str, range: Range<usize>, bindings: &Bindings) -> Range<usize> {
        let start = self.start();
        let instance = self.instance(bindings);
        // What is too long is found where the next string is.
        self.steps += raw.len();
        for (at, symbol) in raw.char_indices() {
            let from = range.start + at;
            self.append(symbol, byte(from..from + symbol.len_utf8(), instance));
        }
        start..self.start()
    }

    /// Appends a bracket of a value at `at` that is an instance's.
    pub fn punctuate(&mut self, bracket: char, at: usize, bindings: &Bindings) {
        if !bindings.is_empty() {
            let instance = self.instance(bindings);
            self.append(bracket, byte(at..at + 1, instance));
        }
    }

    fn append(&mut self, symbol: char, from: Byte) {
        self.text.push(symbol);
        let bytes = std::iter::repeat_n(from, symbol.len_utf8());
        self.origin.bytes.extend(bytes);
    }
}

fn byte(range: Range<usize>, instance: u32) -> Byte {
    Byte {
        start: range.start as u32,
        end: range.end as u32,
        instance,
    }
}

impl One {
    fn push(&mut self, symbol: char, place: Range<usize>, instance: u32) {
        self.value.push(symbol);
        let bytes = std::iter::repeat_n(byte(place, instance), symbol.len_utf8());
        self.bytes.extend(bytes);
    }
}

/// The problem with what tells its instance.
fn told(mut problem: Problem, bindings: &Bindings) -> Problem {
    if !bindings.is_empty() {
        problem.message = format!("{} (with {})", problem.message, spelled(bindings));
    }
    problem
}

/// A number as it stands behind `before`.
fn number(
    value: i64,
    manner: Manner,
    before: &str,
    range: &Range<usize>,
) -> Result<String, Problem> {
    if manner == Manner::Free {
        return Ok(value.to_string());
    }
    let name = before.trim_end_matches(|c: char| c.is_alphanumeric() || c == '_');
    let behind = before.get(name.len()..).unwrap_or("");
    if behind.starts_with(|c: char| c.is_numeric()) || (behind.is_empty() && name.ends_with('.')) {
        return Err(Problem::new(
            "E0248",
            "an index stands directly behind a number",
            range.clone(),
            "read as further digits",
            "write `*` for a product, and `_` between two indices of a name: x{i}_{j}",
        ));
    }
    if value < 0 && !behind.is_empty() {
        return Err(Problem::new(
            "E0247",
            format!("the index of a name is negative: {value}"),
            range.clone(),
            "a name has no minus sign",
            "begin the range later, and write the first elements one by one",
        ));
    }
    Ok(match manner {
        Manner::Expression if value < 0 => format!("({value})"),
        _ => value.to_string(),
    })
}
