//! Where do guards of modes overlap?
//!
//! Guards count with their closure, so `<` is read as `<=` here, and `!=` as always true. Guards that touch
//! share a face at least; what is looked for is an overlap with an inside. The directions of the comparisons
//! (module `formula`) tell the two apart: where the points of a direction at a threshold are a face, a set
//! without inside, only its open pieces are looked at. A cell of open pieces in which several guards hold
//! overlaps on all of its points, and whether it has any in the domain is decided by set inversion (module
//! `search`): boxes that are proved to lie in it, a proof that there are none, or neither within the budget.

use crate::coverage::affine::Affine;
use crate::coverage::cells::{Cells, Piece};
use crate::coverage::search::{self, Domain, Settled};
use crate::coverage::{definedness, search::Example};
use crate::graph::{Binary, ExprId, Graph, Names, Node, Unary, Var};
use crate::model::{Guard, Model, Relation};
use veribound_interval::Interval;

/// Boxes that are told of one overlap.
const MOST_BOXES: usize = 3;

/// Guards of several modes hold at the same points, not only at common borders.
///
/// Example: [`Overlaps`].
#[derive(Debug, Clone, PartialEq)]
pub struct Overlap {
    /// The modes, by their positions in [`Model::modes`]; all of one group.
    pub modes: Vec<usize>,
    /// Where, in the user's names: the conditions of each place.
    pub places: Vec<String>,
    /// The largest boxes that were found there, by the quantities that matter. No quantity: everywhere.
    ///
    /// *Guarantee*: all points of a box are in the closed guards of all [`Overlap::modes`].
    pub boxes: Vec<Vec<(Var, Interval)>>,
    /// The states to which the modes give different right-hand sides: there the velocity is anywhere in their
    /// convex hull, with the same weights for all these states.
    pub states: Vec<usize>,
}

/// What is known about overlaps.
///
/// ```
/// use veribound_model::{Doubt, Model, Overlap, Overlaps};
///
/// let text = r#"
///     format = 1
///     states = ["x"]
///     init.x = [-1, 1]
///     modes.slow = { when = "x < 0.5", der.x = "1" }
///     modes.fast = { when = "x > 0", der.x = "2" }
///     outputs.y = "x +- 0.1"
/// "#;
/// let overlaps: Overlaps = Model::from_text("m.toml", text)?.overlaps();
/// let both: &Overlap = &overlaps.found[0];
/// assert_eq!((&both.modes[..], &both.states[..]), (&[0, 1][..], &[0][..]));
/// let doubts: Vec<Doubt> = overlaps.undecided;
/// assert!(doubts.is_empty());
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Overlaps {
    /// Those that are proved.
    pub found: Vec<Overlap>,
    /// Those that are neither proved nor refuted.
    pub undecided: Vec<Doubt>,
    /// Outside of what is found and undecided there are none: everywhere, or (true) only in the domain of
    /// [`crate::Coverage::InDomain`].
    pub only_in_domain: bool,
}

/// Modes of which it was not decided whether their guards overlap.
///
/// Example: [`Overlaps`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Doubt {
    /// At one place.
    Place {
        /// The modes.
        modes: Vec<usize>,
        /// The place, in the user's names.
        place: String,
    },
    /// Nothing is known about a whole group.
    Group {
        /// The modes.
        modes: Vec<usize>,
        /// Why.
        why: &'static str,
    },
}

impl Doubt {
    /// The modes, by their positions in [`Model::modes`].
    pub fn modes(&self) -> &[usize] {
        match self {
            Doubt::Place { modes, .. } | Doubt::Group { modes, .. } => modes,
        }
    }
}

impl Overlap {
    /// The boxes in the user's names, rounded inward.
    pub(crate) fn shown(&self, names: &Names) -> Vec<String> {
        let boxes = self.boxes.iter().cloned().map(Example);
        boxes.filter_map(|one| one.describe(names)).collect()
    }
}

