//! Divisors, and what is divided by them alone, as parameters of another kind.
//!
//! `(F - d*v)/M` bends in `M` and `d`, and the more the less they are known; in `1/M` and `d/M` it is affine. So bounds
//! that rest on slopes hold for much wider sets of these than of `M` and `d`.

use crate::graph::{Binary, ExprId, Graph, Node, Unary, Var};
use crate::model::{Model, Param};
use crate::rewrite::Use;
use num_traits::Zero;
use std::collections::{BTreeMap, BTreeSet};
use veribound_interval::Interval;

/// Sums of more terms than this stay as they are written.
const MOST_TERMS: usize = 64;

/// What a parameter of a model is, in parameters of [`Model::with_ratios`]: `over / under`, or `1 / under`.
///
/// ```
/// use veribound_model::{Model, Ratio};
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 0\nparams = { m = [1, 4], k = [2, 8] }
///     der.x = \"1 - k*x/m\"\noutputs.y = \"x +- 0.01\"";
/// let (_, ratios) = Model::from_text("decay.toml", text)?.with_ratios();
/// // `k` is the new second parameter `k/m` over the new first one, `1/m`.
/// assert_eq!(ratios[1], Some(Ratio { over: Some(1), under: 0 }));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ratio {
    /// The parameter above, if there is one.
    pub over: Option<usize>,
    /// The parameter below. It is positive.
    pub under: usize,
}

/// What a factor may depend on parameters by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Symbol {
    Param(usize),
    /// The size of an expression that is a sum.
    Size(ExprId),
}

/// Integer powers, none of them zero.
type Powers = BTreeMap<Symbol, i32>;

/// A sum of products of powers, each with a factor that depends on no parameter but those that are kept.
type Sum = BTreeMap<Powers, ExprId>;

impl Model {
    /// The same equations in other parameters: the inverse of each that is positive and a divisor, and nothing else, and
    /// the ratio of both for what is always divided by it alone. Parameters that may be reset are left as they are.
    ///
    /// Guarantee: solutions with some values of the parameters are those of the new equations with the new values, which
    /// are in the new bounds. The list says of each parameter how it is found from new ones, where it is not the same.
    ///
    /// ```
    /// use veribound_interval::Interval;
    /// use veribound_model::{Model, Ratio};
    ///
    /// let text = "format = 1\nstates = [\"x\"]\ninit.x = [0, 1]\nparams = { m = [1, 4], k = [2, 8], g = [9, 10] }
    ///     der.x = \"g - k*x/m\"\noutputs.y = \"x +- 0.01\"";
    /// let model = Model::from_text("decay.toml", text)?;
    /// let (new, ratios) = model.with_ratios();
    /// let (m, k) = (0, 1);
    /// assert_eq!(ratios[m], Some(Ratio { over: None, under: m }));
    /// assert_eq!(ratios[k], Some(Ratio { over: Some(k), under: m }));
    /// assert_eq!(ratios[2], None);
    /// assert!(new.params[m].bounds.contains(0.25) && new.params[k].bounds.contains(8.0));
    /// let range = new.graph.eval_interval(new.modes[0].der[0], &|_| Interval::ONE);
    /// assert!(range.is_point());
    /// # Ok::<(), veribound_model::Diagnostics>(())
    /// ```
    pub fn with_ratios(&self) -> (Model, Vec<Option<Ratio>>) {
        let count = self.params.len();
        let mut graph = self.graph.clone();
        let mut model = self.clone();
        let mut uses: Vec<(ExprId, Use)> = Vec::new();
        model.each_expression(&mut |expr, what| uses.push((*expr, what)));
        uses.retain(|(_, what)| *what != Use::Message);
        let mut expansion = Expansion {
            kept: self
                .signals
                .iter()
                .flat_map(|signal| &signal.resets)
                .map(|reset| reset.param)
                .collect(),
            done: BTreeMap::new(),
        };
        for (expr, _) in &uses {
            expansion.expand(&mut graph, *expr);
        }
        let ratios = self.ratios(&expansion, &uses);
        if ratios.iter().all(Option::is_none) {
            return (model, ratios);
        }
        let new: Vec<ExprId> = (0..count).map(|p| graph.var(Var::Param(p))).collect();
        let old: Vec<ExprId> = ratios
            .iter()
            .enumerate()
            .map(|(param, ratio)| {
                let under = ratio.and_then(|ratio| new.get(ratio.under).copied());
                let over = ratio.is_none_or(|ratio| ratio.over.is_some());
                let over = new.get(param).copied().filter(|_| over);
                let over = over.unwrap_or_else(|| graph.integer(1));
                under.map_or(over, |under| graph.div(over, under))
            })
            .collect();
        let replacement = |var: Var| match var {
            Var::Param(param) => old.get(param).copied(),
            _ => None,
        };
        let done = &expansion.done;
        model.each_expression(&mut |expr, what| {
            *expr = match (done.get(expr), what) {
                (Some(sum), Use::Value) if depends(done, sum, &ratios) => {
                    let terms = rewritten(&mut graph, done, sum, &ratios);
                    total(&mut graph, terms, &new)
                }
                (Some(sum), Use::Sign) if depends(done, sum, &ratios) => {
                    let mut terms = rewritten(&mut graph, done, sum, &ratios);
                    common(&mut terms, &ratios);
                    total(&mut graph, terms, &new)
                }
                (Some(_), Use::Value | Use::Sign) => return,
                _ => graph.substitute(*expr, &replacement),
            };
        });
        for (param, ratio) in ratios.iter().enumerate() {
            let Some(Ratio { over, under }) = *ratio else {
                continue;
            };
            let (Some(own), Some(divisor)) = (self.params.get(param), self.params.get(under))
            else {
                continue;
            };
            let (name, above) = match over {
                Some(_) => (format!("{}/{}", own.name, divisor.name), own.bounds),
                None => (format!("1/{}", own.name), Interval::ONE),
            };
            if let Some(changed) = model.params.get_mut(param) {
                *changed = Param {
                    name,
                    unit: String::new(),
                    bounds: above / divisor.bounds,
                    nominal: None,
                };
            }
        }
        model.graph = graph;
        (model, ratios)
    }

