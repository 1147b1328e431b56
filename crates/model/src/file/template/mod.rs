//! Templates: what `"x{i=1..n}"` and `sum{j=1..n}(...)` stand for.
//!
//! A file with templates is expanded before it is read: the tree of the TOML becomes one without
//! braces, with the new strings appended to the text of the file. Everything behind this module reads the
//! longer text; [`Origin`] takes its messages back to the file as it was written.

mod index;
mod origin;
mod parts;
mod written;

use crate::diagnostic::SourceText;
use crate::file::reader::{Entry, Reader, Table};
use crate::file::scope::{Meaning, Scope};
use crate::file::text::Text;
use crate::syntax::Problem;
use index::{Bindings, spelled};
pub(crate) use origin::Origin;
use parts::{Binder, Part};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use written::{Manner, Written};

/// Instances of one range; a section has no more entries.
const MOST_INSTANCES: i64 = super::MOST_ENTRIES as i64;

const SIZES_HELP: &str = "write [sizes] with lines like n = 10";

/// The tree of `file` without templates. `reader` then has the text that its places are in.
///
/// `None` where something was reported.
pub(crate) fn expand<'t>(reader: &mut Reader, file: &DeTable<'t>) -> Option<DeTable<'t>> {
    let length = reader.source.text.len();
    let mut expansion = Expansion {
        reader,
        sizes: Vec::new(),
        written: Written::new(length),
        is_full: false,
    };
    expansion.read_sizes(file);
    let table = expansion.table(file, &(0..0), &Vec::new(), true);
    let Written { text, origin, .. } = expansion.written;
    if !reader.problems.is_empty() {
        return None;
    }
    let whole = reader.source.text.clone() + &text;
    let name = reader.source.name.clone();
    reader.source = Arc::new(SourceText::new(name, whole));
    reader.origin = origin;
    Some(table)
}

/// Takes the names of `[sizes]`, so that no quantity has them.
pub(crate) fn declare_sizes(reader: &mut Reader, file: &Table, scope: &mut Scope) {
    let section = file.find("sizes").map(|entry| entry.value);
    if let Some(section) = section
        && let Some(table) = reader.table(section, 0..0, SIZES_HELP)
    {
        for size in &table.entries {
            scope.declare(reader, size.key, size.place.clone(), Meaning::Size);
        }
    }
}

struct Expansion<'r> {
    reader: &'r mut Reader,
    sizes: Bindings,
    written: Written,
    /// Too much was written; nothing more is.
    is_full: bool,
}

