//! What was proved about the right-hand sides and the guards.

use super::rows::section;
use crate::coverage::{Doubt, Overlap, Overlaps};
use crate::facts::ModeFacts;
use crate::graph::Names;
use crate::model::{Coverage, Guard, Model};
use std::fmt::Write;
use veribound_interval::{Interval, text};

/// Places of one overlap that are told.
const MOST_PLACES: usize = 3;
/// Modes that are named together.
const MOST_NAMES: usize = 9;
/// Overlaps that are told.
const MOST_OVERLAPS: usize = 10;

impl Model {
    /// What is proved about the right-hand sides; modes of which the same is known share a line.
    pub(super) fn describe_facts(&self, out: &mut String) {
        let facts = self.facts();
        let mut rows: Vec<(Vec<usize>, [String; 2])> = Vec::new();
        for (mode, facts) in facts.modes.iter().enumerate() {
            let told = [properties(facts, self.states.len()), self.slopes(facts)];
            match rows.iter_mut().find(|(_, known)| *known == told) {
                Some((modes, _)) => modes.push(mode),
                None => rows.push((vec![mode], told)),
            }
        }
        let rows = rows.into_iter().flat_map(|(modes, [properties, slopes])| {
            let slopes = vec![String::new(), slopes];
            [vec![self.listed(&modes), properties], slopes]
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

    /// Where guards overlap, and what that means there.
    pub(super) fn describe_overlaps(&self, overlaps: &Overlaps, names: &Names, out: &mut String) {
        if overlaps.found.is_empty() {
            return;
        }
        let told = overlaps.found.iter().take(MOST_OVERLAPS);
        let mut rows: Vec<Vec<String>> = told.flat_map(|one| self.overlap(one, names)).collect();
        let rest = overlaps.found.len().saturating_sub(MOST_OVERLAPS);
        if rest > 0 {
            rows.push(vec![format!("and {rest} more")]);
        }
        section(out, "overlaps (proved)", rows);
    }

    fn overlap(&self, overlap: &Overlap, names: &Names) -> Vec<Vec<String>> {
        let mut places = overlap.places.clone();
        let rest = places.len().saturating_sub(MOST_PLACES);
        places.truncate(MOST_PLACES);
        if rest > 0 {
            places.push(format!("in {rest} more places"));
        }
        let states = overlap
            .states
            .iter()
            .filter_map(|state| self.states.get(*state));
        let rates: Vec<String> = states.map(|state| format!("{}'", state.name)).collect();
        let hull = match rates.as_slice() {
            [] => "there their right-hand sides are the same".to_string(),
            [rate] => format!("there {rate} is anywhere between theirs"),
            rates => format!(
                "there ({}) is in the convex hull of theirs",
                rates.join(", ")
            ),
        };
        let mut lines = vec![format!("where {}", places.join(", or "))];
        let boxes = overlap.shown(names);
        if !boxes.is_empty() {
            lines.push(format!("for instance {}", boxes.join("; ")));
        }
        lines.push(hull);
        let names =
            std::iter::once(self.listed(&overlap.modes)).chain(std::iter::repeat(String::new()));
        names
            .zip(lines)
            .map(|(name, line)| vec![name, line])
            .collect()
    }

    /// Modes by name.
    fn listed(&self, modes: &[usize]) -> String {
        let known = modes.iter().filter_map(|mode| self.modes.get(*mode));
        let told = known.take(MOST_NAMES).map(|mode| mode.name.clone());
        let mut names: Vec<String> = told.collect();
        let rest = modes.len().saturating_sub(MOST_NAMES);
        if rest > 0 {
            names.push(format!("{rest} more"));
        }
        names.join(", ")
    }

    /// What came out about gaps and overlaps, line by line.
    pub(super) fn findings(&self, overlaps: &Overlaps) -> Vec<String> {
        let mut lines = vec![match &self.coverage {
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
        }];
        let choice = self.groups.iter().any(|group| group.modes.len() > 1);
        if choice && overlaps.found.is_empty() && overlaps.undecided.is_empty() {
            let place = if overlaps.only_in_domain {
                " in the domain"
            } else {
                ""
            };
            lines.push(format!(
                "ok    the guards only touch{place}: none overlap (proved)"
            ));
        }
        if !overlaps.found.is_empty() {
            let told = "the velocity is not unique where guards overlap; if that is not meant, let them \
                        exclude each other";
            lines.push(format!("note  {told}"));
        }
        let told = overlaps.undecided.iter().take(MOST_OVERLAPS);
        lines.extend(told.map(|doubt| {
            let modes = self.listed(doubt.modes());
            match doubt {
                Doubt::Place { place, .. } => format!(
                    "note  whether {modes} overlap where {place} is not decided within the budget"
                ),
                Doubt::Group { why, .. } => {
                    format!("note  whether {modes} overlap is not known: {why}")
                }
            }
        }));
        let rest = overlaps.undecided.len().saturating_sub(MOST_OVERLAPS);
        if rest > 0 {
            lines.push(format!(
                "note  and {rest} more places where overlaps are not decided"
            ));
        }
        lines
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
