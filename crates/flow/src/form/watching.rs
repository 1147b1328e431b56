//! How long what is watched along a prepared step keeps its sign.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: blocks own `monomials * stride` numbers; probes and watches have the same order"
)]

use super::monomials::Monomials;
use super::outward::{UNIT, raised};
use super::piece::{Piece, Probe};
use super::range::{at_corner, is_above, range};
use super::step::Scratch;
use super::surfaces::Signs;
use veribound_interval::Interval;

/// Times are told apart up to this share of a step.
const FINEST: f64 = 1.0 / 64.0;

/// What rounding can take from a value, as share of all its terms.
const ROUNDED: f64 = 1e-13;

/// The end of the time during which everything watched keeps its sign.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trouble {
    /// In scaled time.
    pub(super) from: f64,
    /// Position of the watch.
    pub(super) watch: usize,
}

/// What is known of a register during a window.
enum Course {
    /// Its values lie in this interval.
    Within(Interval),
    /// They may be told better.
    Near(Near),
}

/// A register is at `(p(δ) + c) / s` up to `off` and `rounding` of `p`, with a polynomial `p`, some `c` of `change` and `s > 0` of `scale`.
struct Near {
    begin: Vec<f64>,
    rounding: f64,
    change: Interval,
    scale: Interval,
    off: f64,
    /// And in this interval.
    within: Interval,
}

/// A look for the first time up to `end` at which one watch may change its sign, window by window.
///
/// Guarantee: before it, for all solutions within the deviation of the prepared step, the watched
/// expression has its sign or moves towards it; one that is not `steady`, a function of the state
/// alone, has its sign.
pub(super) struct Search<'a> {
    place: (&'a Piece, &'a Scratch, &'a Monomials),
    watch: usize,
    sign: Signs,
    steady: bool,
    /// Until here there is none.
    from: f64,
    /// The next window,
    length: f64,
    /// which is twice as long again once both halves of one were safe.
    is_second: bool,
    end: f64,
}

/// What a window tells.
pub(super) enum Look {
    /// More have to be looked at.
    Open,
    /// There is no such time.
    Calm,
    /// It is this one, in scaled time.
    Trouble(f64),
}

impl<'a> Search<'a> {
    pub(super) fn new(
        place: (&'a Piece, &'a Scratch, &'a Monomials),
        (watch, sign, steady): (usize, Signs, bool),
        end: f64,
    ) -> Search<'a> {
        Search {
            place,
            watch,
            sign,
            steady,
            from: 0.0,
            length: end,
            is_second: false,
            end,
        }
    }

    /// Looks at one more window.
    pub(super) fn look(&mut self) -> Look {
        if self.from >= self.end {
            return Look::Calm;
        }
        let to = if self.from + self.length >= self.end {
            self.end
        } else {
            self.from + self.length
        };
        if self.is_safe(to) {
            self.from = to;
            self.length *= if self.is_second { 2.0 } else { 1.0 };
            self.is_second = !self.is_second;
        } else if self.length <= FINEST * self.end {
            return Look::Trouble(self.from);
        } else {
            self.length *= 0.5;
            self.is_second = false;
        }
        if self.from >= self.end {
            Look::Calm
        } else {
            Look::Open
        }
    }

    fn is_safe(&self, to: f64) -> bool {
        let (piece, scratch, monomials) = self.place;
        let (from, sign) = (self.from, self.sign);
        let window = Interval::new(from, to).unwrap_or(Interval::ENTIRE);
        let keeps = |register: usize| {
            // What tells it at all times spares the rest.
            if let Some(own) = Signs::strict(scratch.around(register)) {
                return own == sign;
            }
            let loses = |time| piece.loses(scratch, monomials, (register, sign), time);
            !loses(to) && !loses(from) && piece.keeps(scratch, monomials, (register, sign), window)
        };
        let probe = &piece.probes[self.watch];
        keeps(probe.value) || (self.steady && keeps(probe.rate))
    }
}

