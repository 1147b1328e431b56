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

use crate::levels::{Levels, allowed, in_cell_relation};
use veribound_interval::Interval;
use veribound_interval::lanes::{Floats, Interval8, LANES, Lanewise, Mask};
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

/// All guards of a model: those of its modes, then those of its jumps.
#[derive(Debug, Clone)]
pub(crate) struct Guards {
    pub(crate) conditions: Vec<Condition>,
    /// Where solutions flow.
    flows: Condition,
    pub(crate) levels: Vec<Levels>,
    tapes: Vec<Tape>,
}

/// Scratch for [`Guards`].
#[derive(Debug, Clone)]
pub(crate) struct GuardRegisters {
    tapes: Vec<Vec<Interval8>>,
    spare: Vec<Vec<Interval8>>,
}

/// Where a condition holds on the whole box, and where nowhere on it.
#[derive(Debug, Clone, Copy)]
struct Decision {
    certain: Mask,
    impossible: Mask,
}

/// State `0` of every box is known to lie in cell `1` of its axis.
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

    fn collect_levels(&mut self, guard: &Guard, wanted: &dyn Fn(usize) -> bool) {
        match guard {
            Guard::Always => {}
            Guard::All(parts) | Guard::Any(parts) => {
                for part in parts {
                    self.collect_levels(part, wanted);
                }
            }
            Guard::Atom { expr, relation } => {
                if let Some((state, level, _)) = self.level(*expr, *relation)
                    && wanted(state)
                {
                    self.levels[state].insert(level);
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

fn mirrored(relation: Relation) -> Relation {
    match relation {
        Relation::Less => Relation::Greater,
        Relation::LessEqual => Relation::GreaterEqual,
        Relation::Greater => Relation::Less,
        Relation::GreaterEqual => Relation::LessEqual,
        same => same,
    }
}

const ZERO: Floats = [0.0; LANES];

/// Where some value in `difference` compares to zero as `relation` says, boundaries included.
fn closed(difference: &Interval8, relation: Relation) -> Mask {
    let possible = match relation {
        Relation::Less | Relation::LessEqual => Mask::at_most(&difference.lo(), &ZERO),
        Relation::Greater | Relation::GreaterEqual => Mask::at_most(&ZERO, &difference.hi()),
        Relation::Equal => difference.contains_zero(),
        Relation::NotEqual => Mask::ALL,
    };
    possible | difference.is_empty()
}

/// Where some value in `difference` compares to zero exactly as `relation` says.
fn strict(difference: &Interval8, relation: Relation) -> Mask {
    let below = Mask::below(&difference.lo(), &ZERO);
    let above = Mask::below(&ZERO, &difference.hi());
    let possible = match relation {
        Relation::Less => below,
        Relation::Greater => above,
        Relation::NotEqual => below | above,
        inclusive => return closed(difference, inclusive),
    };
    possible | difference.is_empty()
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
    pub(crate) fn compile(
        graph: &mut Graph,
        layout: Layout,
        (modes, jumps, flows): (&[&Guard], &[&Guard], &Guard),
        jumping: &[bool],
    ) -> Guards {
        let mut builder = Builder {
            graph,
            layout,
            levels: vec![Levels::default(); layout.states],
            tapes: Vec::new(),
            known: Vec::new(),
        };
        for guard in modes {
            builder.collect_levels(guard, &|_| true);
        }
        // A wall stops a state that flows against it; a state that jumps passes its levels smoothly.
        builder.collect_levels(flows, &|state| !jumping[state]);
        let guards = modes.iter().chain(jumps);
        let conditions = guards.map(|guard| builder.compile(guard)).collect();
        Guards {
            conditions,
            flows: builder.compile(flows),
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
    fn difference(
        &self,
        tape: usize,
        q: &[Interval8],
        registers: &mut GuardRegisters,
    ) -> Interval8 {
        let registers = &mut registers.tapes[tape];
        let regular = self.tapes[tape].eval(q, registers);
        let value = self.tapes[tape].output(0, registers);
        value.or_else(regular.is_defined(), &Interval8::ENTIRE)
    }

    /// Strict reading of the guard of `mode`: the boxes on which it holds somewhere.
    pub(crate) fn holds_somewhere(
        &self,
        mode: usize,
        q: &[Interval8],
        registers: &mut GuardRegisters,
    ) -> Mask {
        self.strict(&self.conditions[mode], q, registers)
    }

    fn strict(&self, condition: &Condition, q: &[Interval8], r: &mut GuardRegisters) -> Mask {
        match condition {
            Condition::Always => Mask::ALL,
            Condition::Level {
                state,
                zone,
                relation,
            } => {
                let zone = Interval8::splat(self.levels[*state].zones[*zone]);
                strict(&(q[*state] - zone), *relation)
            }
            Condition::General { tape, relation } => {
                strict(&self.difference(*tape, q, r), *relation)
            }
            Condition::All(parts) => {
                let mut all = Mask::ALL;
                for part in parts {
                    if all.none() {
                        break;
                    }
                    all &= self.strict(part, q, r);
                }
                all
            }
            Condition::Any(parts) => {
                let mut any = Mask::NONE;
                for part in parts {
                    if any.all() {
                        break;
                    }
                    any |= self.strict(part, q, r);
                }
                any
            }
        }
    }

    /// As [`Guards::clip`], for the region in which solutions flow.
    pub(crate) fn clip_to_flow(
        &self,
        q: &mut [Interval8],
        lanes: Mask,
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> Mask {
        self.clip_condition(&self.flows, q, lanes, in_cell, registers)
    }

    /// Closed reading: cuts the boxes in `lanes` down to ones that contain every point in the
    /// closure of the guard's region of `mode`. Returns those that have such a point; the others
    /// are then meaningless.
    pub(crate) fn clip(
        &self,
        mode: usize,
        q: &mut [Interval8],
        lanes: Mask,
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> Mask {
        self.clip_condition(&self.conditions[mode], q, lanes, in_cell, registers)
    }

    fn clip_condition(
        &self,
        condition: &Condition,
        q: &mut [Interval8],
        lanes: Mask,
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> Mask {
        match condition {
            Condition::Always => lanes,
            Condition::Level {
                state,
                zone,
                relation,
            } => {
                if let Some((known, cell)) = in_cell
                    && known == *state
                {
                    return lanes & Mask::splat(in_cell_relation(cell, 2 * zone + 1, *relation));
                }
                let allowed = allowed(self.levels[*state].zones[*zone], *relation);
                q[*state] = q[*state].intersect(&Interval8::splat(allowed));
                lanes.without(q[*state].is_empty())
            }
            Condition::General { tape, relation } => {
                self.clip_general(*tape, *relation, q, lanes, in_cell, registers)
            }
            Condition::All(parts) => parts.iter().fold(lanes, |left, part| {
                if left.none() {
                    left
                } else {
                    self.clip_condition(part, q, left, in_cell, registers)
                }
            }),
            Condition::Any(parts) => self.clip_any(parts, q, lanes, in_cell, registers),
        }
    }

    fn clip_general(
        &self,
        tape: usize,
        relation: Relation,
        q: &mut [Interval8],
        lanes: Mask,
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> Mask {
        let difference = self.difference(tape, q, registers);
        let possible = lanes & closed(&difference, relation);
        let region = closed_region(relation);
        let entire = Interval8::ENTIRE.is_subset_of(&difference);
        let whole = difference.is_subset_of(&Interval8::splat(region)) | entire;
        let cut = possible.without(whole);
        if cut.none() {
            return possible;
        }
        let mut before = registers.spare.pop().unwrap_or_default();
        before.clear();
        before.extend_from_slice(q);
        let left = self.tapes[tape].contract(q, region, &mut registers.tapes[tape]);
        for (q, before) in q.iter_mut().zip(&before) {
            q.assign(!cut, before);
        }
        // A face keeps its own coordinate: only its mode question is asked.
        if let Some((state, _)) = in_cell {
            q[state] = before[state];
        }
        registers.spare.push(before);
        possible & (left | !cut)
    }

    /// Hull of what each alternative leaves of the boxes.
    fn clip_any(
        &self,
        parts: &[Condition],
        q: &mut [Interval8],
        lanes: Mask,
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> Mask {
        // One alternative that holds everywhere leaves all of a box; one that is alone needs no copy.
        let mut certain = Mask::NONE;
        let (mut open, mut only, mut several) = (Mask::NONE, None, false);
        for part in parts {
            let decision = self.decide(part, q, in_cell, registers);
            certain |= decision.certain;
            if lanes.without(certain).none() {
                return lanes;
            }
            let undecided = lanes.without(decision.certain | decision.impossible);
            if !undecided.none() {
                open |= undecided;
                several |= only.is_some();
                only = Some(part);
            }
        }
        certain &= lanes;
        open = open.without(certain);
        match only {
            Some(part) if !several && certain.none() => {
                return self.clip_condition(part, q, open, in_cell, registers);
            }
            _ if open.none() => return certain,
            _ => {}
        }
        let mut whole = registers.spare.pop().unwrap_or_default();
        whole.clear();
        whole.extend_from_slice(q);
        let mut hull = registers.spare.pop().unwrap_or_default();
        hull.clear();
        hull.resize(q.len(), Interval8::EMPTY);
        let mut possible = certain;
        for part in parts {
            q.copy_from_slice(&whole);
            let left = self.clip_condition(part, q, open, in_cell, registers);
            if left.none() {
                continue;
            }
            for (h, x) in hull.iter_mut().zip(q.iter()) {
                let joined = h.hull(x);
                h.assign(left, &joined);
            }
            possible |= left;
        }
        for ((q, hull), whole) in q.iter_mut().zip(&hull).zip(&whole) {
            *q = hull.or_else(open, whole);
        }
        registers.spare.push(whole);
        registers.spare.push(hull);
        possible
    }

    /// Closed reading: true on all of a box, false on all of it, or not known.
    fn decide(
        &self,
        condition: &Condition,
        q: &[Interval8],
        in_cell: InCell,
        registers: &mut GuardRegisters,
    ) -> Decision {
        match condition {
            Condition::Always => Decision {
                certain: Mask::ALL,
                impossible: Mask::NONE,
            },
            Condition::Level {
                state,
                zone,
                relation,
            } => match in_cell {
                Some((known, cell)) if known == *state => {
                    let possible = in_cell_relation(cell, 2 * zone + 1, *relation);
                    Decision {
                        certain: Mask::splat(possible && cell != 2 * zone + 1),
                        impossible: Mask::splat(!possible),
                    }
                }
                _ => {
                    let allowed = allowed(self.levels[*state].zones[*zone], *relation);
                    let allowed = Interval8::splat(allowed);
                    let impossible = !q[*state].intersects(&allowed);
                    Decision {
                        certain: q[*state].is_subset_of(&allowed).without(impossible),
                        impossible,
                    }
                }
            },
            Condition::General { tape, relation } => {
                let difference = self.difference(*tape, q, registers);
                let region = Interval8::splat(closed_region(*relation));
                let impossible = !closed(&difference, *relation);
                Decision {
                    certain: difference.is_subset_of(&region).without(impossible),
                    impossible,
                }
            }
            Condition::All(parts) => {
                let mut all = Decision {
                    certain: Mask::ALL,
                    impossible: Mask::NONE,
                };
                for part in parts {
                    if all.impossible.all() {
                        break;
                    }
                    let part = self.decide(part, q, in_cell, registers);
                    all.certain &= part.certain;
                    all.impossible |= part.impossible;
                }
                all
            }
            Condition::Any(parts) => {
                let mut any = Decision {
                    certain: Mask::NONE,
                    impossible: Mask::ALL,
                };
                for part in parts {
                    if any.certain.all() {
                        break;
                    }
                    let part = self.decide(part, q, in_cell, registers);
                    any.certain |= part.certain;
                    any.impossible &= part.impossible;
                }
                any
            }
        }
    }
}
