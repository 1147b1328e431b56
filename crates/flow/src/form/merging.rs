//! Several forms of the same unknowns, each true for some of them, become one.
//!
//! Slices are told apart by one polynomial in the unknowns. In place of one unknown (`parting.rs`, [`Turn`]) it makes every
//! slice a box, on which polynomials are bounded. Where slices meet, their forms nearly agree, so one polynomial is found that is near to
//! all of them, without a claim; how far each is from it, on its own slice, is bounded.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one coefficient per monomial, one polynomial per state"
)]

use std::sync::Arc;

use super::ahead::{around, multiply};
use super::frame::Frame;
use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use super::parting::Turn;
use super::range::range;
use super::set::Form;
use veribound_interval::Interval;

/// Points of every slice at which the common polynomial is near to it.
const POINTS: usize = 8;

/// Rounds in which it comes nearer where it is farthest away.
const ROUNDS: usize = 12;

/// Ends of slices are found to this share of all, or so many times as roughly.
const FINEST: f64 = 1.0 / 4096.0;

/// A form that is true where what tells slices apart is in an interval.
pub(super) struct Slice<'a> {
    pub(super) form: &'a Form,
    pub(super) place: Interval,
}

impl Turn {
    /// Encloses a polynomial in the old unknowns where the new one is in `place`.
    fn range_on(&self, monomials: &Monomials, polynomial: &[f64], place: Interval) -> Interval {
        let (new, lost) = self.on_slice(monomials, polynomial, place);
        range(monomials, &new).inflate(lost)
    }

    /// As [`Turn::range_on`], faster and wider.
    fn around_on(&self, monomials: &Monomials, polynomial: &[f64], place: Interval) -> Interval {
        let (new, lost) = self.on_slice(monomials, polynomial, place);
        around(&new).inflate(lost)
    }

    fn on_slice(
        &self,
        monomials: &Monomials,
        polynomial: &[f64],
        place: Interval,
    ) -> (Vec<f64>, f64) {
        let (mut new, lost) = self.replaced(polynomial);
        let off = self.onto(monomials, &mut new, place);
        (new, raised(lost + off, 1))
    }

    /// Takes a polynomial in the new unknowns to the unit box of a slice; returns what rounding can have taken.
    fn onto(&self, monomials: &Monomials, polynomial: &mut [f64], place: Interval) -> f64 {
        let (middle, radius) = place.mid_rad();
        monomials.substitute(polynomial, self.unknown, middle, radius)
    }

    /// Where a polynomial that grows with the new unknown, up to `off`, can be zero at all.
    pub(super) fn zeros(&self, monomials: &Monomials, polynomial: &[f64], off: f64) -> Interval {
        let (new, _) = self.replaced(polynomial);
        let powers = powers(monomials, self.unknown);
        let value = |x: f64| powers.iter().rev().fold(0.0, |sum, a| sum * x + new[*a]);
        let (mut below, mut above) = (-1.0, 1.0);
        while above - below > 0.01 * FINEST {
            let middle = 0.5 * (below + above);
            *(if value(middle) < 0.0 {
                &mut below
            } else {
                &mut above
            }) = middle;
        }
        let has_sign = |from: f64, to: f64, positive: bool| {
            let place = Interval::new(from, to);
            place.is_none_or(|place| {
                let values = self.around_on(monomials, polynomial, place).inflate(off);
                if positive {
                    values.lo() > 0.0
                } else {
                    values.hi() < 0.0
                }
            })
        };
        // Where it has one sign to the end; not found at once over wide slices, where it need not be monotone for the bound.
        let end = |positive: bool| {
            let way = if positive { 1.0 } else { -1.0 };
            let mut step = FINEST;
            while step < 2.0 {
                let from = 0.5 * (below + above) + way * step;
                if !(-1.0..=1.0).contains(&from) {
                    break;
                }
                let cells = 4;
                let at = |k: i32| from + (way - from) * f64::from(k) / f64::from(cells);
                let is_proved = (0..cells).all(|k| {
                    let (a, b) = (at(k), at(k + 1));
                    has_sign(a.min(b), a.max(b), positive)
                });
                if is_proved {
                    return from;
                }
                step *= 2.0;
            }
            way
        };
        Interval::new(end(false), end(true)).unwrap_or(Interval::symmetric(1.0))
    }