impl Piece {
    /// Whether one watch keeps its sign, or moves towards it, until `end`; as of [`Search`].
    pub(super) fn is_calm(
        &self,
        place: (&Scratch, &Monomials),
        (watch, sign, steady): (usize, Signs, bool),
        end: f64,
    ) -> bool {
        let probe = &self.probes[watch];
        let loses = |register: usize| self.loses(place.0, place.1, (register, sign), end);
        if loses(probe.value) && (!steady || loses(probe.rate)) {
            return false;
        }
        let mut search = Search::new((self, place.0, place.1), (watch, sign, steady), end);
        loop {
            match search.look() {
                Look::Open => {}
                Look::Calm => return true,
                Look::Trouble(_) => return false,
            }
        }
    }

    /// Whether bounds of a register at a time can only fail to have this sign, since they contain the value that some solution has there,
    /// with all that is not known of it. It proves nothing, and spares work.
    fn loses(
        &self,
        scratch: &Scratch,
        monomials: &Monomials,
        (register, sign): (usize, Signs),
        time: f64,
    ) -> bool {
        let top = scratch.errors.sizes[register].top;
        let stride = scratch.series.stride;
        let way = if sign == Signs::POSITIVE { 1.0 } else { -1.0 };
        let mut size = 0.0;
        let rows = scratch.series.block(register).chunks_exact(stride);
        let now = rows.map(|row| {
            let (mut value, mut all) = (0.0, 0.0);
            for x in row[..=top].iter().rev() {
                value = value * time + way * x;
                all = all * time + x.abs();
            }
            size += all;
            value
        });
        let now: Vec<f64> = now.collect();
        at_corner(monomials, &now) + ROUNDED * size < scratch.radii[1][register]
    }

    /// Encloses a register during a window of scaled time, for all solutions within the deviation.
    pub(super) fn during(
        &self,
        scratch: &Scratch,
        monomials: &Monomials,
        register: usize,
        window: Interval,
    ) -> Interval {
        match self.course(scratch, monomials, register, window) {
            Course::Within(found) => found,
            Course::Near(near) => {
                let begin = range(monomials, &near.begin).inflate(near.rounding);
                let all = ((begin + near.change) / near.scale).inflate(near.off);
                all.intersect(near.within)
            }
        }
    }

    /// Whether a register is proved to have this sign during a window, as [`Piece::during`] tells it.
    fn keeps(
        &self,
        scratch: &Scratch,
        monomials: &Monomials,
        (register, sign): (usize, Signs),
        window: Interval,
    ) -> bool {
        match self.course(scratch, monomials, register, window) {
            Course::Within(found) => Signs::strict(found) == Some(sign),
            Course::Near(near) => {
                let Near {
                    mut begin,
                    rounding,
                    change,
                    scale,
                    off,
                    ..
                } = near;
                if sign == Signs::NEGATIVE {
                    begin.iter_mut().for_each(|x| *x = -*x);
                }
                let least = rounding + change.mag() + off * scale.hi();
                is_above(monomials, &begin, raised(least, 4))
            }
        }
    }

