//! The set that is moved: what every solution depends on is kept as polynomials.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one polynomial per state, one coefficient per monomial"
)]

use std::sync::Arc;

use super::ahead::around;
use super::frame::Frame;
use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use super::range::range;
use super::step::Obstacle;
use super::surfaces::Signs;
use veribound_interval::Interval;

/// Settings of forms.
///
/// Example: [`Engines`](crate::engine::Engines).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FormOptions {
    /// Order of the Taylor series in time, 4 to 31; `None` chooses by what a step may neglect.
    pub order: Option<usize>,
    /// Degree of the polynomials in the unknowns; `None` chooses by their number.
    pub degree: Option<usize>,
    /// How many degrees a fresh unknown counts: half the degree unless said otherwise.
    pub fresh: Option<usize>,
    /// What one step may neglect in time, relative to the size of a state.
    pub tolerance: f64,
    /// What one step may neglect in time, relative to the width of the set.
    pub share: f64,
    /// What dependence could not keep becomes fresh unknowns when it is this share of those before.
    pub absorb: f64,
    /// Longest step, times the norm of `∂f/∂x`.
    pub steepest: f64,
    /// Right-hand sides that are affine in the states move forms by their closed form.
    pub closed: bool,
}

impl Default for FormOptions {
    fn default() -> Self {
        FormOptions {
            order: None,
            degree: None,
            fresh: None,
            absorb: 2.0,
            tolerance: 1e-17,
            share: 1e-7,
            steepest: 0.7,
            closed: false,
        }
    }
}

/// An uncertain quantity that dependence is kept on.
///
/// Example: [`Form`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// The start value of this state.
    Start(usize),
    /// This parameter.
    Param(usize),
    /// This axis of a [`Parallelotope`].
    Axis(usize),
}

/// Start values and parameters as affine functions of some axes.
///
/// All `z` with `|z_i - centre_i - Σ_a axes[i][a] δ_a| <= rest_i` for some `δ` in the unit box: states first,
/// then parameters.
///
/// Example: [`Form`].
#[derive(Debug, Clone, PartialEq)]
pub struct Parallelotope {
    /// Values for all `δ` zero.
    pub centre: Vec<f64>,
    /// For every quantity one slope per axis.
    pub axes: Vec<Vec<f64>>,
    /// How far values can be from the affine functions.
    pub rest: Vec<f64>,
}

/// Where an unknown lies: at `middle + radius δ` with some numbers of these intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) unknown: Unknown,
    pub(super) middle: Interval,
    pub(super) radius: Interval,
}

impl Range {
    fn bounds(self) -> Interval {
        self.middle + self.radius * Interval::symmetric(1.0)
    }
}

/// A parameter as polynomial in the unknowns, and how far it can be from that.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ParamForm {
    pub(super) polynomial: Vec<f64>,
    pub(super) radius: f64,
}

/// A quantity as an affine function of the unknowns.
///
/// Guarantee: for every `δ` in the unit box the quantity of the solution that belongs to `δ` lies in
/// `centre + Σ slopes[i] δ_i + remainder`. `δ_i = (value - middle) / radius` of the unknown `i`
/// ([`Form::unknowns`]).
///
/// Example: [`Meeting`](crate::form::Meeting).
#[derive(Debug, Clone, PartialEq)]
pub struct OutputForm {
    /// Value for all unknowns in their middles.
    pub centre: f64,
    /// One for every unknown.
    pub slopes: Vec<f64>,
    /// What is not affine, and what is not known.
    pub remainder: Interval,
    /// Encloses all values; not wider than the affine function says, mostly narrower.
    pub hull: Interval,
}