    /// What each parameter should be.
    fn ratios(&self, expansion: &Expansion, uses: &[(ExprId, Use)]) -> Vec<Option<Ratio>> {
        let sums = uses
            .iter()
            .filter(|(_, what)| *what == Use::Value)
            .filter_map(|(expr, _)| expansion.done.get(expr));
        let products: BTreeSet<&Powers> = sums.flat_map(Sum::keys).collect();
        let power = |product: &Powers, param: usize| {
            let power = product.get(&Symbol::Param(param));
            power.copied().unwrap_or(0)
        };
        let is_free = |param: &usize| !expansion.kept.contains(param);
        let is_divisor = |param: &usize| {
            let bounds = self.params.get(*param).map(|param| param.bounds);
            let is_positive =
                bounds.is_some_and(|x| x.lo() > 0.0 && x.is_bounded() && !x.is_point());
            let powers = || products.iter().map(|product| power(product, *param));
            is_positive
                && powers().all(|power| power == 0 || power == -1)
                && powers().any(|power| power == -1)
        };
        let all = 0..self.params.len();
        let divisors: Vec<usize> = all.clone().filter(is_free).filter(is_divisor).collect();
        // The divisor that belongs to all of a parameter's terms, each of which has no other parameter.
        let below = |param: usize| {
            let mut own = products.iter().filter(|product| power(product, param) != 0);
            let first = own.clone().next()?;
            let under = divisors
                .iter()
                .find(|divisor| power(first, **divisor) == -1)?;
            let is_ratio = |product: &&&Powers| {
                let others = all.clone().filter(|other| power(product, *other) != 0);
                power(product, param) == 1 && power(product, *under) == -1 && others.count() == 2
            };
            own.all(|product| is_ratio(&product)).then_some(*under)
        };
        let is_wide = |param: usize| {
            self.params
                .get(param)
                .is_some_and(|own| own.bounds.is_bounded() && !own.bounds.is_point())
        };
        let ratio = |param: usize| {
            if divisors.contains(&param) {
                return Some(Ratio {
                    over: None,
                    under: param,
                });
            }
            let under = below(param).filter(|_| is_free(&param) && is_wide(param))?;
            Some(Ratio {
                over: Some(param),
                under,
            })
        };
        all.clone().map(ratio).collect()
    }
}