    /// What is known of a register during a window of scaled time, for all solutions within the deviation.
    ///
    /// Proof. `R(δ, t)` is the polynomial. For any number `κ`, `q = (1 + κ (t - t_0)) R` has `q' = (R' + κ R) + κ (t - t_0) R'`. So
    /// where all coefficients decay alike, as what is left of a small rate does, `q` hardly moves from what it is at the begin `t_0`, and that
    /// is a polynomial in the unknowns alone, with a tight range.
    fn course(
        &self,
        scratch: &Scratch,
        monomials: &Monomials,
        register: usize,
        window: Interval,
    ) -> Course {
        let size = &scratch.errors.sizes[register];
        let quick = scratch.around(register);
        if !quick.contains(0.0) {
            return Course::Within(quick);
        }
        let stride = scratch.series.stride;
        let block = scratch.series.block(register);
        let off = scratch.radii[1][register];
        if size.top == 0 {
            return Course::Near(Near {
                begin: block.iter().step_by(stride).copied().collect(),
                rounding: 0.0,
                change: Interval::ZERO,
                scale: Interval::ONE,
                off,
                within: quick,
            });
        }
        let orders = |a: usize| &block[a * stride..=a * stride + size.top];
        let rows = (0..monomials.len()).map(|a| on(orders(a).iter().copied(), window));
        let rows: Vec<Interval> = rows.collect();
        let others: f64 = rows[1..].iter().map(|row| row.mag()).sum();
        let first = rows[0];
        let found = first
            .inflate(raised(others + off, monomials.len() + 1))
            .intersect(quick);
        if !found.contains(0.0) || first.contains(0.0) {
            return Course::Within(found);
        }
        let slope = |a: usize| {
            let orders = orders(a).iter().enumerate().skip(1);
            on(orders.map(|(j, x)| j as f64 * x), window)
        };
        let decay = Interval::point((-slope(0) / first).mid());
        let since = window - Interval::point(window.lo());
        let scale = Interval::ONE + decay * since;
        if scale.lo() <= 0.0 {
            return Course::Within(found);
        }
        let (mut begin, mut rounding) = (Vec::with_capacity(monomials.len()), 0.0);
        let (mut change, mut moved) = (0.0, 0.0);
        for (a, row) in rows.iter().enumerate() {
            let value = on(orders(a).iter().copied(), Interval::point(window.lo()));
            begin.push(value.mid());
            rounding += value.rad();
            let slope = slope(a);
            change += (slope + decay * *row).mag();
            moved += slope.mag();
        }
        let moved = Interval::symmetric(raised(moved, monomials.len())) * decay * since;
        Course::Near(Near {
            begin,
            rounding: raised(rounding, monomials.len()),
            change: moved.inflate(raised(change, monomials.len())) * since,
            scale,
            off,
            within: found,
        })
    }

    /// The slopes of a watched expression, at all times of the step.
    pub(super) fn slopes_of(&self, scratch: &Scratch, probe: &Probe) -> Vec<Interval> {
        let mut slopes = vec![Interval::ZERO; self.states];
        for &(state, register) in &probe.gradient {
            slopes[state] = scratch.around(register);
        }
        slopes
    }
}

