//! Guards as formulas over exact comparisons.

use crate::coverage::affine::Affine;
use crate::graph::{Binary, ExprId, Graph, Node, Unary};
use crate::model::{Guard, Relation};
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap};
use veribound_interval::Truth;

/// Different comparisons after `abs`, `min` and `max` are resolved.
const MOST_COMPARISONS: usize = 400;

/// A linear combination without constant, its first coefficient `1`.
pub(super) type Direction = BTreeMap<ExprId, BigRational>;

#[derive(Clone)]
pub(super) enum Formula {
    Constant(bool),
    /// `direction relation threshold`
    Comparison {
        direction: usize,
        threshold: BigRational,
        relation: Relation,
    },
    All(Vec<Formula>),
    Any(Vec<Formula>),
}

impl Formula {
    /// What is known where only some comparisons are decided: `order` says how a direction compares to a
    /// threshold.
    pub fn truth(&self, order: &impl Fn(usize, &BigRational) -> Option<Ordering>) -> Truth {
        match self {
            Formula::Constant(true) => Truth::True,
            Formula::Constant(false) => Truth::False,
            Formula::All(list) => {
                let parts = list.iter().map(|part| part.truth(order));
                parts.fold(Truth::True, Truth::and)
            }
            Formula::Any(list) => {
                let parts = list.iter().map(|part| part.truth(order));
                parts.fold(Truth::False, Truth::or)
            }
            Formula::Comparison {
                direction,
                threshold,
                relation,
            } => match order(*direction, threshold) {
                None => Truth::Unknown,
                Some(order) if relation.admits(order) => Truth::True,
                Some(_) => Truth::False,
            },
        }
    }

    /// The direction of a comparison that has to be decided before the formula is.
    pub fn open_direction(
        &self,
        order: &impl Fn(usize, &BigRational) -> Option<Ordering>,
    ) -> Option<usize> {
        match self {
            Formula::Constant(_) => None,
            Formula::Comparison {
                direction,
                threshold,
                ..
            } => order(*direction, threshold).is_none().then_some(*direction),
            Formula::All(list) | Formula::Any(list) => {
                let open = list
                    .iter()
                    .filter(|part| part.truth(order) == Truth::Unknown);
                open.filter_map(|part| part.open_direction(order)).next()
            }
        }
    }

    /// Adds every threshold to the list of its direction.
    pub fn collect(&self, thresholds: &mut [Vec<BigRational>]) {
        match self {
            Formula::Constant(_) => {}
            Formula::Comparison {
                direction,
                threshold,
                ..
            } => {
                if let Some(list) = thresholds.get_mut(*direction) {
                    list.push(threshold.clone());
                }
            }
            Formula::All(list) | Formula::Any(list) => {
                list.iter().for_each(|part| part.collect(thresholds));
            }
        }
    }
}

impl Relation {
    /// Whether a quantity that compares to the threshold like `order` fulfils the relation.
    fn admits(self, order: Ordering) -> bool {
        match self {
            Relation::Less => order.is_lt(),
            Relation::LessEqual => order.is_le(),
            Relation::Greater => order.is_gt(),
            Relation::GreaterEqual => order.is_ge(),
            Relation::Equal => order.is_eq(),
            Relation::NotEqual => order.is_ne(),
        }
    }

    /// The relation of the two sides exchanged.
    fn mirrored(self) -> Relation {
        match self {
            Relation::Less => Relation::Greater,
            Relation::LessEqual => Relation::GreaterEqual,
            Relation::Greater => Relation::Less,
            Relation::GreaterEqual => Relation::LessEqual,
            Relation::Equal | Relation::NotEqual => self,
        }
    }
}

/// Turns guards into formulas over directions that all of them share.
pub(super) struct Builder<'g> {
    graph: &'g Graph,
    pub directions: Vec<Direction>,
    /// Comparisons that stand in several guards are examined once.
    known: HashMap<(ExprId, Relation), Formula>,
    comparisons: usize,
}

impl<'g> Builder<'g> {
    pub fn new(graph: &'g Graph) -> Self {
        Builder {
            graph,
            directions: Vec::new(),
            known: HashMap::new(),
            comparisons: 0,
        }
    }