/// Expressions as sums.
struct Expansion {
    /// Parameters on which something else depends, too.
    kept: BTreeSet<usize>,
    done: BTreeMap<ExprId, Sum>,
}

impl Expansion {
    /// An expression as a sum, of which factors may still depend on parameters that are `kept`.
    fn expand(&mut self, graph: &mut Graph, expr: ExprId) -> Sum {
        for at in graph.reachable(&[expr]) {
            if self.done.contains_key(&at) {
                continue;
            }
            let sum = self
                .sum_of(graph, at)
                .unwrap_or_else(|| self.whole(graph, at));
            self.done.insert(at, sum);
        }
        self.done.get(&expr).cloned().unwrap_or_default()
    }

    /// A term that is left as it is.
    fn whole(&mut self, graph: &Graph, expr: ExprId) -> Sum {
        let variables = graph.variables(expr).into_iter();
        self.kept.extend(variables.filter_map(|var| match var {
            Var::Param(param) => Some(param),
            _ => None,
        }));
        Sum::from([(Powers::new(), expr)])
    }

    /// The sum of an operation, if its operands give one.
    fn sum_of(&self, graph: &mut Graph, at: ExprId) -> Option<Sum> {
        let of = |expr: ExprId| self.done.get(&expr);
        match *graph.node(at) {
            Node::Var(Var::Param(param)) => {
                let powers = Powers::from([(Symbol::Param(param), 1)]);
                Some(Sum::from([(powers, graph.integer(1))]))
            }
            Node::Constant(_) | Node::Pi | Node::Var(_) => Some(Sum::from([(Powers::new(), at)])),
            Node::Unary(Unary::Abs, a) if of(a)?.keys().any(|powers| !powers.is_empty()) => {
                let powers = Powers::from([(Symbol::Size(a), 1)]);
                Some(Sum::from([(powers, graph.integer(1))]))
            }
            Node::Unary(Unary::Neg, a) => {
                let terms = of(a)?.iter();
                Some(
                    terms
                        .map(|(powers, factor)| (powers.clone(), graph.neg(*factor)))
                        .collect(),
                )
            }
            Node::Binary(function @ (Binary::Add | Binary::Sub), a, b) => {
                let (left, right) = (of(a)?, of(b)?);
                let mut sum = left.clone();
                for (powers, factor) in right {
                    let zero = graph.integer(0);
                    let entry = sum.entry(powers.clone()).or_insert(zero);
                    *entry = graph.binary(function, *entry, *factor);
                }
                (sum.len() <= MOST_TERMS).then(|| without_zeros(graph, sum))
            }
            Node::Binary(Binary::Mul, a, b) => {
                let (left, right) = (of(a)?, of(b)?);
                if left.len() * right.len() > MOST_TERMS {
                    return None;
                }
                let mut sum = Sum::new();
                for (powers, factor) in left {
                    for (others, other) in right {
                        let product = graph.mul(*factor, *other);
                        let powers = together(powers, others, 1)?;
                        let zero = graph.integer(0);
                        let entry = sum.entry(powers).or_insert(zero);
                        *entry = graph.add(*entry, product);
                    }
                }
                Some(without_zeros(graph, sum))
            }
            Node::Binary(Binary::Div, a, b) => {
                let (powers, divisor) = of(b)?
                    .iter()
                    .next()
                    .filter(|_| of(b).is_some_and(|sum| sum.len() == 1))?;
                let terms = of(a)?.iter().map(|(own, factor)| {
                    Some((together(own, powers, -1)?, graph.div(*factor, *divisor)))
                });
                terms.collect()
            }
            Node::Power(a, n) => {
                let (powers, factor) = of(a)?
                    .iter()
                    .next()
                    .filter(|_| of(a).is_some_and(|sum| sum.len() == 1))?;
                let none = Powers::new();
                Some(Sum::from([(
                    together(&none, powers, n)?,
                    graph.powi(*factor, n),
                )]))
            }
            // What no parameter is in is a factor.
            _ => {
                let is_param = |var: &Var| matches!(var, Var::Param(_));
                let depends = graph.variables(at).iter().any(is_param);
                (!depends).then(|| Sum::from([(Powers::new(), at)]))
            }
        }
    }
}