    /// A box around the states of a slice.
    pub(super) fn hull(&self, slice: &Slice<'_>) -> Vec<Interval> {
        let mut form = slice.form.clone();
        let rests = form.frame.hull();
        let monomials = Arc::clone(&form.monomials);
        let on = |polynomial: &[f64]| self.on_slice(&monomials, polynomial, slice.place);
        let mut wider = Vec::with_capacity(rests.len());
        for (polynomial, rest) in form.states.iter_mut().zip(rests) {
            let (new, lost) = on(polynomial);
            *polynomial = new;
            wider.push(rest.inflate(lost));
        }
        form.frame = Frame::upright(wider);
        for known in &mut form.within {
            let (new, lost) = on(&known.polynomial);
            known.polynomial = new;
            known.radius = raised(known.radius + lost, 1);
        }
        let mut replaced = self.replaced_one();
        let lost = self.onto(&monomials, &mut replaced.polynomial, slice.place);
        replaced.radius = raised(replaced.radius + lost, 1);
        form.within.push(replaced);
        // Beyond the unit box polynomials may go anywhere.
        let all = slice.form.hull();
        form.hull()
            .iter()
            .zip(all)
            .map(|(a, b)| a.intersect(b))
            .collect()
    }

    /// A form that is near to those of all slices.
    ///
    /// Guarantee: the states of every slice are in it, for the unknowns that lie in the slice.
    pub(super) fn merged(&self, slices: &[Slice<'_>]) -> Option<Form> {
        let middle = slices.get(slices.len() / 2)?.form;
        let monomials = &*middle.monomials;
        let powers = powers(monomials, self.unknown);
        let rests: Vec<Vec<Interval>> = slices.iter().map(|s| s.form.frame.hull()).collect();
        let mut all = Vec::with_capacity(middle.states.len());
        let mut deviations = Vec::with_capacity(middle.states.len());
        for (state, reference) in middle.states.iter().enumerate() {
            let mut points = Vec::with_capacity(slices.len() * (POINTS + 1));
            for slice in slices {
                let apart = slice.form.states[state].iter().zip(reference);
                let apart: Vec<f64> = apart.map(|(a, b)| a - b).collect();
                let (new, _) = self.replaced(&apart);
                for k in 0..=POINTS {
                    let x = slice.place.lo() + slice.place.width() * k as f64 / POINTS as f64;
                    points.push((x, powers.iter().rev().fold(0.0, |sum, a| sum * x + new[*a])));
                }
            }
            let common = self.near(reference, &nearest(&points, powers.len() - 1)?, monomials);
            let mut deviation = Interval::EMPTY;
            for (slice, rest) in slices.iter().zip(&rests) {
                let mut apart = slice.form.states[state].clone();
                let mut rounding = 0.0;
                for (a, b) in apart.iter_mut().zip(&common) {
                    *a -= b;
                    rounding += UNIT * a.abs();
                }
                let off = raised(rounding, apart.len());
                let apart = self.range_on(monomials, &apart, slice.place).inflate(off);
                deviation = deviation.hull(apart + rest[state]);
            }
            all.push(common);
            deviations.push(deviation);
        }
        let mut form = middle.clone();
        form.states = all;
        form.frame = Frame::upright(deviations);
        form.know_no_more(slices.iter().map(|slice| slice.form));
        Some(form)
    }

    /// `polynomial` plus one in the new unknown alone, about.
    fn near(&self, polynomial: &[f64], more: &[f64], monomials: &Monomials) -> Vec<f64> {
        let mut sum = vec![0.0; monomials.len()];
        let mut next = sum.clone();
        for x in more.iter().rev() {
            multiply(monomials, &sum, &self.tau, &mut next);
            next[0] += x;
            std::mem::swap(&mut sum, &mut next);
        }
        sum.iter().zip(polynomial).map(|(a, b)| a + b).collect()
    }
}

/// Where a part of a form lies: an unknown of the whole is `middle + radius δ`, up to `off`, for that of the part.
#[derive(Debug, Clone, Copy)]
pub(super) struct Share {
    middle: f64,
    radius: f64,
    off: f64,
}

impl Share {
    pub(super) const WHOLE: Share = Share {
        middle: 0.0,
        radius: 1.0,
        off: 0.0,
    };

    /// Of the part that [`Form::narrow`] makes.
    pub(super) fn of(place: Interval) -> Share {
        let (middle, radius) = place.mid_rad();
        let off = 0.0;
        Share {
            middle,
            radius,
            off,
        }
    }

