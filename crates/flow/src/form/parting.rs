//! A set is divided where outcomes part: some solutions stick and stay, others turn once more.
//!
//! What decides is the sign of a rate of change on a surface (`open.rs`), a polynomial `s` in the unknowns. Parts are
//! cut along it, whatever its direction is:
//!
//! 1. One unknown `δ_v`, that `s` depends on most, is replaced by `τ = (s - s_0) / size`: a polynomial `q` with
//!    `δ_v = q(τ, ..)` up to a remainder is computed, without a claim; that of `q` put into `τ` is bounded, and so is what it changes.
//!    All other unknowns stay what they are.
//! 2. The part in which `s` is within a *border* around zero is cut out. It is so thin that how far solutions creep there
//!    does not matter (`creeping.rs`). On the side to which solutions leave, parts are cut in a
//!    geometric sequence towards it, so that all of a part have speeds that compare.
//!
//! The other bounds of the set are not forgotten: `-1 <= δ_v <= 1` is kept as a polynomial in the new unknowns that is known to
//! lie in the unit interval ([`Form::hull`] uses it).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one coefficient per monomial, unknowns by their positions"
)]

use std::sync::Arc;

use super::ahead::multiply;
use super::journey::Journey;
use super::monomials::Monomials;
use super::open::Open;
use super::outward::{UNIT, raised};
use super::regime::{Field, Watch};
use super::set::{Form, ParamForm};
use super::size::Size;
use super::surfaces::Signs;
use veribound_interval::Interval;

/// The border is at least so small a share of all values.
const THIN: f64 = 1.0 / 1_048_576.0;

/// A border is so much wider than what is not known of the values.
pub(super) const CLEAR: f64 = 16.0;

/// Nothing is gained where the border is a larger share of all values.
const THICK: f64 = 0.25;

/// Speeds in one part differ by this factor, or by a larger one where parts are few.
const RATIOS: [f64; 4] = [4.0, 16.0, 64.0, 256.0];

/// A remainder of the new unknown above this is too much.
const ROUGH: f64 = 1e-3;

/// Where outcomes part.
#[derive(Debug, Clone)]
pub(super) struct Undecided {
    pub(super) open: Open,
    /// Solutions leave the surface where the rate has this sign, if it is known.
    pub(super) way: Option<Signs>,
}

/// A part of a set.
#[derive(Debug, Clone)]
pub(super) struct Portion {
    pub(super) form: Form,
    /// Whether outcomes part within it.
    pub(super) is_border: bool,
}