    /// `None` when the guard is too long to be examined.
    pub fn guard(&mut self, guard: &Guard) -> Option<Formula> {
        let list = |builder: &mut Self, list: &[Guard]| -> Option<Vec<Formula>> {
            list.iter().map(|part| builder.guard(part)).collect()
        };
        Some(match guard {
            Guard::Always => Formula::Constant(true),
            Guard::All(parts) => Formula::All(list(self, parts)?),
            Guard::Any(parts) => Formula::Any(list(self, parts)?),
            Guard::Atom { expr, relation } => {
                let key = (*expr, *relation);
                if let Some(known) = self.known.get(&key) {
                    return Some(known.clone());
                }
                let form = Affine::of(self.graph, *expr)?;
                let formula = self.comparison(form, *relation)?;
                self.known.insert(key, formula.clone());
                formula
            }
        })
    }

    /// `form relation 0`
    fn comparison(&mut self, form: Affine, relation: Relation) -> Option<Formula> {
        self.comparisons += 1;
        if self.comparisons > MOST_COMPARISONS {
            return None;
        }
        if form.terms.is_empty() {
            return Some(Formula::Constant(
                relation.admits(form.constant.cmp(&BigRational::zero())),
            ));
        }
        if let Some((is_larger, a, b)) = self.resolved(&form)? {
            return self.one_of_two(is_larger, a, b, relation);
        }
        let Some(first) = form.terms.values().next().cloned() else {
            return Some(Formula::Constant(false));
        };
        let relation = if first.is_negative() {
            relation.mirrored()
        } else {
            relation
        };
        let unit = form.scaled(&first.recip());
        let known = self
            .directions
            .iter()
            .position(|direction| *direction == unit.terms);
        let direction = known.unwrap_or(self.directions.len());
        if known.is_none() {
            self.directions.push(unit.terms);
        }
        Some(Formula::Comparison {
            direction,
            threshold: -unit.constant,
            relation,
        })
    }

    /// The first term that is an `abs`, `min` or `max`: the form is then the larger (or smaller) of
    /// two forms without it.
    fn resolved(&self, form: &Affine) -> Option<Option<(bool, Affine, Affine)>> {
        for &term in form.terms.keys() {
            let (is_larger, a, b) = match *self.graph.node(term) {
                Node::Unary(Unary::Abs, a) => {
                    let a = Affine::of(self.graph, a)?;
                    let negative = a.scaled(&BigRational::from_integer((-1).into()));
                    (true, a, negative)
                }
                Node::Binary(which @ (Binary::Min | Binary::Max), a, b) => (
                    which == Binary::Max,
                    Affine::of(self.graph, a)?,
                    Affine::of(self.graph, b)?,
                ),
                _ => continue,
            };
            let (rest, factor) = form.split(term)?;
            let (a, b) = (rest.plus(&a.scaled(&factor)), rest.plus(&b.scaled(&factor)));
            return Some(Some((is_larger == factor.is_positive(), a, b)));
        }
        Some(None)
    }

    /// `max(a, b) relation 0`, or with `min`.
    fn one_of_two(
        &mut self,
        is_larger: bool,
        a: Affine,
        b: Affine,
        relation: Relation,
    ) -> Option<Formula> {
        let is_below = match relation {
            Relation::Less | Relation::LessEqual => true,
            Relation::Greater | Relation::GreaterEqual => false,
            Relation::Equal | Relation::NotEqual => {
                let (below, above) = if relation == Relation::Equal {
                    (Relation::LessEqual, Relation::GreaterEqual)
                } else {
                    (Relation::Less, Relation::Greater)
                };
                let parts = vec![
                    self.one_of_two(is_larger, a.clone(), b.clone(), below)?,
                    self.one_of_two(is_larger, a, b, above)?,
                ];
                let both = relation == Relation::Equal;
                return Some(if both {
                    Formula::All(parts)
                } else {
                    Formula::Any(parts)
                });
            }
        };
        let parts = vec![self.comparison(a, relation)?, self.comparison(b, relation)?];
        Some(if is_below == is_larger {
            Formula::All(parts)
        } else {
            Formula::Any(parts)
        })
    }
}