/// The states of all solutions at one time, as functions of unknowns that stay the same: start values and
/// parameters.
///
/// Guarantee: for every `δ` in the unit box, the solution that starts at the start values and has the
/// parameters of `δ` lies in `P(δ) + Q r` for some `r` in a box, where the unknowns are
/// `middle + radius δ`.
///
/// ```
/// use veribound_flow::form::{Flow, Form, FormOptions, Parallelotope, Unknown};
/// use veribound_interval::Interval;
///
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1.1]\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let flow = Flow::new(&model);
/// let form: Form = flow.start(&[model.states[0].init], &[model.params[0].bounds], FormOptions::default());
/// let kept: Vec<Unknown> = form.unknowns().into_iter().map(|(unknown, _)| unknown).collect();
/// assert_eq!(kept, [Unknown::Start(0), Unknown::Param(0)]);
/// // Starts that grow with k: one unknown for both.
/// let needle = Parallelotope { centre: vec![1.0, 0.75], axes: vec![vec![0.1], vec![0.25]], rest: vec![0.0, 0.0] };
/// let form = flow.start_in(&needle, FormOptions::default());
/// assert_eq!(form.unknowns()[0].0, Unknown::Axis(0));
/// assert!(Interval::new(0.9, 1.1).unwrap().intersects(form.hull()[0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Form {
    pub(super) monomials: Arc<Monomials>,
    /// Order in time.
    pub(super) order: usize,
    pub(super) options: FormOptions,
    pub(super) unknowns: Vec<Range>,
    /// One polynomial per state.
    pub(super) states: Vec<Vec<f64>>,
    pub(super) params: Vec<ParamForm>,
    pub(super) frame: Frame,
    pub(super) tube: Vec<Interval>,
    /// Length of the next step: a hint.
    pub(super) step: f64,
    /// Sizes of the states lately: a hint.
    pub(super) scale: Vec<f64>,
    /// Time since the start.
    pub(super) elapsed: Interval,
    /// What is known of the signs of surfaces; nothing where it is empty.
    pub(super) signs: Vec<Signs>,
    /// What is known to lie in the unit interval, of unknowns that were replaced by others.
    pub(super) within: Vec<ParamForm>,
    /// Moments for which boxes went on, since no right-hand side was defined on all of it.
    pub(super) undefined: usize,
    /// How much of the states crossings and boxes made no function of the unknowns, by those that decide what is crossed: a hint.
    pub(super) torn: Vec<f64>,
}

/// A quantity: its value in the middle, one slope per unknown, and what is added.
type Affine = (f64, Vec<f64>, Interval);

/// Most terms of a polynomial that are worth it.
pub(super) const MOST_TERMS: usize = 800;

/// Highest order in time.
pub(super) const HIGHEST: usize = 31;

/// Uncertainty below this share of a value is not worth a variable of its own.
const THIN: f64 = 1e-11;

/// The middle and the radius of an interval.
fn split(x: Interval) -> Option<(f64, f64)> {
    let (middle, radius) = x.mid_rad();
    (radius > THIN * middle.abs()).then_some((middle, radius))
}

/// A degree whose polynomials have at most about a hundred terms.
pub(super) fn usual_degree(unknowns: usize) -> usize {
    match unknowns {
        0 => 0,
        1..=2 => 8,
        3 => 4,
        4..=8 => 3,
        9..=12 => 2,
        _ => 1,
    }
}

/// The number of monomials up to a degree in some unknowns and some fresh ones that count `weight` degrees.
pub(super) fn terms((unknowns, fresh): (usize, usize), weight: usize, degree: usize) -> usize {
    // The number of monomials of at most degree q in d variables, and of exactly that.
    let up_to =
        |d: usize, q: usize| (1..=q).fold(1_usize, |count, k| count.saturating_mul(d + k) / k);
    let exactly = |d: usize, q: usize| {
        if d == 0 {
            usize::from(q == 0)
        } else {
            up_to(d - 1, q)
        }
    };
    (0..=degree / weight)
        .map(|power| exactly(fresh, power).saturating_mul(up_to(unknowns, degree - power * weight)))
        .fold(0, usize::saturating_add)
}