impl Model {
    /// Where guards of modes overlap with an inside. Where they only touch, which is the normal case, none is
    /// found: the velocity there is in the convex hull of the touching modes, too.
    ///
    /// *Cost*: bounded by budgets; what is too hard for them is [`Overlaps::undecided`].
    pub fn overlaps(&self) -> Overlaps {
        let mut graph = self.graph.clone();
        let domain = Domain::of(self);
        let mut all = Overlaps::default();
        for group in self.groups.iter().filter(|group| group.modes.len() > 1) {
            let modes: Vec<usize> = group.modes.clone().collect();
            let of = modes.iter().filter_map(|mode| self.modes.get(*mode));
            let guards = of.map(|mode| Guard::All(vec![closed(&self.flows), closed(&mode.guard)]));
            let guards: Vec<Guard> = guards.collect();
            let mut group = Group {
                model: self,
                modes: &modes,
                domain: &domain,
                found: &mut all,
            };
            if let Err(why) = group.examine(&mut graph, &guards) {
                all.undecided.push(Doubt::Group { modes, why });
            }
        }
        all
    }

    /// The states to which `modes` give different right-hand sides.
    fn differing(&self, modes: &[usize]) -> Vec<usize> {
        let states = 0..self.states.len();
        let differs = |state: &usize| {
            let of = self
                .governing(*state)
                .filter(|(mode, _)| modes.contains(mode));
            let mut sides = of.map(|(_, rhs)| rhs);
            let first = sides.next();
            sides.any(|other| Some(other) != first)
        };
        states.filter(differs).collect()
    }
}

/// The modes of one group.
struct Group<'m> {
    model: &'m Model,
    modes: &'m [usize],
    domain: &'m Domain,
    found: &'m mut Overlaps,
}