impl Expansion<'_> {
    /// `[sizes]`; what has no name that can be used is reported with the names of the equations.
    fn read_sizes(&mut self, file: &DeTable) {
        let file = Table::new(&Origin::default(), file, 0..0);
        let Some(section) = file.find("sizes") else {
            return;
        };
        let place = section.place.clone();
        let Some(table) = self.reader.table(section.value, place, SIZES_HELP) else {
            return;
        };
        for Entry { key, value, .. } in &table.entries {
            let number = match value.value {
                DeValue::Integer(number) if number.radix() == 10 => {
                    number.as_str().parse::<i64>().ok()
                }
                _ => None,
            };
            match number.filter(|number| number.abs() <= index::LARGEST) {
                Some(number) => self.sizes.push((key.to_string(), number)),
                None => self.reader.report(
                    "E0107",
                    format!("the size `{key}` is no whole number"),
                    value.place(),
                    format!("expected one from -{0} to {0}", index::LARGEST),
                    format!("write {key} = 10"),
                ),
            }
        }
    }

    fn table<'t>(
        &mut self,
        table: &DeTable<'t>,
        place: &Range<usize>,
        bindings: &Bindings,
        is_file: bool,
    ) -> DeTable<'t> {
        let mut expanded = DeTable::new();
        // Every key with the template it is an instance of.
        let mut taken: BTreeMap<String, Range<usize>> = BTreeMap::new();
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        self.written.punctuate('{', place.start, bindings);
        for (key, value) in entries {
            let text = Text::new(&self.reader.source.text, key.span(), key.get_ref());
            let mut own = Vec::new();
            self.instances(
                &text,
                Manner::Name,
                bindings,
                &mut |expansion, inner, name| {
                    let span = expansion.written.span(&name, &text.range);
                    // The model's name is no name in the model.
                    let value = if is_file && name.value == "name" {
                        value.clone()
                    } else {
                        expansion.value(value, inner, name.value == "column")
                    };
                    own.push((name.value, span, value, spelled(inner)));
                },
            );
            for (name, span, value, instance) in own {
                if let Some(other) = taken.get(&name) {
                    self.clash(&name, &text.range, other, &instance);
                    continue;
                }
                taken.insert(name.clone(), text.range.clone());
                expanded.insert(Spanned::new(span, Cow::Owned(name)), value);
            }
        }
        self.written.punctuate('}', place.end.max(1) - 1, bindings);
        expanded
    }

    fn clash(&mut self, name: &str, place: &Range<usize>, other: &Range<usize>, instance: &str) {
        if self.is_told("E0246", place) {
            return;
        }
        let spelled = |place: &Range<usize>| {
            let text = self.reader.source.text.get(place.clone());
            text.unwrap_or("").trim_matches(['"', '\'']).to_string()
        };
        let with = if instance.is_empty() {
            String::new()
        } else {
            format!(" (with {instance})")
        };
        let label = if place == other {
            "two of its instances".to_string()
        } else {
            format!("also an instance of `{}`", spelled(other))
        };
        self.reader.report(
            "E0246",
            format!("`{name}` stands here twice{with}"),
            place.clone(),
            label,
            "make the ranges meet nowhere, as in {i=2..n}; put `_` between two indices: x{i}_{j}",
        );
    }

    fn value<'t>(
        &mut self,
        value: &Spanned<DeValue<'t>>,
        bindings: &Bindings,
        is_free: bool,
    ) -> Spanned<DeValue<'t>> {
        let from = self.written.start();
        let inner = match value.get_ref() {
            DeValue::Table(table) => {
                let place = value.span();
                DeValue::Table(self.table(table, &place, bindings, false))
            }
            DeValue::Array(array) => {
                self.written.punctuate('[', value.span().start, bindings);
                let mut items = toml::de::DeArray::new();
                for item in array.iter() {
                    if let DeValue::String(string) = item.get_ref() {
                        let text = Text::new(&self.reader.source.text, item.span(), string);
                        self.instances(&text, Manner::Expression, bindings, &mut |all, _, one| {
                            let span = all.written.span(&one, &text.range);
                            items.push(Spanned::new(span, DeValue::String(Cow::Owned(one.value))));
                        });
                    } else {
                        items.push(self.value(item, bindings, false));
                    }
                }
                let last = value.span().end.max(1) - 1;
                self.written.punctuate(']', last, bindings);
                DeValue::Array(items)
            }
            DeValue::String(string) if !(is_free && bindings.is_empty()) => {
                let text = Text::new(&self.reader.source.text, value.span(), string);
                let manner = if is_free {
                    Manner::Free
                } else {
                    Manner::Expression
                };
                let Some(one) = self.string(&text, manner, bindings) else {
                    return value.clone();
                };
                let span = self.written.span(&one, &text.range);
                return Spanned::new(span, DeValue::String(Cow::Owned(one.value)));
            }
            _ if bindings.is_empty() => return value.clone(),
            _ => {
                let raw = self.reader.source.text.get(value.span()).unwrap_or("");
                let span = self.written.copy(raw, value.span(), bindings);
                return Spanned::new(span, value.get_ref().clone());
            }
        };
        let span = if bindings.is_empty() {
            value.span()
        } else {
            from..self.written.start()
        };
        Spanned::new(span, inner)
    }

    /// A string that stands for one string.
    fn string(&mut self, text: &Text, manner: Manner, bindings: &Bindings) -> Option<written::One> {
        let parts = self.read(text)?;
        if let Some(Part::Range(binder)) = parts.iter().find(|part| matches!(part, Part::Range(_)))
        {
            let fold = "a range repeats a name, an item of a list, or what stands behind \
                        sum, product, min, max, all or any, as in sum{i=1..n}(x{i})";
            self.refuse(
                text,
                Problem::new(
                    "E0243",
                    "a range in braces has nothing to repeat here",
                    binder.range.clone(),
                    "neither in a name nor before a bracket",
                    fold,
                ),
            );
            return None;
        }
        let one = self
            .written
            .render(text, &parts, manner, bindings, &self.sizes);
        one.map_err(|problem| self.refuse(text, problem)).ok()
    }

    /// Calls `action` with every instance of a name or an item.
    fn instances(
        &mut self,
        text: &Text,
        manner: Manner,
        bindings: &Bindings,
        action: &mut dyn FnMut(&mut Self, &Bindings, written::One),
    ) {
        let Some(parts) = self.read(text) else {
            return;
        };
        let binders: Vec<&Binder> = parts
            .iter()
            .filter_map(|part| match part {
                Part::Range(binder) => Some(binder),
                _ => None,
            })
            .collect();
        let mut inner = bindings.clone();
        if let Err(problem) = self.repeat(text, &parts, &binders, manner, &mut inner, action) {
            self.refuse(text, problem);
        }
    }

    fn repeat(
        &mut self,
        text: &Text,
        parts: &[Part],
        binders: &[&Binder],
        manner: Manner,
        bindings: &mut Bindings,
        action: &mut dyn FnMut(&mut Self, &Bindings, written::One),
    ) -> Result<(), Problem> {
        let Some((binder, rest)) = binders.split_first() else {
            let one = self
                .written
                .render(text, parts, manner, bindings, &self.sizes)?;
            action(self, bindings, one);
            return Ok(());
        };
        for value in numbers(binder, bindings, &self.sizes)? {
            self.written.step(&binder.range)?;
            if self.is_full {
                break;
            }
            bindings.push((binder.name.clone(), value));
            let done = self.repeat(text, parts, rest, manner, bindings, action);
            bindings.pop();
            done?;
        }
        Ok(())
    }

    fn read(&mut self, text: &Text) -> Option<Vec<Part>> {
        if self.is_full {
            return None;
        }
        match parts::read(&text.value) {
            Ok(parts) => Some(parts),
            Err(problem) => {
                self.refuse(text, problem);
                None
            }
        }
    }

    fn is_told(&self, code: &str, place: &Range<usize>) -> bool {
        self.reader.problems.iter().any(|known| {
            known.code == code && known.place.as_ref().is_some_and(|(_, at)| at == place)
        })
    }

    /// Reports a problem once, in whichever instance it is met.
    fn refuse(&mut self, text: &Text, problem: Problem) {
        self.is_full |= problem.code == written::TOO_MUCH;
        let place = text.place(problem.range.clone());
        if !self.is_told(problem.code, &place) {
            self.reader.report_in(text, problem);
        }
    }
}

