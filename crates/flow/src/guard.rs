//! Guards of modes on boxes.
//!
//! Two readings are needed. The *closed* one asks where the right-hand side of a mode belongs to
//! the Filippov hull: on the closure of the guard's region, because touching guards share their
//! boundary. The *strict* one asks, as the talk does, whether some point of the box satisfies the
//! guard as written; it labels boxes but no enclosure relies on it.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: indices were made by `Guards::compile` from the same model and layout"
)]

use veribound_interval::{Interval, Truth};
use veribound_model::{ExprId, Graph, Guard, Layout, Relation, Tape};

/// A guard compiled for boxes.
#[derive(Debug, Clone)]
pub(crate) enum Condition {
    Always,
    /// `state relation level`, the level being a constant.
    Level {
        state: usize,
        zone: usize,
        relation: Relation,
    },
    /// `tape relation 0`
    General {
        tape: usize,
        relation: Relation,
    },
    All(Vec<Condition>),
    Any(Vec<Condition>),
}

/// The levels of one state cut its axis into cells: cell `2k` lies below level `k`, cell `2k+1` is
/// the level itself (a zone, as wide as the rounding of its number).
#[derive(Debug, Clone, Default)]
pub(crate) struct Levels {
    pub(crate) zones: Vec<Interval>,
}

impl Levels {
    /// The points of `cell` as a closed interval.
    pub(crate) fn range(&self, cell: usize) -> Interval {
        if cell % 2 == 1 {
            return self.zones[cell / 2];
        }
        let k = cell / 2;
        let lo = if k == 0 {
            f64::NEG_INFINITY
        } else {
            self.zones[k - 1].hi()
        };
        let hi = self.zones.get(k).map_or(f64::INFINITY, |zone| zone.lo());
        Interval::new(lo, hi).unwrap_or(Interval::ENTIRE)
    }

    /// The cell that contains `x`; a zone wins over the regions it borders.
    pub(crate) fn cell(&self, x: f64) -> usize {
        for (k, zone) in self.zones.iter().enumerate() {
            if x < zone.lo() {
                return 2 * k;
            }
            if x <= zone.hi() {
                return 2 * k + 1;
            }
        }
        2 * self.zones.len()
    }
}

/// All guards of a model.
#[derive(Debug, Clone)]
pub(crate) struct Guards {
    pub(crate) conditions: Vec<Condition>,
    pub(crate) levels: Vec<Levels>,
    tapes: Vec<Tape>,
}

/// Scratch for [`Guards`].
#[derive(Debug, Clone)]
pub(crate) struct GuardRegisters {
    tapes: Vec<Vec<Interval>>,
    spare: Vec<Vec<Interval>>,
}

/// State `0` is known to lie in cell `1` of its axis.
pub(crate) type InCell = Option<(usize, usize)>;

struct Builder<'a> {
    graph: &'a mut Graph,
    layout: Layout,
    levels: Vec<Levels>,
    tapes: Vec<Tape>,
    known: Vec<ExprId>,
}

impl Builder<'_> {
    /// `expr relation 0` as a comparison of one state with a constant.
    fn level(&mut self, expr: ExprId, relation: Relation) -> Option<(usize, Interval, Relation)> {
        let level = self.graph.level(expr)?;
        let relation = if level.rising {
            relation
        } else {
            mirrored(relation)
        };
        Some((level.state, level.value, relation))
    }

    fn collect_levels(&mut self, guard: &Guard) {
        match guard {
            Guard::Always => {}
            Guard::All(parts) | Guard::Any(parts) => {
                for part in parts {
                    self.collect_levels(part);
                }
            }
            Guard::Atom { expr, relation } => {
                if let Some((state, level, _)) = self.level(*expr, *relation) {
                    insert_zone(&mut self.levels[state].zones, level);
                }
            }
        }
    }

    fn compile(&mut self, guard: &Guard) -> Condition {
        match guard {
            Guard::Always => Condition::Always,
            Guard::All(parts) => Condition::All(parts.iter().map(|p| self.compile(p)).collect()),
            Guard::Any(parts) => Condition::Any(parts.iter().map(|p| self.compile(p)).collect()),
            Guard::Atom { expr, relation } => {
                if let Some((state, level, relation)) = self.level(*expr, *relation) {
                    let zones = &self.levels[state].zones;
                    if let Some(zone) = zones.iter().position(|z| level.is_subset_of(*z)) {
                        return Condition::Level {
                            state,
                            zone,
                            relation,
                        };
                    }
                }
                let tape = match self.known.iter().position(|e| e == expr) {
                    Some(tape) => tape,
                    None => {
                        self.known.push(*expr);
                        self.tapes
                            .push(Tape::compile(self.graph, self.layout, &[*expr]));
                        self.tapes.len() - 1
                    }
                };
                Condition::General {
                    tape,
                    relation: *relation,
                }
            }
        }
    }
}