    /// Of a part of this part: all numbers are at most about one, and four operations are rounded.
    pub(super) fn part(self, place: Interval) -> Share {
        let (middle, radius) = place.mid_rad();
        Share {
            middle: self.middle + self.radius * middle,
            radius: self.radius * radius,
            off: raised(self.off + 8.0 * UNIT, 1),
        }
    }
}

impl Form {
    /// Forms of parts of this one, in each of which an unknown was narrowed to a part of the unit box, as one form of the unknowns of
    /// this one.
    ///
    /// Guarantee: the states of each are in it, for the unknowns of its part.
    pub(super) fn joined(&self, v: usize, parts: &[(&Form, Share)]) -> Option<Form> {
        let monomials = &*self.monomials;
        let widest = |a: &&(&Form, Share), b: &&(&Form, Share)| a.1.radius.total_cmp(&b.1.radius);
        let (reference, whole) = *parts.iter().max_by(widest)?;
        let powers = powers(monomials, v);
        let rests: Vec<Vec<Interval>> = parts.iter().map(|(form, _)| form.frame.hull()).collect();
        let mut form = reference.clone();
        form.params.clone_from(&self.params);
        form.within.clone_from(&self.within);
        form.unknowns.clone_from(&self.unknowns);
        let mut deviations = Vec::with_capacity(form.states.len());
        for (state, common) in form.states.iter_mut().enumerate() {
            let (middle, radius) = (-whole.middle / whole.radius, 1.0 / whole.radius);
            monomials.substitute(common, v, middle, radius);
            let mut points = Vec::with_capacity(parts.len() * (POINTS + 1));
            for (part, share) in parts {
                let (apart, _) = share.apart(monomials, v, common, &part.states[state]);
                for k in 0..=POINTS {
                    let x = -1.0 + 2.0 * k as f64 / POINTS as f64;
                    let y = powers.iter().rev().fold(0.0, |sum, a| sum * x + apart[*a]);
                    points.push((share.middle + share.radius * x, y));
                }
            }
            for (a, more) in powers.iter().zip(nearest(&points, powers.len() - 1)?) {
                common[*a] += more;
            }
            let mut deviation = Interval::EMPTY;
            for ((part, share), rest) in parts.iter().zip(&rests) {
                let (apart, off) = share.apart(monomials, v, common, &part.states[state]);
                deviation = deviation.hull(range(monomials, &apart).inflate(off) + rest[state]);
            }
            deviations.push(deviation);
        }
        form.frame = Frame::upright(deviations);
        form.know_no_more(parts.iter().map(|(part, _)| *part));
        Some(form)
    }

    /// Keeps of the surfaces what is true of all these forms, too; one that tells no signs knows nothing.
    fn know_no_more<'a>(&mut self, others: impl Iterator<Item = &'a Form>) {
        for other in others {
            self.signs.truncate(other.signs.len());
            for (own, other) in self.signs.iter_mut().zip(&other.signs) {
                *own = own.or(*other);
            }
        }
    }
}

impl Share {
    /// How far a polynomial in the unknowns of the part is from one in those of the whole: a polynomial in those of the part, and how far from
    /// that.
    fn apart(
        self,
        monomials: &Monomials,
        v: usize,
        whole: &[f64],
        part: &[f64],
    ) -> (Vec<f64>, f64) {
        let mut apart = whole.to_vec();
        let mut off = monomials.substitute(&mut apart, v, self.middle, self.radius);
        for (a, b) in apart.iter_mut().zip(part) {
            *a = b - *a;
            off += UNIT * a.abs();
        }
        if self.off > 0.0 {
            // The unknown is at most about one.
            let slopes = whole.iter().enumerate();
            let slopes = slopes.map(|(a, x)| f64::from(monomials.exponents(a)[v]) * x.abs());
            off += self.off * 1.001 * slopes.sum::<f64>();
        }
        let count = 2 * apart.len() + 4;
        (apart, raised(off, count))
    }
}

/// The monomials that are powers of one variable.
fn powers(monomials: &Monomials, v: usize) -> Vec<usize> {
    let is_power = |a: &usize| {
        let exponents = monomials.exponents(*a).iter().enumerate();
        exponents.filter(|(l, _)| *l != v).all(|(_, e)| *e == 0)
    };
    // By degree, as the table is.
    (0..monomials.len()).filter(is_power).collect()
}