impl Form {
    pub(super) fn new(states: &[Interval], params: &[Interval], options: FormOptions) -> Form {
        let starts = (0..states.len()).map(Unknown::Start);
        let all: Vec<(Unknown, Interval)> = starts
            .chain((0..params.len()).map(Unknown::Param))
            .zip(states.iter().chain(params).copied())
            .collect();
        let wide = |x: &(Unknown, Interval)| Some((x.0, split(x.1)?));
        let unknowns: Vec<Range> = all
            .iter()
            .filter_map(wide)
            .map(|(unknown, (middle, radius))| Range {
                unknown,
                middle: Interval::point(middle),
                radius: Interval::point(radius),
            })
            .collect();
        let quantities = all.iter().map(|(unknown, x)| {
            let own = unknowns.iter().position(|range| range.unknown == *unknown);
            let mut slopes = vec![0.0; unknowns.len()];
            let rest = match own {
                Some(v) => {
                    slopes[v] = x.rad();
                    Interval::ZERO
                }
                None => *x - Interval::point(x.mid()),
            };
            (x.mid(), slopes, rest)
        });
        let quantities: Vec<Affine> = quantities.collect();
        Form::affine_set(states.len(), unknowns, &quantities, options)
    }

    /// The form of a parallelotope; the unknowns are its axes.
    pub(super) fn of(states: usize, set: &Parallelotope, options: FormOptions) -> Form {
        let axes = set.axes.first().map_or(0, Vec::len);
        let unknowns = (0..axes).map(|axis| Range {
            unknown: Unknown::Axis(axis),
            middle: Interval::ZERO,
            radius: Interval::ONE,
        });
        let rows = set.axes.iter().zip(&set.rest);
        let quantities = set.centre.iter().zip(rows);
        let quantities: Vec<Affine> = quantities
            .map(|(centre, (slopes, rest))| (*centre, slopes.clone(), Interval::symmetric(*rest)))
            .collect();
        Form::affine_set(states, unknowns.collect(), &quantities, options)
    }

    /// The form of quantities that are affine in some unknowns: states, then parameters.
    fn affine_set(
        count: usize,
        unknowns: Vec<Range>,
        quantities: &[Affine],
        options: FormOptions,
    ) -> Form {
        let degree = options
            .degree
            .unwrap_or_else(|| usual_degree(unknowns.len()));
        let degree = degree.max(1);
        let mut weights = vec![1; unknowns.len()];
        if degree > 1 && !unknowns.is_empty() {
            let wanted = options.fresh.unwrap_or(degree.div_ceil(2)).clamp(1, degree);
            let counts = (unknowns.len(), count);
            // Where there are many states, fresh unknowns stand alone, or there are none.
            let weight =
                (wanted..=degree).find(|weight| terms(counts, *weight, degree) <= MOST_TERMS);
            if let Some(weight) = weight {
                weights.extend((0..count).map(|_| weight));
            }
        }
        let monomials = Monomials::new(&weights, degree);
        let polynomial = |(centre, slopes, _): &Affine| -> Vec<f64> {
            let mut polynomial = vec![0.0; monomials.len()];
            polynomial[0] = *centre;
            polynomial[1..=slopes.len()].copy_from_slice(slopes);
            polynomial
        };
        let (starts, params) = quantities.split_at(count);
        let rests: Vec<Interval> = starts.iter().map(|start| start.2).collect();
        let params = params.iter().map(|param| ParamForm {
            polynomial: polynomial(param),
            radius: param.2.mag(),
        });
        let params = params.collect();
        let starts: Vec<Vec<f64>> = starts.iter().map(polynomial).collect();
        let count = unknowns.len();
        let mut form = Form {
            order: 0,
            scale: starts.iter().map(|p| p[0].abs()).collect(),
            monomials: Arc::new(monomials),
            options,
            unknowns,
            states: starts,
            params,
            frame: Frame::upright(rests),
            tube: Vec::new(),
            step: f64::INFINITY,
            elapsed: Interval::ZERO,
            signs: Vec::new(),
            within: Vec::new(),
            undefined: 0,
            torn: vec![0.0; count],
        };
        form.choose_order();
        form.tube = form.quick_hull();
        form
    }