impl Group<'_> {
    /// *Errors*: why nothing can be said.
    fn examine(&mut self, graph: &mut Graph, guards: &[Guard]) -> Result<(), &'static str> {
        let cells = Cells::of(graph, guards).ok_or("the guards are too long")?;
        let defined = definedness(graph, guards, self.domain);
        if !defined.in_domain {
            return Err("a guard divides or takes a root or logarithm that may be undefined");
        }
        let directions: Vec<Affine> = cells.directions().collect();
        let faces = directions
            .iter()
            .map(|direction| self.is_face(graph, direction));
        let faces: Vec<bool> = faces.collect();
        let shared = cells.shared(&faces);
        let shared = shared.ok_or("the guards hold too many comparisons")?;
        let names = self.model.names();
        let share = search::BUDGET / shared.len().max(1);
        for (cell, guards) in &shared {
            let pieces = cells.bounds(cell);
            // Closed guards that hold inside of a piece hold on its border too, where what is compared is
            // continuous.
            let filled = cell.iter().zip(&faces).filter(|(piece, _)| piece.is_some());
            let with_border = pieces
                .iter()
                .zip(filled)
                .map(|(piece, (_, is_face))| Piece {
                    is_closed: piece.is_closed || *is_face,
                    ..piece.clone()
                });
            let with_border: Vec<Piece> = with_border.collect();
            let modes = guards.iter().filter_map(|guard| self.modes.get(*guard));
            let modes: Vec<usize> = modes.copied().collect();
            let boxes = search::inside(graph, &with_border, self.domain, (share, MOST_BOXES));
            if !boxes.is_empty() {
                let place = cells.describe(cell, graph, &names);
                self.note(modes, place, boxes);
                continue;
            }
            match search::settle(graph, &pieces, self.domain, share) {
                Settled::Empty => self.found.only_in_domain = true,
                // Single points, perhaps.
                Settled::Contains(_) | Settled::Unknown => {
                    let place = cells.describe(cell, graph, &names);
                    self.found.undecided.push(Doubt::Place { modes, place });
                }
            }
        }
        self.found.only_in_domain |= !defined.everywhere || !faces.iter().all(|face| *face);
        Ok(())
    }

    /// Adds a place at which `modes` overlap.
    fn note(&mut self, modes: Vec<usize>, place: String, boxes: Vec<Example>) {
        let boxes = boxes.into_iter().map(|Example(one)| one);
        let known = self
            .found
            .found
            .iter_mut()
            .find(|known| known.modes == modes);
        match known {
            Some(known) => {
                known.places.push(place);
                let room = MOST_BOXES.saturating_sub(known.boxes.len());
                known.boxes.extend(boxes.take(room));
            }
            None => self.found.found.push(Overlap {
                states: self.model.differing(&modes),
                modes,
                places: vec![place],
                boxes: boxes.collect(),
            }),
        }
    }

    /// Whether the points of the domain at which `direction` has some value are a set without inside, for
    /// every value.
    ///
    /// A combination of quantities, of which one at least varies, has planes. An analytic function that is not
    /// the same everywhere has a set of measure zero; it is not the same everywhere if two of its values
    /// differ.
    fn is_face(&self, graph: &mut Graph, direction: &Affine) -> bool {
        let terms: Vec<ExprId> = direction.terms.keys().copied().collect();
        let vars = terms.iter().filter_map(|term| match graph.node(*term) {
            Node::Var(var) => Some(*var),
            _ => None,
        });
        let vars: Vec<Var> = vars.collect();
        if vars.len() == terms.len() {
            return vars
                .iter()
                .any(|var| !self.domain.interval(*var).is_point());
        }
        let parts = graph.reachable(&terms);
        if !parts.iter().all(|part| self.is_analytic(graph, *part)) {
            return false;
        }
        let whole = direction.build(graph);
        let values =
            SAMPLES.map(|start| graph.eval_interval(whole, &|var| self.sample(var, start)));
        let pairs = values
            .iter()
            .flat_map(|a| values.iter().map(move |b| (a, b)));
        pairs
            .into_iter()
            .any(|(a, b)| !a.is_empty() && !b.is_empty() && a.intersect(*b).is_empty())
    }

    /// A point of the domain, different for each quantity.
    fn sample(&self, var: Var, start: f64) -> Interval {
        let number = match var {
            Var::State(i) => 3 * i,
            Var::Input(i) => 3 * i + 1,
            Var::Param(i) => 3 * i + 2,
        };
        let range = self.domain.interval(var);
        let share = (start + 0.618 * number as f64).fract();
        let point = range.lo() + share * (range.hi() - range.lo());
        Interval::point(point.clamp(range.lo(), range.hi()))
    }

    /// Whether the operation is analytic inside the domain, where its arguments are and the guards are
    /// defined.
    fn is_analytic(&self, graph: &Graph, e: ExprId) -> bool {
        let values = |a: ExprId| graph.eval_interval(a, &|var| self.domain.interval(var));
        match *graph.node(e) {
            Node::Constant(_) | Node::Pi | Node::Var(_) | Node::Power(..) => true,
            Node::Unary(function, a) => match function {
                Unary::Neg
                | Unary::Exp
                | Unary::Ln
                | Unary::Sin
                | Unary::Cos
                | Unary::Tan
                | Unary::Atan
                | Unary::Tanh
                | Unary::Sinh
                | Unary::Cosh
                | Unary::Asinh => true,
                // Zero only on a face of the domain, or not at all.
                Unary::Sqrt => matches!(graph.node(a), Node::Var(_)) || values(a).lo() > 0.0,
                Unary::Cbrt => !values(a).contains(0.0),
                Unary::Asin | Unary::Acos | Unary::Atanh => values(a).mag() < 1.0,
                Unary::Acosh => values(a).lo() > 1.0,
                Unary::Abs | Unary::Sign | Unary::Impulse | Unary::Floor | Unary::FloorSlope => {
                    false
                }
            },
            Node::Choose(_) => false,
            Node::Binary(function, ..) => match function {
                Binary::Add | Binary::Sub | Binary::Mul | Binary::Div | Binary::Pow => true,
                Binary::Min | Binary::Max | Binary::Atan2 | Binary::Atan2Cut => false,
            },
        }
    }
}

/// Where the samples of the domain lie, as shares of its width.
const SAMPLES: [f64; 4] = [0.0, 0.29, 0.53, 0.81];

/// The guard with its border.
fn closed(guard: &Guard) -> Guard {
    let all = |list: &[Guard]| list.iter().map(closed).collect();
    match guard {
        Guard::Always => Guard::Always,
        Guard::All(list) => Guard::All(all(list)),
        Guard::Any(list) => Guard::Any(all(list)),
        Guard::Atom { expr, relation } => {
            let relation = match relation {
                Relation::Less | Relation::LessEqual => Relation::LessEqual,
                Relation::Greater | Relation::GreaterEqual => Relation::GreaterEqual,
                Relation::Equal => Relation::Equal,
                Relation::NotEqual => return Guard::Always,
            };
            Guard::Atom {
                expr: *expr,
                relation,
            }
        }
    }
}
