//! Expressions as exact linear combinations of what is not linear in them.

use crate::graph::{Binary, ExprId, Graph, Node, Unary};
use num_rational::BigRational;
use num_traits::{One, Zero};
use std::collections::{BTreeMap, HashMap};

/// Longer expressions are not examined.
const MOST_NODES: usize = 600;

/// `constant + Σ coefficient · term`, all coefficients different from zero.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Affine {
    pub terms: BTreeMap<ExprId, BigRational>,
    pub constant: BigRational,
}

impl Affine {
    fn term(e: ExprId) -> Self {
        Affine {
            terms: BTreeMap::from([(e, BigRational::one())]),
            constant: BigRational::zero(),
        }
    }

    fn number(value: BigRational) -> Self {
        Affine {
            terms: BTreeMap::new(),
            constant: value,
        }
    }

    /// `e` as a linear combination; `None` when it is too long.
    pub fn of(graph: &Graph, e: ExprId) -> Option<Self> {
        let nodes = graph.reachable(&[e]);
        if nodes.len() > MOST_NODES {
            return None;
        }
        let mut done: HashMap<ExprId, Affine> = HashMap::new();
        for at in nodes {
            let form = match graph.node(at) {
                Node::Constant(value) => Affine::number(value.clone()),
                Node::Unary(Unary::Neg, a) => done.get(a)?.scaled(&-BigRational::one()),
                Node::Binary(Binary::Add, a, b) => done.get(a)?.plus(done.get(b)?),
                Node::Binary(Binary::Sub, a, b) => done
                    .get(a)?
                    .plus(&done.get(b)?.scaled(&-BigRational::one())),
                Node::Binary(Binary::Mul, a, b) => {
                    let (a, b) = (done.get(a)?, done.get(b)?);
                    if a.terms.is_empty() {
                        b.scaled(&a.constant)
                    } else if b.terms.is_empty() {
                        a.scaled(&b.constant)
                    } else {
                        Affine::term(at)
                    }
                }
                Node::Binary(Binary::Div, a, b) => {
                    let (a, b) = (done.get(a)?, done.get(b)?);
                    if b.terms.is_empty() && !b.constant.is_zero() {
                        a.scaled(&b.constant.recip())
                    } else {
                        Affine::term(at)
                    }
                }
                _ => Affine::term(at),
            };
            done.insert(at, form);
        }
        done.remove(&e)
    }

    pub fn scaled(&self, factor: &BigRational) -> Self {
        if factor.is_zero() {
            return Affine::number(BigRational::zero());
        }
        Affine {
            terms: self.terms.iter().map(|(e, c)| (*e, c * factor)).collect(),
            constant: &self.constant * factor,
        }
    }

    pub fn plus(&self, other: &Affine) -> Self {
        let mut terms = self.terms.clone();
        for (e, c) in &other.terms {
            let sum = terms.remove(e).unwrap_or_else(BigRational::zero) + c;
            if !sum.is_zero() {
                terms.insert(*e, sum);
            }
        }
        Affine {
            terms,
            constant: &self.constant + &other.constant,
        }
    }

    /// Without the term `e`, and the coefficient it had.
    pub fn split(&self, e: ExprId) -> Option<(Affine, BigRational)> {
        let mut rest = self.clone();
        let coefficient = rest.terms.remove(&e)?;
        Some((rest, coefficient))
    }

    /// The same as an expression.
    pub fn build(&self, graph: &mut Graph) -> ExprId {
        let mut sum = graph.integer(0);
        for (e, c) in &self.terms {
            let factor = graph.constant(c.clone());
            let term = graph.mul(factor, *e);
            sum = graph.add(sum, term);
        }
        let constant = graph.constant(self.constant.clone());
        graph.add(sum, constant)
    }
}
