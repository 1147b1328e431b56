//! Sets that rest on a surface and leave it while samples pass: solutions break away in stretches of their own.
//!
//! Where a pull and the friction it has to overcome change from sample to sample only, solutions leave when a stretch begins, those
//! with little friction first. Each stretch parts those that still rest:
//!
//! 1. What decides is the sign of a rate of change on the surface, a polynomial in the unknowns. Where it is zero at about one value of one
//!    unknown, whatever the others are, that unknown tells the parts: those that stay, those that leave, and the *border* in between.
//! 2. The border creeps (`creeping.rs`). At the end of the stretch it is so near to those that leave that both become one form.
//! 3. Once all have left, in a few stretches, they become one form again (`merging.rs`): what solutions have gained by leaving earlier is nearly
//!    a function of the unknown. Where there may be so many parts they stay divided, and so they do where some rest for longer.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, unknowns by their positions, surfaces in the order of their list"
)]

use super::journey::Journey;
use super::merging::Share;
use super::outward::raised;
use super::parting::{Portion, Undecided};
use super::passing::Passing;
use super::range::range;
use super::set::Form;
use super::surfaces::Signs;
use veribound_interval::Interval;

/// Sets are divided where they rest only while there are fewer parts: it is worth it where solutions meet again later, and each part
/// goes all the way.
const AT_REST: usize = 8;

/// Solutions that leave in more stretches do not become one form.
const MOST: usize = 24;

/// The border of those that leave a rest is at least and at most so wide a share of one unknown.
const BORDER: f64 = 1.0 / 16_384.0;
const BROAD: f64 = 1.0 / 256.0;

/// The border is so much wider than what is not known of the values.
const CLEAR: f64 = 16.0;

/// Where a polynomial can be zero.
struct Zeros {
    /// Along this unknown,
    unknown: usize,
    /// between these two values of it.
    lo: f64,
    hi: f64,
    /// Whether the polynomial grows with it.
    grows: bool,
}

/// Solutions of a form that rest when a stretch begins, and those that leave in it.
#[derive(Clone)]
struct Parted {
    /// What tells them apart, and where.
    unknown: usize,
    stays: Interval,
    leaves: Interval,
    /// Those that stay, at the begin of the stretch.
    stay: Form,
    /// Those that leave, at its end, and what happened to them on the way.
    gone: Form,
    passing: Passing,
}

/// Those that left in one stretch, and which part of the whole they are.
type Gone = (Form, Share);