/// Adds a zone; zones that overlap become one, on which their guards are undecided.
fn insert_zone(zones: &mut Vec<Interval>, level: Interval) {
    let mut merged = level;
    zones.retain(|zone| {
        let apart = !zone.intersects(merged);
        if !apart {
            merged = merged.hull(*zone);
        }
        apart
    });
    zones.push(merged);
    zones.sort_by(|a, b| a.lo().total_cmp(&b.lo()));
}

fn mirrored(relation: Relation) -> Relation {
    match relation {
        Relation::Less => Relation::Greater,
        Relation::LessEqual => Relation::GreaterEqual,
        Relation::Greater => Relation::Less,
        Relation::GreaterEqual => Relation::LessEqual,
        same => same,
    }
}

/// Whether some value in `difference` compares to zero as `relation` says, boundaries included.
fn closed(difference: Interval, relation: Relation) -> bool {
    if difference.is_empty() {
        return true;
    }
    match relation {
        Relation::Less | Relation::LessEqual => difference.lo() <= 0.0,
        Relation::Greater | Relation::GreaterEqual => difference.hi() >= 0.0,
        Relation::Equal => difference.contains(0.0),
        Relation::NotEqual => true,
    }
}

/// Whether some value in `difference` compares to zero exactly as `relation` says.
fn strict(difference: Interval, relation: Relation) -> bool {
    if difference.is_empty() {
        return true;
    }
    match relation {
        Relation::Less => difference.lo() < 0.0,
        Relation::Greater => difference.hi() > 0.0,
        Relation::NotEqual => difference.lo() < 0.0 || difference.hi() > 0.0,
        inclusive => closed(difference, inclusive),
    }
}

/// The values that satisfy `relation` to zero, boundaries included.
fn closed_region(relation: Relation) -> Interval {
    let half = |lo, hi| Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
    match relation {
        Relation::Less | Relation::LessEqual => half(f64::NEG_INFINITY, 0.0),
        Relation::Greater | Relation::GreaterEqual => half(0.0, f64::INFINITY),
        Relation::Equal => Interval::ZERO,
        Relation::NotEqual => Interval::ENTIRE,
    }
}

impl Guards {
    pub(crate) fn compile(graph: &mut Graph, layout: Layout, guards: &[&Guard]) -> Guards {
        let mut builder = Builder {
            graph,
            layout,
            levels: vec![Levels::default(); layout.states],
            tapes: Vec::new(),
            known: Vec::new(),
        };
        for guard in guards {
            builder.collect_levels(guard);
        }
        let conditions = guards.iter().map(|guard| builder.compile(guard)).collect();
        Guards {
            conditions,
            levels: builder.levels,
            tapes: builder.tapes,
        }
    }

    pub(crate) fn registers(&self) -> GuardRegisters {
        GuardRegisters {
            tapes: self.tapes.iter().map(Tape::registers).collect(),
            spare: Vec::new(),
        }
    }

    /// Values of a comparison on `q`; everything where it is not defined on all of `q`, because the
    /// closure of its region may contain points at which it is not defined.
    fn difference(&self, tape: usize, q: &[Interval], registers: &mut GuardRegisters) -> Interval {
        let registers = &mut registers.tapes[tape];
        let regularity = self.tapes[tape].eval(q, registers);
        if regularity == veribound_model::Regularity::Undefined {
            return Interval::ENTIRE;
        }
        self.tapes[tape].output(0, registers)
    }

    /// Strict reading of the guard of `mode` on the box `q`.
    pub(crate) fn holds_somewhere(
        &self,
        mode: usize,
        q: &[Interval],
        registers: &mut GuardRegisters,
    ) -> bool {
        self.strict(&self.conditions[mode], q, registers)
    }

    fn strict(&self, condition: &Condition, q: &[Interval], r: &mut GuardRegisters) -> bool {
        match condition {
            Condition::Always => true,
            Condition::Level {
                state,
                zone,
                relation,
            } => strict(q[*state] - self.levels[*state].zones[*zone], *relation),
            Condition::General { tape, relation } => {
                strict(self.difference(*tape, q, r), *relation)
            }
            Condition::All(parts) => parts.iter().all(|part| self.strict(part, q, r)),
            Condition::Any(parts) => parts.iter().any(|part| self.strict(part, q, r)),
        }
    }