    /// Coefficients shrink by about `e^2` an order on steps of the best length; one less than a multiple of
    /// four makes whole vectors. Scratch is for the order that it was made with.
    pub(super) fn choose_order(&mut self) {
        if let Some(order) = self.options.order {
            self.order = order.clamp(4, HIGHEST);
            return;
        }
        let share = |state: usize| {
            let width: f64 = self.states[state][1..].iter().map(|x| x.abs()).sum();
            self.tolerance(state) / (self.scale[state] + width + 1e-100)
        };
        let least = (0..self.states.len()).map(share).fold(1.0, f64::min);
        let orders = -0.5 * least.max(1e-17).ln();
        self.order = (orders / 4.0).round().clamp(2.0, 8.0) as usize * 4 - 1;
    }

    /// Products of coefficients in one multiplication of polynomials.
    pub fn cost(&self) -> f64 {
        let orders = (self.order + 1) as f64;
        0.5 * self.monomials.products() as f64 * orders * (orders + 1.0)
    }

    /// Order of the variational equation, which only multiplies what dependence could not keep.
    pub(super) fn slopes(&self) -> usize {
        self.order.min(12)
    }

    /// What the form depends on, each with the values it may have; in the order of
    /// [`OutputForm::slopes`].
    pub fn unknowns(&self) -> Vec<(Unknown, Interval)> {
        let list = self.unknowns.iter();
        list.map(|range| (range.unknown, range.bounds())).collect()
    }

    /// For how many moments since its start no right-hand side was defined on all of the form, so that boxes went on: a hint
    /// that the set is too wide for it.
    pub fn undefined_moments(&self) -> usize {
        self.undefined
    }

    /// What the form depends on, each as `middle + radius δ` with some numbers of these two intervals.
    pub fn scales(&self) -> Vec<(Unknown, Interval, Interval)> {
        let list = self.unknowns.iter();
        list.map(|range| (range.unknown, range.middle, range.radius))
            .collect()
    }

    /// Time since the start.
    pub fn elapsed(&self) -> Interval {
        self.elapsed
    }

    /// Encloses every state at this time.
    ///
    /// Cost: branch and bound over the unknowns; more than a step, where polynomials have many terms.
    pub fn hull(&self) -> Vec<Interval> {
        self.states
            .iter()
            .zip(self.frame.hull())
            .map(|(polynomial, rest)| self.range(polynomial) + rest)
            .collect()
    }

    /// Encloses a polynomial in the unknowns.
    fn range(&self, polynomial: &[f64]) -> Interval {
        let all = range(&self.monomials, polynomial);
        if self.within.is_empty() {
            return all;
        }
        let negated: Vec<f64> = polynomial.iter().map(|x| -x).collect();
        let hi = self.most(polynomial).min(all.hi());
        let lo = (-self.most(&negated)).max(all.lo());
        Interval::new(lo, hi).unwrap_or(all)
    }

    /// The strict sign of all values of a polynomial in the unknowns, up to `off`, if they have one.
    pub(super) fn sign(&self, polynomial: &[f64], off: f64) -> Option<Signs> {
        let quick = Signs::strict(around(polynomial).inflate(off));
        quick.or_else(|| Signs::strict(self.range(polynomial).inflate(off)))
    }

    /// An upper bound of a polynomial in the unknowns, with what is known of them besides.
    ///
    /// Proof. Where `|k| <= 1 + r`, `P <= (P - λ k) + |λ| (1 + r)` for any `λ`. Those that are best for the linear
    /// parts are where some slope of `P - λ k` vanishes.
    fn most(&self, polynomial: &[f64]) -> f64 {
        let count = self.unknowns.len();
        let mut left = polynomial.to_vec();
        let (mut paid, mut rounding) = (0.0, 0.0);
        for known in self.within.iter().chain(&self.within) {
            let k = &known.polynomial;
            let reach = raised(1.0 + known.radius, 1);
            let cost = |factor: f64| -> f64 {
                let slopes = left[1..=count].iter().zip(&k[1..=count]);
                let slopes: f64 = slopes.map(|(p, k)| (p - factor * k).abs()).sum();
                slopes - factor * k[0] + factor.abs() * reach
            };
            let candidates = left[1..=count].iter().zip(&k[1..=count]);
            let candidates = candidates.map(|(p, k)| p / k).filter(|x| x.is_finite());
            let best = candidates.min_by(|a, b| cost(*a).total_cmp(&cost(*b)));
            let Some(factor) = best.filter(|factor| cost(*factor) < cost(0.0)) else {
                continue;
            };
            for (p, k) in left.iter_mut().zip(k) {
                rounding += 2.0 * UNIT * (p.abs() + 2.0 * (factor * k).abs());
                *p -= factor * k;
            }
            paid = raised(paid + factor.abs() * reach, 3);
        }
        let rounding = raised(rounding, 4 * left.len() * (1 + self.within.len()));
        let sum = range(&self.monomials, &left) + Interval::point(paid);
        (sum + Interval::point(rounding)).hi()
    }