impl Journey<'_> {
    /// What decides at a surface, if that is one rate.
    pub(super) fn undecided_at(
        &self,
        surface: usize,
        field: &Field,
        signs: &[Signs],
        open: Vec<Open>,
    ) -> Option<Undecided> {
        let mut here = open.into_iter().filter(|open| open.surface == surface);
        let open = here.next()?;
        if here.any(|other| other.expr != open.expr)
            || !self.flow.switching.is_steady(surface, field)
        {
            return None;
        }
        let switching = &self.flow.switching;
        let barred = switching.barred(surface, signs).map(Signs::flipped);
        let way = barred.or_else(|| switching.side_of(surface, open.mode, signs));
        Some(Undecided { open, way })
    }

    /// Divides the form where outcomes part, if there may be so many parts.
    ///
    /// The new unknowns stand for more than the set, also for solutions that have passed the surface already; the form goes
    /// back to where none has.
    pub(super) fn part(&mut self, asked: Watch, undecided: &Undecided) -> Option<()> {
        if self.is_border || self.may_part < 2 {
            return None;
        }
        let open = &undecided.open;
        let mut turned = None;
        while let Some(place) = self.earlier.pop_back() {
            let found = place.form.in_terms_of(&open.polynomial)?;
            let inputs = &self.stretches[place.current].inputs;
            if self.has_sign(&found.form, asked, inputs) {
                turned = Some(found);
                self.back_to(place);
                break;
            }
        }
        let turned = turned?;
        let middle = open.polynomial[0];
        let values = Interval::point(middle).inflate(turned.size);
        let border = (CLEAR * (open.off + turned.off)).max(THIN * values.width());
        if border.is_nan() || border >= THICK * values.width() {
            return None;
        }
        let towards = |sign: Signs| undecided.way.is_none_or(|way| way == sign);
        let below = towards(Signs::NEGATIVE);
        let above = towards(Signs::POSITIVE);
        let cuts = RATIOS.iter().find_map(|ratio| {
            let mut cuts: Vec<f64> = ends(border, -values.lo(), below.then_some(*ratio));
            cuts.reverse();
            let mut cuts: Vec<f64> = cuts.iter().map(|x| -x).collect();
            let first = cuts.len();
            cuts.extend(ends(border, values.hi(), above.then_some(*ratio)));
            (cuts.len() < self.may_part).then_some((cuts, first))
        });
        let (cuts, first) = cuts?;
        let scaled = cuts
            .iter()
            .map(|x| ((x - middle) / turned.size).clamp(-1.0, 1.0));
        let bounds: Vec<f64> = [-1.0].into_iter().chain(scaled).chain([1.0]).collect();
        let mut parts = Vec::with_capacity(bounds.len());
        for (number, ends) in bounds.windows(2).enumerate() {
            let mut unit = vec![Interval::symmetric(1.0); self.form.unknowns.len()];
            unit[turned.unknown] = Interval::new(ends[0], ends[1])?;
            let mut form = turned.form.clone();
            form.narrow(&unit);
            parts.push(Portion {
                form,
                is_border: number == first,
            });
        }
        self.parts = parts.into_iter().map(|part| self.fork(part)).collect();
        Some(())
    }
}

/// Where to cut values between `border` and `end`, each so many times as far as the one before; there alone without a ratio.
pub(super) fn ends(border: f64, end: f64, ratio: Option<f64>) -> Vec<f64> {
    let mut cuts = Vec::new();
    let mut at = border;
    while at < end {
        cuts.push(at);
        match ratio {
            Some(ratio) => at *= ratio,
            None => break,
        }
    }
    cuts
}

/// A form in which one unknown is what decides.
struct Turned {
    form: Form,
    /// The position of that unknown.
    unknown: usize,
    /// It is what decides, less its middle, over this.
    size: f64,
    /// How far what decides can be from that.
    off: f64,
}

impl Form {
    /// The same set in other unknowns: one of them is `decider`, scaled.
    ///
    /// Guarantee: for every `δ` of the unit box the states and parameters lie in the new form, at the unknowns that belong to
    /// `δ`, which are in the unit box, too.
    fn in_terms_of(&self, decider: &[f64]) -> Option<Turned> {
        let monomials = &*self.monomials;
        // Fresh unknowns are not the same at all times.
        let mut decider = decider.to_vec();
        let mut fresh = 0.0;
        for (a, x) in decider.iter_mut().enumerate() {
            if self.is_fresh(a) {
                fresh += x.abs();
                *x = 0.0;
            }
        }
        let turn = Turn::new(self, &decider)?;
        let replaced = |polynomial: &[f64]| turn.replaced(polynomial);
        let mut form = self.clone();
        let mut off = Vec::with_capacity(self.states.len());
        for polynomial in &mut form.states {
            let (new, lost) = replaced(polynomial);
            *polynomial = new;
            off.push(Interval::symmetric(lost));
        }
        form.widen(&off);
        for param in form.params.iter_mut().chain(&mut form.within) {
            let (new, lost) = replaced(&param.polynomial);
            param.polynomial = new;
            param.radius = raised(param.radius + lost, 1);
        }
        form.within.push(turn.replaced_one());
        // What decides is the new unknown, up to this.
        let (mut now, lost) = replaced(&decider);
        now[0] -= decider[0];
        now[monomials.linear(turn.unknown)] -= turn.size;
        let off: f64 = now.iter().map(|x| x.abs()).sum();
        Some(Turned {
            form,
            unknown: turn.unknown,
            size: turn.size,
            off: off + lost + fresh,
        })
    }
}