impl Journey<'_> {
    /// Takes a form that rests when a stretch begins to where all its solutions have left the surface, each in a stretch of its own, as one form or
    /// as parts, if there may be so many; or divides it into those that stay and those that leave in this stretch. `None`, and nothing is
    /// changed, if neither is proved.
    pub(super) fn break_away(&mut self, undecided: &Undecided) -> Option<()> {
        if self.is_border {
            return None;
        }
        let parted = self.parted(undecided)?;
        let surface = undecided.open.surface;
        let portion = |form: Form| Portion {
            form,
            is_border: false,
        };
        let options = self.form.options;
        let released = |mut form: Form| {
            form.options = options;
            // What began at a point has its widths by now.
            form.choose_order();
            form.settle().ok().map(|()| form)
        };
        if let Some((mut samples, gone)) = self.all_break_away(&parted, surface) {
            if gone.len() > self.may_part || self.others + gone.len() > AT_REST {
                let all: Vec<_> = gone.iter().map(|(form, share)| (form, *share)).collect();
                let form = released(self.form.joined(parted.unknown, &all)?)?;
                self.pass_samples(samples, form);
                return Some(());
            }
            let mut parts = Vec::with_capacity(gone.len());
            for (form, _) in gone {
                let form = released(form)?;
                let mut part = self.fork(portion(form.clone()));
                part.pass_samples(samples.clone(), form);
                parts.push(part);
                samples.iter_mut().for_each(|sample| sample.steps = 0);
            }
            self.parts = parts;
            return Some(());
        }
        if self.may_part < 2 || self.others + 1 >= AT_REST {
            return None;
        }
        let mut gone = self.fork(portion(parted.gone.clone()));
        gone.pass_samples(vec![parted.passing], parted.gone);
        self.parts = vec![self.fork(portion(parted.stay)), gone];
        Some(())
    }

    /// Divides the form, at rest at the begin of the stretch at hand, and takes those that leave to its end.
    fn parted(&self, undecided: &Undecided) -> Option<Parted> {
        let (whole, open) = (&self.form, &undecided.open);
        let way = undecided.way?;
        let zeros = whole.zeros_along(&open.polynomial, open.off)?;
        let (v, lo, hi) = (zeros.unknown, zeros.lo, zeros.hi);
        let leaves_above = (way == Signs::POSITIVE) == zeros.grows;
        let (stays, leaves) = if leaves_above {
            ((-1.0, lo), (lo, 1.0))
        } else {
            ((hi, 1.0), (-1.0, hi))
        };
        let part = |form: &Form, (lo, hi): (f64, f64)| {
            let mut unit = vec![Interval::symmetric(1.0); form.unknowns.len()];
            unit[v] = Interval::new(lo, hi)?;
            let mut form = form.clone();
            form.narrow(&unit);
            Some((form, unit[v]))
        };
        let (stay, stays) = part(whole, stays)?;
        let (mut all, leaves) = part(whole, leaves)?;
        // Fresh unknowns stay what they are.
        all.options.absorb = f64::INFINITY;
        // The border within those that leave.
        let (centre, radius) = leaves.mid_rad();
        let (outer, inner) = if leaves_above {
            let cut = (hi - centre) / radius;
            ((cut, 1.0), (-1.0, cut))
        } else {
            let cut = (lo - centre) / radius;
            ((-1.0, cut), (cut, 1.0))
        };
        let mut passing = Passing::new(whole.states.len());
        let mut moved = |ends: (f64, f64), is_border: bool| {
            let (form, place) = part(&all, ends)?;
            let mut journey = self.beside(form);
            journey.is_border = is_border;
            if is_border {
                journey.creep_from_rest();
            }
            let end = journey.go_to_sample(&mut passing)?.to_vec();
            passing.at(&end);
            Some((journey.form, Share::of(place)))
        };
        let parts = [moved(outer, false)?, moved(inner, true)?];
        let mut gone = all.joined(v, &parts.each_ref().map(|(form, share)| (form, *share)))?;
        gone.options = whole.options;
        gone.settle().ok()?;
        Some(Parted {
            unknown: v,
            stays,
            leaves,
            stay,
            gone,
            passing,
        })
    }

    /// The way to the end of the stretch in which the last solutions leave, if they leave in few stretches; and there the forms of those that left in
    /// the same stretch.
    fn all_break_away(&self, first: &Parted, surface: usize) -> Option<(Vec<Passing>, Vec<Gone>)> {
        let v = first.unknown;
        let beside = |form: &Form, stretch: usize| {
            let mut form = form.clone();
            form.options.absorb = f64::INFINITY;
            let mut journey = self.beside(form);
            journey.enter(stretch);
            journey
        };
        let mut resting = beside(&self.form, self.current);
        let mut share = Share::WHOLE;
        let mut gone = Vec::new();
        let mut samples = Vec::new();
        for stretch in self.current..self.until.min(self.current + MOST) {
            let mut passing = Passing::new(self.form.states.len());
            for (journey, _) in &mut gone {
                let end = Journey::go_to_sample(journey, &mut passing)?;
                passing.at(end);
            }
            let parted = match resting.regime() {
                _ if stretch == self.current => Some(first.clone()),
                Ok(_) => None,
                Err(undecided) => Some(resting.parted(&undecided?)?),
            };
            if let Some(parted) = parted {
                if parted.unknown != v {
                    return None;
                }
                let own = &parted.passing;
                passing.at(&own.hull);
                passing.through(&own.tube, own.modes, own.steps);
                let journey = beside(&parted.gone, stretch + 1);
                gone.push((journey, share.part(parted.leaves)));
                share = share.part(parted.stays);
                resting = beside(&parted.stay, stretch);
            }
            let is_last = resting.regime().ok()?.signs[surface] != Signs::ZERO;
            let end = resting.go_to_sample(&mut passing)?;
            passing.at(end);
            if is_last {
                samples.push(passing);
                gone.push((resting, share));
                let forms = gone
                    .into_iter()
                    .map(|(journey, share)| (journey.form, share));
                return Some((samples, forms.collect()));
            }
            if self.meet.is_some() {
                let all = gone.iter().map(|(journey, share)| (&journey.form, *share));
                let all: Vec<_> = all.chain([(&resting.form, share)]).collect();
                passing.copy = Some((self.form.joined(v, &all)?, None));
            }
            samples.push(passing);
        }
        None
    }
}

impl Form {
    /// Where along one unknown a polynomial can be zero, up to `off`, if that is at about one value of it whatever the others are.
    fn zeros_along(&self, polynomial: &[f64], off: f64) -> Option<Zeros> {
        let monomials = &*self.monomials;
        let slope = |v: usize| polynomial[monomials.linear(v)];
        let v =
            (0..self.unknowns.len()).max_by(|a, b| slope(*a).abs().total_cmp(&slope(*b).abs()))?;
        let grows = slope(v) > 0.0;
        let on = |lo: f64, hi: f64| {
            let (middle, radius) = Interval::new(lo, hi)?.mid_rad();
            let mut part = polynomial.to_vec();
            let lost = monomials.substitute(&mut part, v, middle, radius);
            let values = range(monomials, &part).inflate(raised(off + lost, 1));
            Some(if grows { values } else { -values })
        };
        let (mut below, mut above) = (-1.0, 1.0);
        while above - below > 0.1 * BORDER {
            let middle = 0.5 * (below + above);
            let middle_is_above = on(middle, middle)?.mid() > 0.0;
            *(if middle_is_above {
                &mut above
            } else {
                &mut below
            }) = middle;
        }
        let mut border = BORDER.max(CLEAR * off / slope(v).abs());
        while border < BROAD {
            let (lo, hi) = (below - border, above + border);
            if lo <= -1.0 || hi >= 1.0 {
                return None;
            }
            if on(-1.0, lo)?.hi() < 0.0 && on(hi, 1.0)?.lo() > 0.0 {
                return Some(Zeros {
                    unknown: v,
                    lo,
                    hi,
                    grows,
                });
            }
            border *= 4.0;
        }
        None
    }
}