    /// As [`Form::hull`], faster and wider.
    pub(super) fn quick_hull(&self) -> Vec<Interval> {
        let rest = self.frame.hull();
        let enclose = |(polynomial, rest): (&Vec<f64>, Interval)| around(polynomial) + rest;
        self.states.iter().zip(rest).map(enclose).collect()
    }

    /// Encloses every state at every time of the last [`Flow::advance`](super::Flow::advance).
    pub fn tube(&self) -> &[Interval] {
        &self.tube
    }

    /// A state as a function of the unknowns.
    pub fn state(&self, state: usize) -> OutputForm {
        let rest = self.frame.hull();
        self.affine(&self.states[state], rest[state])
    }

    /// The affine part of a polynomial, and the rest of it with `rest`.
    pub(super) fn affine(&self, polynomial: &[f64], rest: Interval) -> OutputForm {
        let count = self.unknowns.len();
        let mut curved = polynomial.to_vec();
        curved[..=count].fill(0.0);
        OutputForm {
            centre: polynomial[0],
            slopes: polynomial[1..=count].to_vec(),
            remainder: range(&self.monomials, &curved) + rest,
            hull: range(&self.monomials, polynomial) + rest,
        }
    }

    /// Moves what dependence could not keep by the matrix `map`, adds the vector `low` and the box `more`;
    /// its middle goes to the polynomials, so that only less than a float of it stays.
    pub(super) fn transport(&mut self, map: &[Interval], low: &[f64], more: &[Interval]) {
        let low: Vec<Interval> = low.iter().map(|x| Interval::point(*x)).collect();
        let (moved, shift) = self.frame.moved(map, &low);
        let mut more = more.to_vec();
        for ((polynomial, shift), more) in self.states.iter_mut().zip(shift).zip(&mut more) {
            let (sum, rest) = two_sum(polynomial[0], shift);
            polynomial[0] = sum;
            *more += Interval::point(rest);
        }
        self.frame = moved.completed(&more);
    }

    /// After a step: what dependence could not keep may become unknowns.
    pub(super) fn settle(&mut self) -> Result<(), Obstacle> {
        self.absorb();
        for (scale, polynomial) in self.scale.iter_mut().zip(&self.states) {
            *scale = (0.9 * *scale).max(polynomial[0].abs());
        }
        let finite = self.states.iter().flatten().all(|x| x.is_finite());
        if self.frame.is_bounded() && finite {
            Ok(())
        } else {
            Err(Obstacle::Unbounded)
        }
    }

    /// Encloses every parameter at this time.
    pub fn param_box(&self) -> Vec<Interval> {
        let list = self.params.iter();
        list.map(|param| around(&param.polynomial).inflate(param.radius))
            .collect()
    }

    /// Without what dependence could not keep.
    pub(super) fn without_rest(&self) -> Form {
        let mut form = self.clone();
        form.frame = Frame::upright(vec![Interval::ZERO; self.states.len()]);
        form
    }

    /// The largest share of a width that is no function of the unknowns; nothing where there are none.
    pub(super) fn excess(&self) -> f64 {
        if self.unknowns.is_empty() {
            return 0.0;
        }
        self.excesses().into_iter().fold(0.0, f64::max)
    }

    /// For every state the share of its width that is no function of the unknowns.
    pub(super) fn excesses(&self) -> Vec<f64> {
        let share = |(state, polynomial): (usize, &Vec<f64>)| {
            let rest = self.rest(state);
            if rest == 0.0 {
                return 0.0;
            }
            let terms = polynomial.iter().enumerate().skip(1);
            let own = terms.filter(|(a, _)| !self.is_fresh(*a));
            let own: f64 = own.map(|(_, x)| x.abs()).sum();
            rest / (rest + own)
        };
        self.states.iter().enumerate().map(share).collect()
    }