/// Other unknowns: a polynomial `τ` in those of a form in place of one of them.
pub(super) struct Turn {
    monomials: Arc<Monomials>,
    /// Which one.
    pub(super) unknown: usize,
    /// The new one in terms of all old ones; its absolute coefficients add up to at most one.
    pub(super) tau: Vec<f64>,
    /// The old one in terms of the new one and the others, and how far from that.
    old: Vec<f64>,
    rest: f64,
    /// The polynomial given, less its middle, is `τ` times this.
    pub(super) size: f64,
}

impl Turn {
    /// The unknown that `decider` depends on most is replaced; `None` where the two do not tell each other.
    ///
    /// Proof. The new unknown `τ` is a polynomial of which the absolute coefficients add up to at most one.
    /// `q(τ(δ), ..) = δ_v + R` with `|R|` at most the sum `r` of absolute coefficients and what rounding and truncation take. A
    /// polynomial `P` at `q` instead of `δ_v` differs by at most `r` times its slope for `|δ_v| <= 1 + r`.
    pub(super) fn new(form: &Form, decider: &[f64]) -> Option<Turn> {
        let monomials = &form.monomials;
        let slope = |v: usize| decider[monomials.linear(v)];
        let unknown =
            (0..form.unknowns.len()).max_by(|a, b| slope(*a).abs().total_cmp(&slope(*b).abs()))?;
        let own = monomials.linear(unknown);
        let size: f64 = decider[1..].iter().map(|x| x.abs()).sum::<f64>() * (1.0 + 1e-9);
        let fit = slope(unknown).abs() > 0.0 && size.is_finite();
        if !fit {
            return None;
        }
        // The new unknown, and the old one in terms of it and of the others.
        let mut tau: Vec<f64> = decider.iter().map(|x| x / size).collect();
        tau[0] = 0.0;
        let mut old = vec![0.0; monomials.len()];
        for _ in 0..2 * monomials.degree + 4 {
            let (found, _) = composed(monomials, &tau, unknown, &old);
            for (a, x) in old.iter_mut().enumerate() {
                let wanted = if a == own { 1.0 } else { 0.0 };
                *x += (wanted - found[a]) / tau[own];
            }
        }
        if !old.iter().all(|x| x.is_finite()) {
            return None;
        }
        let (mut rest, lost) = composed(monomials, &old, unknown, &tau);
        rest[own] -= 1.0;
        let rest: f64 = rest.iter().map(|x| x.abs() * (1.0 + 4.0 * UNIT)).sum();
        let rest = raised(rest + lost, monomials.len() + 4);
        let monomials = Arc::clone(monomials);
        let known = rest < ROUGH;
        known.then_some(Turn {
            monomials,
            unknown,
            tau,
            old,
            rest,
            size,
        })
    }

    /// The unknown that was replaced in terms of the new ones: it lies in the unit interval.
    pub(super) fn replaced_one(&self) -> ParamForm {
        ParamForm {
            polynomial: self.old.clone(),
            radius: self.rest,
        }
    }

    /// A polynomial in the new unknowns, and how far from the one given.
    pub(super) fn replaced(&self, polynomial: &[f64]) -> (Vec<f64>, f64) {
        let (monomials, v) = (&*self.monomials, self.unknown);
        let (new, lost) = composed(monomials, polynomial, v, &self.old);
        let slope: f64 = polynomial
            .iter()
            .enumerate()
            .map(|(a, x)| {
                let exponent = monomials.exponents(a)[v];
                f64::from(exponent) * x.abs() * (1.0 + self.rest).powi(exponent.into())
            })
            .sum();
        let moved = raised(
            slope * self.rest,
            monomials.len() + 2 * monomials.degree + 8,
        );
        (new, raised(lost + moved, 2))
    }
}