fn without_zeros(graph: &Graph, mut sum: Sum) -> Sum {
    sum.retain(|_, factor| !graph.as_constant(*factor).is_some_and(Zero::is_zero));
    sum
}

/// `a + times b`
fn together(a: &Powers, b: &Powers, times: i32) -> Option<Powers> {
    let mut sum = a.clone();
    for (symbol, power) in b {
        let own = sum.entry(*symbol).or_insert(0);
        *own = own.checked_add(power.checked_mul(times)?)?;
    }
    sum.retain(|_, power| *power != 0);
    Some(sum)
}

/// Whether a sum depends on a parameter that is to be another one.
fn depends(done: &BTreeMap<ExprId, Sum>, sum: &Sum, ratios: &[Option<Ratio>]) -> bool {
    let mut symbols = sum.keys().flat_map(Powers::keys);
    symbols.any(|symbol| match symbol {
        Symbol::Param(param) => ratios.get(*param).is_some_and(Option::is_some),
        Symbol::Size(of) => done.get(of).is_some_and(|sum| depends(done, sum, ratios)),
    })
}

/// A term of a sum in new parameters: their powers, and a factor.
type NewTerm = (BTreeMap<usize, i32>, ExprId);

/// A sum in new parameters.
fn rewritten(
    graph: &mut Graph,
    done: &BTreeMap<ExprId, Sum>,
    sum: &Sum,
    ratios: &[Option<Ratio>],
) -> Vec<NewTerm> {
    let new: Vec<ExprId> = (0..ratios.len())
        .map(|p| graph.var(Var::Param(p)))
        .collect();
    let mut terms = Vec::with_capacity(sum.len());
    for (powers, factor) in sum {
        let mut own: BTreeMap<usize, i32> = BTreeMap::new();
        let mut factor = *factor;
        for (symbol, power) in powers {
            match symbol {
                Symbol::Param(param) => {
                    let ratio = ratios.get(*param).copied().flatten();
                    if ratio.is_none_or(|ratio| ratio.over.is_some()) {
                        *own.entry(*param).or_insert(0) += power;
                    }
                    if let Some(ratio) = ratio {
                        *own.entry(ratio.under).or_insert(0) -= power;
                    }
                }
                // What is positive and common to all terms is a factor of the size.
                Symbol::Size(of) => {
                    let mut inner = match done.get(of) {
                        Some(inner) => rewritten(graph, done, inner, ratios),
                        None => Vec::new(),
                    };
                    for (param, least) in common(&mut inner, ratios) {
                        *own.entry(param).or_insert(0) += least * power;
                    }
                    let inner = total(graph, inner, &new);
                    let size = graph.unary(Unary::Abs, inner);
                    let size = graph.powi(size, *power);
                    factor = graph.mul(factor, size);
                }
            }
        }
        terms.push((own, factor));
    }
    terms
}

/// Divides all terms by the powers of divisors, which are positive, that are common to them, and tells these.
fn common(terms: &mut [NewTerm], ratios: &[Option<Ratio>]) -> Vec<(usize, i32)> {
    let positive = ratios.iter().enumerate();
    let positive = positive.filter(|(_, ratio)| ratio.is_some_and(|ratio| ratio.over.is_none()));
    let mut taken = Vec::new();
    for (param, _) in positive {
        let power = |term: &NewTerm| term.0.get(&param).copied().unwrap_or(0);
        let least = terms.iter().map(power).min().unwrap_or(0);
        for (powers, _) in terms.iter_mut() {
            *powers.entry(param).or_insert(0) -= least;
        }
        taken.push((param, least));
    }
    taken
}

/// The sum of terms in parameters `new`.
fn total(graph: &mut Graph, terms: Vec<NewTerm>, new: &[ExprId]) -> ExprId {
    let mut total = graph.integer(0);
    for (powers, factor) in terms {
        let mut product = factor;
        for (param, power) in powers {
            let Some(param) = new.get(param).copied() else {
                continue;
            };
            if power < 0 {
                let divisor = graph.powi(param, power.saturating_neg());
                product = graph.div(product, divisor);
            } else {
                let times = graph.powi(param, power);
                product = graph.mul(product, times);
            }
        }
        total = graph.add(total, product);
    }
    total
}