/// Coefficients of a polynomial of so high a degree near to points in `[-1, 1]`: least squares, with weights that grow where it is
/// farthest away (Lawson).
fn nearest(points: &[(f64, f64)], degree: usize) -> Option<Vec<f64>> {
    let count = degree + 1;
    let mut best = vec![0.0; count];
    let value = |list: &[f64], x: f64| list.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let farthest = |list: &[f64]| {
        let off = points.iter().map(|(x, y)| (value(list, *x) - y).abs());
        off.fold(0.0, f64::max)
    };
    let mut least = farthest(&best);
    if least == 0.0 {
        return Some(best);
    }
    let mut weights = vec![1.0; points.len()];
    for _ in 0..ROUNDS {
        let mut matrix = vec![0.0; count * count];
        let mut side = vec![0.0; count];
        for ((x, y), weight) in points.iter().zip(&weights) {
            let row: Vec<f64> = (0..count).map(|k| x.powi(k as i32)).collect();
            for (i, a) in row.iter().enumerate() {
                side[i] += weight * a * y;
                for (l, b) in row.iter().enumerate() {
                    matrix[i * count + l] += weight * a * b;
                }
            }
        }
        let Some(list) = solved(count, matrix, side) else {
            break;
        };
        let most = farthest(&list);
        if most.is_nan() {
            break;
        }
        if most < least {
            least = most;
            best.clone_from(&list);
        }
        for ((x, y), weight) in points.iter().zip(&mut weights) {
            *weight *= (value(&list, *x) - y).abs() / (most + 1e-300) + 1e-6;
        }
        let total: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= total);
    }
    Some(best)
}