/// A polynomial with another one for variable `v`, and what rounding and truncation can have taken.
///
/// Proof. Horner's rule in `δ_v`, `acc <- acc q + P_k`: what a product loses is told by [`Size::product`], and what was lost
/// before is multiplied by at most the sum of the absolute coefficients of `q`.
fn composed(monomials: &Monomials, polynomial: &[f64], v: usize, q: &[f64]) -> (Vec<f64>, f64) {
    let count = monomials.len();
    let exponent = |a: usize| monomials.exponents(a)[v];
    let used = polynomial.iter().enumerate().filter(|(_, x)| **x != 0.0);
    let highest = used.map(|(a, _)| exponent(a)).max().unwrap_or(0);
    let (mut q_size, mut acc_size) = (Size::new(monomials, 1), Size::new(monomials, 1));
    q_size.measure(monomials, q, &[1.0], 0);
    let (mut acc, mut next) = (vec![0.0; count], vec![0.0; count]);
    let mut lost = 0.0;
    for power in (0..=highest).rev() {
        acc_size.measure(monomials, &acc, &[1.0], 0);
        multiply(monomials, &acc, q, &mut next);
        let product = acc_size.product(&q_size, monomials, 0);
        let mut rounding = 0.0;
        for (a, x) in polynomial.iter().enumerate() {
            if exponent(a) == power && *x != 0.0 {
                let below = (0..power).fold(a, |b, _| monomials.quotient(b, v));
                next[below] += x;
                rounding += next[below].abs();
            }
        }
        std::mem::swap(&mut acc, &mut next);
        lost = raised(lost * q_size.total + product + UNIT * rounding, count + 4);
    }
    (acc, lost)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::form::draw::Draw;
    use crate::form::set::FormOptions;

    fn value(monomials: &Monomials, polynomial: &[f64], at: [f64; 2]) -> f64 {
        let terms = polynomial.iter().enumerate().map(|(a, x)| {
            let e = monomials.exponents(a);
            x * at[0].powi(e[0].into()) * at[1].powi(e[1].into())
        });
        terms.sum()
    }

    /// In other unknowns every point is where it was, up to what is said; and what is known of the unknown that was
    /// replaced is true.
    #[test]
    fn other_unknowns_tell_the_same_set() {
        let mut draws = Draw(11);
        let mut draw = || draws.next();
        let options = FormOptions {
            degree: Some(4),
            ..FormOptions::default()
        };
        let mut widest: f64 = 0.0;
        for _ in 0..200 {
            let unit = Interval::symmetric(1.0);
            let mut form = Form::new(&[unit, unit], &[], options);
            let monomials = form.monomials.clone();
            let is_kept = |a: usize| monomials.exponents(a)[2..].iter().all(|e| *e == 0);
            let mut decider = vec![0.0; monomials.len()];
            for a in (0..monomials.len()).filter(|a| is_kept(*a)) {
                let degree: u8 = monomials.exponents(a).iter().sum();
                decider[a] = draw() * f64::powi(0.1, i32::from(degree) - 1).min(1.0);
                for polynomial in &mut form.states {
                    polynomial[a] = draw();
                }
            }
            let Some(turned) = form.in_terms_of(&decider) else {
                continue;
            };
            let rest = turned.form.frame.hull();
            for _ in 0..20 {
                let before = [draw(), draw()];
                let tau = (value(&monomials, &decider, before) - decider[0]) / turned.size;
                assert!(tau.abs() <= 1.0);
                let mut after = before;
                after[turned.unknown] = tau;
                for ((old, new), rest) in form.states.iter().zip(&turned.form.states).zip(&rest) {
                    let apart = value(&monomials, old, before) - value(&monomials, new, after);
                    assert!(rest.inflate(1e-13).contains(apart), "{apart} {rest}");
                    widest = widest.max((apart.abs() - 1e-13) / rest.mag());
                }
                let known = &turned.form.within[0];
                let own = value(&monomials, &known.polynomial, after);
                assert!((own - before[turned.unknown]).abs() <= known.radius + 1e-13);
            }
        }
        assert!(widest > 0.02, "the bound is not idle: {widest}");
    }
}