    /// Closed reading: cuts `q` down to a box that contains every point of it in the closure of
    /// the guard's region of `mode`; false when there is none (`q` is then meaningless).
    pub(crate) fn clip(
        &self,
        mode: usize,
        q: &mut [Interval],
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> bool {
        self.clip_condition(&self.conditions[mode], q, in_cell, registers)
    }

    fn clip_condition(
        &self,
        condition: &Condition,
        q: &mut [Interval],
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> bool {
        match condition {
            Condition::Always => true,
            Condition::Level {
                state,
                zone,
                relation,
            } => {
                if let Some((known, cell)) = in_cell
                    && known == *state
                {
                    return in_cell_relation(cell, 2 * zone + 1, *relation);
                }
                let allowed = allowed(self.levels[*state].zones[*zone], *relation);
                q[*state] = q[*state].intersect(allowed);
                !q[*state].is_empty()
            }
            Condition::General { tape, relation } => {
                let difference = self.difference(*tape, q, registers);
                if !closed(difference, *relation) {
                    return false;
                }
                let region = closed_region(*relation);
                if difference.is_subset_of(region) || difference == Interval::ENTIRE {
                    return true;
                }
                let tape_registers = &mut registers.tapes[*tape];
                match in_cell {
                    // A face keeps its own coordinate: only its mode question is asked.
                    Some((state, _)) => {
                        let own = q[state];
                        let possible = self.tapes[*tape].contract(q, region, tape_registers);
                        q[state] = own;
                        possible
                    }
                    None => self.tapes[*tape].contract(q, region, tape_registers),
                }
            }
            Condition::All(parts) => parts
                .iter()
                .all(|part| self.clip_condition(part, q, in_cell, registers)),
            Condition::Any(parts) => self.clip_any(parts, q, in_cell, registers),
        }
    }

    /// Hull of what each alternative leaves of `q`.
    fn clip_any(
        &self,
        parts: &[Condition],
        q: &mut [Interval],
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> bool {
        // One alternative that holds everywhere leaves all of it; one that is alone needs no copy.
        let mut open = None;
        let mut several = false;
        for part in parts {
            match self.decide(part, q, in_cell, registers) {
                Truth::True => return true,
                Truth::False => {}
                Truth::Unknown => {
                    several |= open.is_some();
                    open = Some(part);
                }
            }
        }
        match open {
            None => return false,
            Some(part) if !several => return self.clip_condition(part, q, in_cell, registers),
            Some(_) => {}
        }
        let mut whole = registers.spare.pop().unwrap_or_default();
        whole.clear();
        whole.extend_from_slice(q);
        let mut hull = registers.spare.pop().unwrap_or_default();
        hull.clear();
        for part in parts {
            q.copy_from_slice(&whole);
            if !self.clip_condition(part, q, in_cell, registers) {
                continue;
            }
            if hull.is_empty() {
                hull.extend_from_slice(q);
            } else {
                for (h, x) in hull.iter_mut().zip(q.iter()) {
                    *h = h.hull(*x);
                }
            }
        }
        let possible = !hull.is_empty();
        if possible {
            q.copy_from_slice(&hull);
        }
        registers.spare.push(whole);
        registers.spare.push(hull);
        possible
    }

    /// Closed reading: true on all of `q`, false on all of it, or not known.
    fn decide(
        &self,
        condition: &Condition,
        q: &[Interval],
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> Truth {
        let of = |possible: bool, certain: bool| match (possible, certain) {
            (false, _) => Truth::False,
            (true, true) => Truth::True,
            (true, false) => Truth::Unknown,
        };
        match condition {
            Condition::Always => Truth::True,
            Condition::Level {
                state,
                zone,
                relation,
            } => match in_cell {
                Some((known, cell)) if known == *state => of(
                    in_cell_relation(cell, 2 * zone + 1, *relation),
                    cell != 2 * zone + 1,
                ),
                _ => {
                    let allowed = allowed(self.levels[*state].zones[*zone], *relation);
                    of(
                        q[*state].intersects(allowed),
                        q[*state].is_subset_of(allowed),
                    )
                }
            },
            Condition::General { tape, relation } => {
                let difference = self.difference(*tape, q, registers);
                let region = closed_region(*relation);
                of(
                    closed(difference, *relation),
                    difference.is_subset_of(region),
                )
            }
            Condition::All(parts) => {
                let mut all = Truth::True;
                for part in parts {
                    match self.decide(part, q, in_cell, registers) {
                        Truth::False => return Truth::False,
                        part => all = all.and(part),
                    }
                }
                all
            }
            Condition::Any(parts) => {
                let mut any = Truth::False;
                for part in parts {
                    match self.decide(part, q, in_cell, registers) {
                        Truth::True => return Truth::True,
                        part => any = any.or(part),
                    }
                }
                any
            }
        }
    }
}

/// The values of a state that compare with a level as `relation` says, boundaries included.
fn allowed(level: Interval, relation: Relation) -> Interval {
    let half = |lo, hi| Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
    match relation {
        Relation::Less | Relation::LessEqual => half(f64::NEG_INFINITY, level.hi()),
        Relation::Greater | Relation::GreaterEqual => half(level.lo(), f64::INFINITY),
        Relation::Equal => level,
        Relation::NotEqual => Interval::ENTIRE,
    }
}

/// The relation of every point of `cell` to the level whose zone is `level_cell`.
fn in_cell_relation(cell: usize, level_cell: usize, relation: Relation) -> bool {
    match relation {
        _ if cell == level_cell => true,
        Relation::Less | Relation::LessEqual => cell < level_cell,
        Relation::Greater | Relation::GreaterEqual => cell > level_cell,
        Relation::Equal => false,
        Relation::NotEqual => true,
    }
}
