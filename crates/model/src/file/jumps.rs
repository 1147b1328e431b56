//! The section [jumps].

use crate::diagnostic::nearest;
use crate::file::equations::{equation, report_all};
use crate::file::lower::{Lowering, both, negated};
use crate::file::reader::{Entry, Reader, Table};
use crate::file::scope::Equation;
use crate::model::{Guard, Jump, Relation, State};

/// A jump as the file says it.
pub(crate) struct ReadJump {
    name: String,
    /// When it happens.
    pub when: Option<Equation>,
    /// Each state it changes, with its new value.
    pub set: Vec<(usize, Equation)>,
}

const HELP: &str = "write bounce = { when = \"h <= 0 and v < 0\", set = { v = \"-e*v\" } }";

/// [jumps]
pub(crate) fn jumps(reader: &mut Reader, file: &Table, states: &[State]) -> Vec<ReadJump> {
    let Some(section) = file.find("jumps") else {
        return Vec::new();
    };
    let Some(table) = reader.table(section.value, section.place.clone(), HELP) else {
        return Vec::new();
    };
    let entries = table.entries.iter();
    entries
        .filter_map(|entry| jump(reader, entry, states))
        .collect()
}

fn jump(reader: &mut Reader, entry: &Entry, states: &[State]) -> Option<ReadJump> {
    let name = entry.key;
    let table = reader.table(entry.value, entry.place.clone(), HELP)?;
    reader.allow(&table, &["when", "set"], "a jump");
    let when = match table.value("when") {
        Some(value) => equation(reader, value, "write the condition as a string"),
        None => {
            reader.report(
                "E0232",
                format!("the jump `{name}` has no condition"),
                entry.place.clone(),
                "when does it happen?",
                "write when = \"h <= 0 and v < 0\"",
            );
            None
        }
    };
    let set = match table.find("set") {
        Some(set) => {
            let inner = reader.table(set.value, set.place.clone(), HELP)?;
            (!inner.entries.is_empty()).then(|| new_values(reader, &inner, states, name))
        }
        None => None,
    };
    if set.is_none() {
        reader.report(
            "E0232",
            format!("the jump `{name}` changes nothing"),
            entry.place.clone(),
            "no new value of a state",
            "write set = { v = \"-e*v\" }",
        );
    }
    let set = set.unwrap_or_default();
    Some(ReadJump {
        name: name.to_string(),
        when,
        set,
    })
}

fn new_values(
    reader: &mut Reader,
    table: &Table,
    states: &[State],
    jump: &str,
) -> Vec<(usize, Equation)> {
    let mut found = Vec::new();
    for entry in &table.entries {
        let Some(state) = states.iter().position(|state| state.name == entry.key) else {
            let near = nearest(entry.key, states.iter().map(|state| state.name.as_str()));
            reader.report(
                "E0233",
                format!("the jump `{jump}` sets `{}`, which is no state", entry.key),
                entry.place.clone(),
                "not in [states]",
                match near {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "only states jump; a memory is a state with derivative 0".to_string(),
                },
            );
            continue;
        };
        if let Some(equation) = equation(reader, entry.value, "write the new value as a string") {
            found.push((state, equation));
        }
    }
    found
}

/// Jumps in the graph, and where solutions may flow: where no jump's condition holds.
pub(crate) fn lower(
    reader: &mut Reader,
    lowering: &mut Lowering,
    jumps: Vec<ReadJump>,
) -> (Vec<Jump>, Guard) {
    let mut found = Vec::new();
    let mut flows = Guard::Always;
    for jump in jumps {
        let mut problems_of = |equation: &Equation, problems| {
            report_all(reader, equation, problems);
        };
        let guard = jump.when.as_ref().and_then(|when| {
            let guard = lowering.guard(when);
            guard.map_err(|problems| problems_of(when, problems)).ok()
        });
        let mut set = Vec::new();
        for (state, equation) in &jump.set {
            match lowering.plain(&equation.ast) {
                Ok(value) => set.push((*state, value)),
                Err(problems) => problems_of(equation, problems),
            }
        }
        let (Some(guard), Some(when)) = (guard, &jump.when) else {
            continue;
        };
        if let Some((message, label)) = never_forces(&guard) {
            let place = when.text.place(when.ast.range.clone());
            let message = format!("the jump `{}` {message}", jump.name);
            let help = "compare with < and >, as in \"h <= 0 and v < 0\"; a memory that is 0 or 1 \
                        is tested with m > 0.5";
            reader.report("E0234", message, place, label, help);
            continue;
        }
        flows = both(flows, negated(&guard));
        found.push(Jump {
            name: jump.name,
            guard,
            set,
        });
    }
    (found, flows)
}

/// Why a condition does not force a jump: a solution jumps because it cannot flow inside of the
/// condition's region, so that has to have an inside, and an outside.
fn never_forces(guard: &Guard) -> Option<(&'static str, &'static str)> {
    match guard {
        Guard::Always => Some(("happens always", "then no time can pass")),
        Guard::Atom {
            relation: Relation::Equal | Relation::NotEqual,
            ..
        } => Some((
            "is tied to an equality",
            "a solution can pass through `==` and `!=` without jumping",
        )),
        Guard::Atom { .. } => None,
        Guard::All(parts) | Guard::Any(parts) => parts.iter().find_map(never_forces),
    }
}