/// The numbers a range stands for; none where it ends just before it begins.
fn numbers(
    binder: &Binder,
    bindings: &Bindings,
    sizes: &Bindings,
) -> Result<std::ops::RangeInclusive<i64>, Problem> {
    let is_taken = |list: &Bindings| list.iter().any(|(name, _)| *name == binder.name);
    let refuse = |code, message, label, help: String| {
        Err(Problem::new(
            code,
            message,
            binder.range.clone(),
            label,
            help,
        ))
    };
    if is_taken(sizes) || is_taken(bindings) {
        let what = if is_taken(sizes) {
            "a size"
        } else {
            "an index"
        };
        return refuse(
            "E0243",
            format!("`{}` is {what} already", binder.name),
            "cannot run through a range",
            "take another name for this index".into(),
        );
    }
    let (first, last) = (
        binder.first.value(bindings, sizes)?,
        binder.last.value(bindings, sizes)?,
    );
    if last < first - 1 {
        return refuse(
            "E0242",
            format!("a range runs backwards, from {first} to {last}"),
            "no number lies in here",
            "write the smaller number first; a range that ends one below its beginning is empty"
                .into(),
        );
    }
    if last - first >= MOST_INSTANCES {
        return refuse(
            written::TOO_MUCH,
            format!("a range has {} numbers", last - first + 1),
            "too many",
            format!("write a range of at most {MOST_INSTANCES} numbers"),
        );
    }
    Ok(first..=last)
}
