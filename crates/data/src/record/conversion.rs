//! From the units of columns to the units of the model.

use super::header::Place;
use super::layout::Finder;
use super::units::{self, Relation, Written};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::units::Conversion;

impl Finder<'_> {
    /// How the numbers at `place` become numbers in the unit of the model.
    pub(super) fn conversion(
        &mut self,
        place: Place,
        name: &str,
        unit: &str,
    ) -> Option<Conversion> {
        if unit.is_empty() {
            return None;
        }
        let header = self.header;
        let at = match place {
            Place::Value(at) => at,
            Place::Bounds(lo, hi) => {
                if header.unit_of(lo, name) != header.unit_of(hi, name) {
                    self.two_units(hi, name);
                    return None;
                }
                lo
            }
        };
        let written = header.unit_of(at, name)?;
        let spelled = header.spell(place);
        let text = written.text;
        match units::compare(written, unit) {
            Relation::Same => None,
            Relation::Converted(conversion) => {
                let factor = conversion.factor();
                self.conversions.push(format!(
                    "the column `{spelled}` is in {text} and converted to {unit}: times {factor}"
                ));
                Some(conversion)
            }
            Relation::Unclear => {
                self.warnings.push(format!(
                    "the column `{spelled}` is in {text}, the model says {unit} for `{name}`: the numbers are taken as they are",
                ));
                None
            }
            other => {
                self.other_unit(at, written, (name, unit), other == Relation::OtherZero);
                None
            }
        }
    }

    fn other_unit(
        &mut self,
        at: usize,
        written: Written<'_>,
        (name, unit): (&str, &str),
        is_temperature: bool,
    ) {
        let (column, text) = (self.header.text_of(at), written.text);
        let problem = Diagnostic::new(
            "E0421",
            format!("the column `{column}` is in {text}, the model says {unit} for `{name}`"),
        );
        let (label, help) = match is_temperature {
            true => (
                "a scale with another zero",
                format!("record it in {unit}, or write the model in {text}"),
            ),
            false => (
                "another dimension",
                format!("record it in {unit}, or correct the unit that is wrong"),
            ),
        };
        let problem = self.header.mark_column(at, problem, label);
        self.problems.end(problem.help(help));
    }

    fn two_units(&mut self, at: usize, name: &str) {
        let problem = Diagnostic::new(
            "E0421",
            format!("the two bounds of `{name}` are in different units"),
        );
        let problem = self
            .header
            .mark_column(at, problem, "unlike the lower bound");
        self.problems
            .end(problem.help("write both bounds in one unit and say it in both headers"));
    }
}