/// Encloses `Σ c_j t^j` for all times `t` of a window, where each coefficient given may have been rounded once.
///
/// Proof. Bounds go through Horner's rule: the least and the largest of products with both ends of the window, which change by at most `|t|` times
/// what the bounds before them are off. So rounding takes no more than where all terms add up in absolute value (Higham 2002, section 5.1): with
/// `n` coefficients the share `2 n + 2` roundings of `Σ |c_j| |t|^j`, and two more for what computing that takes.
fn on(coefficients: impl DoubleEndedIterator<Item = f64>, window: Interval) -> Interval {
    let (from, to, most) = (window.lo(), window.hi(), window.mag());
    let (mut lo, mut hi, mut size, mut count) = (0.0_f64, 0.0_f64, 0.0, 0);
    for x in coefficients.rev() {
        (lo, hi) = if from >= 0.0 {
            // Two of the four products below decide.
            let (low, high) = (
                if lo < 0.0 { to } else { from },
                if hi < 0.0 { from } else { to },
            );
            (lo * low + x, hi * high + x)
        } else {
            let (a, b, c, d) = (lo * from, lo * to, hi * from, hi * to);
            (a.min(b).min(c.min(d)) + x, a.max(b).max(c.max(d)) + x)
        };
        size = size * most + x.abs();
        count += 1;
    }
    let off = raised((2 * count + 4) as f64 * UNIT * size, 4 * count + 4);
    Interval::new(lo, hi).map_or(Interval::ENTIRE, |all| all.inflate(off))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::form::draw::Draw;

    /// Values at exact times are inside, by interval arithmetic, and bounds are about as near as interval arithmetic has them.
    #[test]
    fn polynomials_in_time_are_enclosed() {
        let mut draw = Draw(17);
        for _ in 0..2000 {
            let count = 1 + (8.0 * (1.0 + draw.next())) as usize;
            let scale = f64::powi(10.0, (20.0 * draw.next()) as i32);
            let list: Vec<f64> = (0..count).map(|_| scale * draw.next()).collect();
            let (a, b) = (draw.next(), draw.next());
            let b = if draw.next() > 0.6 { a } else { b };
            let window = Interval::new(a.min(b), a.max(b)).unwrap();
            let exactly = |t: Interval| {
                let all = list.iter().rev();
                all.fold(Interval::ZERO, |sum, x| sum * t + Interval::point(*x))
            };
            let found = on(list.iter().copied(), window);
            for share in [0.0, 0.3, 0.8, 1.0] {
                let time = (window.lo() + share * window.width()).min(window.hi());
                let value = exactly(Interval::point(time));
                assert!(value.mid() >= found.lo() && value.mid() <= found.hi());
                assert!(found.hi() >= value.lo() && found.lo() <= value.hi());
            }
            let all = exactly(window);
            assert!(found.inflate(1e-15 * scale).hi() >= all.hi());
            let size: f64 = list.iter().map(|x| x.abs()).sum();
            assert!(found.width() <= all.width() * (1.0 + 1e-12) + 1e-13 * size);
        }
    }

    /// What interval arithmetic makes of a point is enclosed, too.
    #[test]
    fn what_horner_s_rule_rounds_is_told() {
        let mut draw = Draw(3);
        for _ in 0..2000 {
            let list: Vec<f64> = (0..12).map(|_| draw.next()).collect();
            let time = draw.next();
            let point = Interval::point(time);
            let exact = list.iter().rev();
            let exact = exact.fold(Interval::ZERO, |sum, x| sum * point + Interval::point(*x));
            let found = on(list.iter().copied(), point);
            assert!(exact.is_subset_of(found), "{exact} {found}");
        }
    }

    /// What is left of a small rate decays: the bound that knows it is inside of the plain one, and contains every solution's value.
    #[test]
    fn a_decaying_rate_keeps_its_sign() {
        let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.05, 2.35]\nparams.k = [1, 3]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
        let model = veribound_model::Model::from_text("decay.toml", text).unwrap();
        let flow = crate::form::Flow::new(&model);
        let (start, params) = ([model.states[0].init], [model.params[0].bounds]);
        let form = flow.start(&start, &params, crate::form::FormOptions::default());
        let regime = flow.resolve(None, &[]).unwrap();
        let mut acting = crate::form::journey::Acting::new(&flow, regime, &form);
        let prepared = acting
            .prepare(&form, &[], Interval::point(0.2), 1e-9)
            .unwrap();
        let register = acting.piece.code.states[0];
        let (unit, span) = (prepared.unit, prepared.bounds.span);
        assert!(acting.scratch.around(register).contains(0.0));
        let (mut draw, mut told) = (Draw(5), 0);
        for _ in 0..200 {
            let (a, b) = (
                0.5 * (1.0 + draw.next()) * span,
                0.5 * (1.0 + draw.next()) * span,
            );
            let window = Interval::new(a.min(b), a.max(b)).unwrap();
            let found = acting
                .piece
                .during(&acting.scratch, &form.monomials, register, window);
            told += usize::from(found.lo() > 0.0);
            for x in [start[0].lo(), 1.0, start[0].hi()] {
                for k in [params[0].lo(), 2.0, params[0].hi()] {
                    for t in [window.lo(), window.hi()] {
                        let value = x * (-k * t * unit).exp();
                        assert!(found.inflate(1e-12).contains(value), "{found} {value}");
                    }
                }
            }
        }
        assert!(told > 50, "the bound is idle: {told}");
    }
}