    /// How much of a state is no function of the unknowns, as far as that matters.
    pub(super) fn rest(&self, state: usize) -> f64 {
        let polynomial = &self.states[state];
        let terms = polynomial.iter().enumerate().skip(1);
        let fresh = terms.filter(|(a, _)| self.is_fresh(*a));
        let fresh: f64 = fresh.map(|(_, x)| x.abs()).sum();
        let rest = self.frame.hull()[state].rad() + fresh;
        if rest > 1e-9 * polynomial[0].abs() {
            rest
        } else {
            0.0
        }
    }

    /// How much of the width of a state each unknown decides.
    pub(super) fn shares(&self, state: usize) -> Vec<(Unknown, f64)> {
        let polynomial = &self.states[state];
        let all: f64 = polynomial[1..].iter().map(|x| x.abs()).sum();
        let all = all + self.frame.hull()[state].rad() + 1e-300;
        let slopes = self.unknowns.iter().zip(&polynomial[1..]);
        slopes
            .map(|(range, x)| (range.unknown, x.abs() / all))
            .collect()
    }

    /// How far from linear the states depend on each unknown: the share of what is not linear in it, and of what was lost
    /// where it decides which right-hand side acts. A hint.
    pub fn curvature(&self) -> Vec<f64> {
        let mut curvature = self.torn.clone();
        for polynomial in &self.states {
            let size: f64 = polynomial[1..].iter().map(|x| x.abs()).sum();
            for (a, x) in polynomial.iter().enumerate() {
                let exponents = self.monomials.exponents(a);
                if exponents.iter().sum::<u8>() > 1 && size > 0.0 {
                    for (slot, e) in curvature.iter_mut().zip(exponents) {
                        *slot += f64::from(*e) * x.abs() / size;
                    }
                }
            }
        }
        curvature
    }

    /// What a step may neglect for a state.
    pub(super) fn tolerance(&self, state: usize) -> f64 {
        let width: f64 = self.states[state][1..].iter().map(|x| x.abs()).sum();
        let options = &self.options;
        (options.tolerance * self.scale[state]).max(options.share * width) + 1e-200
    }

    /// Lets steps neglect no less than those of `other`, which may be wider.
    pub(super) fn neglect_as(&mut self, other: &Form) {
        for state in 0..self.states.len() {
            let scale = other.tolerance(state) / self.options.tolerance;
            self.scale[state] = self.scale[state].max(scale);
        }
    }
}

/// `a + b` rounded, and what rounding took, exactly unless numbers overflow.
pub(super) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let other = sum - a;
    (sum, (a - (sum - other)) + (b - other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_counted() {
        for (counts, weight, degree) in [
            ((2, 2), 2, 4),
            ((3, 2), 1, 3),
            ((1, 4), 3, 3),
            ((2, 0), 1, 5),
        ] {
            let weights = [vec![1; counts.0], vec![weight; counts.1]].concat();
            let table = Monomials::new(&weights, degree);
            assert_eq!(terms(counts, weight, degree), table.len());
        }
    }

    /// A hundred states have no products of fresh unknowns.
    #[test]
    fn many_states_have_few_terms() {
        let states = vec![Interval::ZERO; 100];
        let params = [Interval::new(1.0, 2.0).unwrap_or(Interval::ONE); 2];
        let form = Form::new(&states, &params, FormOptions::default());
        assert!(form.monomials.len() <= MOST_TERMS);
    }

    #[test]
    fn what_a_sum_loses_stays_in_the_frame() {
        let mut form = Form::new(&[Interval::ONE], &[], FormOptions::default());
        let low = f64::powi(0.5, 70);
        form.transport(&[Interval::ONE], &[low], &[Interval::ZERO]);
        assert_eq!(form.states[0][0], 1.0);
        assert!(form.frame.hull()[0].contains(low));
    }
}