/// About the solution of symmetric linear equations.
fn solved(count: usize, mut matrix: Vec<f64>, mut side: Vec<f64>) -> Option<Vec<f64>> {
    for k in 0..count {
        let pivot = matrix[k * count + k];
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        for i in k + 1..count {
            let factor = matrix[i * count + k] / pivot;
            for l in k..count {
                matrix[i * count + l] -= factor * matrix[k * count + l];
            }
            side[i] -= factor * side[k];
        }
    }
    for k in (0..count).rev() {
        let later = (k + 1..count).map(|l| matrix[k * count + l] * side[l]);
        side[k] = (side[k] - later.sum::<f64>()) / matrix[k * count + k];
    }
    Some(side)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::form::draw::Draw;
    use crate::form::set::FormOptions;
    use crate::form::surfaces::Signs;

    fn value(monomials: &Monomials, polynomial: &[f64], at: &[f64]) -> f64 {
        let terms = polynomial.iter().enumerate().map(|(a, x)| {
            let exponents = monomials.exponents(a).iter().zip(at);
            x * exponents
                .map(|(e, at)| at.powi(i32::from(*e)))
                .product::<f64>()
        });
        terms.sum()
    }

    /// A form of two unknowns, and polynomials of degree three in them.
    fn form() -> Form {
        let unit = Interval::symmetric(1.0);
        let options = FormOptions {
            degree: Some(3),
            ..FormOptions::default()
        };
        Form::new(&[unit, unit], &[], options)
    }

    fn polynomial(monomials: &Monomials, draw: &mut Draw, sizes: [f64; 4]) -> Vec<f64> {
        let coefficient = |a: usize| {
            let exponents = monomials.exponents(a);
            let degree: u8 = exponents.iter().sum();
            let is_kept = exponents[2..].iter().all(|e| *e == 0);
            if is_kept {
                sizes[usize::from(degree)] * draw.next()
            } else {
                0.0
            }
        };
        (0..monomials.len()).map(coefficient).collect()
    }

    /// Slices that are one function on each side of where they meet: wherever a point is, the form of its slice is in the common
    /// one; and what is told of a slice holds on it.
    #[test]
    fn slices_are_in_the_common_form() {
        let mut draw = Draw(5);
        let (mut checks, mut nearest) = (0, f64::INFINITY);
        for _ in 0..60 {
            let mut form = form();
            let monomials = Arc::clone(&form.monomials);
            let mut decider = polynomial(&monomials, &mut draw, [0.0, 0.3, 0.005, 0.001]);
            decider[1] = 1.0;
            let turn = Turn::new(&form, &decider).unwrap();
            for polynomial in &mut form.states {
                *polynomial = self::polynomial(&monomials, &mut draw, [1.0, 1.0, 0.1, 0.01]);
            }
            // As captures are: they agree with their slopes where the new unknown is at the border.
            let border = 0.5 * draw.next();
            let mut other = form.clone();
            for polynomial in &mut other.states {
                let more = turn.near(
                    polynomial,
                    &[border * border, -2.0 * border, 1.0],
                    &monomials,
                );
                let shift: Vec<f64> = more
                    .iter()
                    .zip(&*polynomial)
                    .map(|(a, b)| 0.05 * (a - b))
                    .collect();
                for (own, shift) in polynomial.iter_mut().zip(shift) {
                    *own += shift;
                }
            }
            let slices = [
                Slice {
                    form: &form,
                    place: Interval::new(-1.0, border + 0.01).unwrap(),
                },
                Slice {
                    form: &other,
                    place: Interval::new(border - 0.01, 1.0).unwrap(),
                },
            ];
            let common = turn.merged(&slices).unwrap();
            let hulls = slices.each_ref().map(|slice| turn.hull(slice));
            let rest = common.frame.hull();
            for _ in 0..100 {
                let at = [draw.next(), draw.next(), 0.0, 0.0];
                let tau = value(&monomials, &turn.tau, &at);
                for (slice, hull) in slices.iter().zip(&hulls) {
                    if !slice.place.contains(tau) {
                        continue;
                    }
                    for state in 0..2 {
                        let own = value(&monomials, &slice.form.states[state], &at);
                        let near = value(&monomials, &common.states[state], &at);
                        assert!(
                            rest[state].inflate(1e-14).contains(own - near),
                            "{own} {near}"
                        );
                        assert!(
                            hull[state].inflate(1e-14).contains(own),
                            "{own} {}",
                            hull[state]
                        );
                        nearest = nearest
                            .min((rest[state].rad() - (own - near).abs()) / rest[state].rad());
                        checks += 1;
                    }
                }
            }
            assert!(rest.iter().all(|x| x.mag() < 0.02), "{rest:?}");
        }
        assert!(
            checks > 5000 && nearest < 0.4,
            "the bound is not idle: {checks} {nearest}"
        );
    }

    /// Two parts of a form that went ways of their own are in the one that they become.
    #[test]
    fn parts_are_in_the_joined_form() {
        let mut draw = Draw(3);
        for _ in 0..100 {
            let mut base = form();
            let monomials = Arc::clone(&base.monomials);
            for polynomial in &mut base.states {
                *polynomial = self::polynomial(&monomials, &mut draw, [1.0, 1.0, 0.1, 0.01]);
            }
            let cut = 0.5 * draw.next();
            let mut part = |lo: f64, hi: f64| {
                let place = Interval::new(lo, hi).unwrap();
                let mut form = base.clone();
                form.narrow(&[place, Interval::symmetric(1.0)]);
                for polynomial in &mut form.states {
                    let more = self::polynomial(&monomials, &mut draw, [1e-3; 4]);
                    for (x, more) in polynomial.iter_mut().zip(more) {
                        *x += more;
                    }
                }
                (form, place)
            };
            let parts = [part(cut, 1.0), part(-1.0, cut)];
            let shares = parts
                .each_ref()
                .map(|(form, place)| (form, Share::of(*place)));
            let joined = base.joined(0, &shares).unwrap();
            let rest = joined.frame.hull();
            for (form, place) in &parts {
                let (middle, radius) = place.mid_rad();
                for _ in 0..20 {
                    let own = [draw.next(), draw.next(), 0.0, 0.0];
                    let at = [middle + radius * own[0], own[1], 0.0, 0.0];
                    for state in 0..2 {
                        let there = value(&monomials, &form.states[state], &own);
                        let near = value(&monomials, &joined.states[state], &at);
                        let rest = rest[state].inflate(1e-13);
                        assert!(rest.contains(there - near), "{there} {near} {rest}");
                    }
                }
            }
            // Terms of the first that are small in its narrow part are larger in the other.
            assert!(rest.iter().all(|x| x.mag() < 0.5), "{rest:?}");
        }
    }

    /// Parts of parts are where they say: three slices of a function that bends where they meet.
    #[test]
    fn parts_of_parts_are_in_the_joined_form() {
        let mut draw = Draw(4);
        let (mut checks, mut nearest) = (0, f64::INFINITY);
        for _ in 0..100 {
            let mut base = form();
            let monomials = Arc::clone(&base.monomials);
            for polynomial in &mut base.states {
                *polynomial = self::polynomial(&monomials, &mut draw, [1.0, 1.0, 0.1, 0.01]);
            }
            let steep = 0.1 * draw.next();
            let part = |form: &Form, lo: f64, hi: f64| {
                let place = Interval::new(lo, hi).unwrap();
                let mut form = form.clone();
                form.narrow(&[place, Interval::symmetric(1.0)]);
                (form, place)
            };
            let bent = |mut form: Form, factor: f64| {
                let linear = monomials.linear(0);
                for polynomial in &mut form.states {
                    // Grows from where the part before ends.
                    polynomial[linear] += factor;
                    polynomial[0] += factor;
                }
                form
            };
            let (first, own) = part(&base, -1.0, 0.6 * draw.next());
            let (rest, others) = part(&base, own.hi(), 1.0);
            let (second, middle) = part(&rest, -1.0, 0.6 * draw.next());
            let (third, last) = part(&rest, middle.hi(), 1.0);
            let whole = Share::WHOLE;
            let mut parts = [
                (first, whole.part(own)),
                (bent(second, 0.5 * steep), whole.part(others).part(middle)),
                (bent(third, steep), whole.part(others).part(last)),
            ];
            parts[0].0.signs = vec![Signs::POSITIVE, Signs::NEGATIVE];
            parts[1].0.signs = vec![Signs::ZERO, Signs::NEGATIVE];
            parts[2].0.signs = vec![Signs::POSITIVE];
            let joined = base.joined(0, &parts.each_ref().map(|(form, share)| (form, *share)));
            let joined = joined.unwrap();
            // Of what one of them does not tell nothing is known.
            assert_eq!(joined.signs, [Signs::POSITIVE.or(Signs::ZERO)]);
            let rest = joined.frame.hull();
            for (form, share) in &parts {
                assert!(share.off > 0.0 && share.off < 1e-14, "{share:?}");
                for _ in 0..20 {
                    let own = [draw.next(), draw.next(), 0.0, 0.0];
                    let at = [share.middle + share.radius * own[0], own[1], 0.0, 0.0];
                    for (state, rest) in rest.iter().enumerate() {
                        let there = value(&monomials, &form.states[state], &own);
                        let near = value(&monomials, &joined.states[state], &at);
                        let bound = rest.inflate(1e-13);
                        assert!(bound.contains(there - near), "{there} {near} {bound}");
                        let room = (there - near - rest.lo())
                            .abs()
                            .min((rest.hi() - there + near).abs());
                        nearest = nearest.min(room / rest.width());
                        checks += 1;
                    }
                }
            }
            assert!(
                rest.iter().all(|x| x.mag() < 2.0 * steep.abs() + 1e-9),
                "{rest:?} {steep}"
            );
        }
        assert!(
            checks > 10_000 && nearest < 0.02,
            "the bound is not idle: {nearest}"
        );
    }

    /// Where a polynomial that grows with the new unknown is zero.
    #[test]
    fn zeros_are_found() {
        let mut draw = Draw(8);
        let mut seen = 0;
        for _ in 0..200 {
            let form = form();
            let monomials = &*form.monomials;
            let mut decider = polynomial(monomials, &mut draw, [0.0, 0.3, 0.005, 0.001]);
            decider[1] = 1.0;
            let turn = Turn::new(&form, &decider).unwrap();
            // About the new unknown less a level.
            let mut values = polynomial(monomials, &mut draw, [0.0, 0.01, 0.01, 0.0]);
            let level = 1.2 * draw.next();
            for (a, x) in values.iter_mut().enumerate() {
                *x += turn.tau[a] - if a == 0 { level } else { 0.0 };
            }
            let off = 1e-3 * draw.next().abs();
            let zeros = turn.zeros(monomials, &values, off);
            for _ in 0..200 {
                let at = [draw.next(), draw.next(), 0.0, 0.0];
                let (tau, value) = (
                    value(monomials, &turn.tau, &at),
                    value(monomials, &values, &at),
                );
                if value.abs() <= off {
                    assert!(zeros.inflate(1e-14).contains(tau), "{tau} {zeros}");
                    seen += 1;
                }
                assert!(value < off || tau >= zeros.lo() - 1e-14, "{tau} {zeros}");
                assert!(value > -off || tau <= zeros.hi() + 1e-14, "{tau} {zeros}");
            }
            assert!(zeros.width() < 0.2 || level.abs() > 0.9, "{zeros} {level}");
        }
        assert!(seen > 10, "{seen}");
    }
}
