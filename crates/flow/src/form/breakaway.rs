//! Sets that rest on a surface and leave it while samples pass: solutions break away in stretches of their own.
//!
//! Where a pull and the friction it has to overcome change from sample to sample only, solutions leave when a stretch begins, those
//! with little friction first. Each stretch parts those that still rest:
//!
//! 1. What decides is the sign of a rate of change on the surface, a polynomial in the unknowns. Where it is zero at about one value of one
//!    unknown, whatever the others are, that unknown tells the parts: those that stay, those that leave, and the *border* in between.
//! 2. The border creeps (`creeping.rs`) until the inputs of a stretch tell where it goes. It is so near to those that leave that both become one form
//!    then. Where those that leave do not move alike, as with much damping, they go on in slices, each twice as wide as the one nearer to the border.
//! 3. Once all have left, in a few stretches, they become one form again (`merging.rs`): what solutions have gained by leaving earlier is nearly
//!    a function of the unknown. Where there may be so many parts they stay divided, and so they do where some rest for longer.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, unknowns by their positions, surfaces in the order of their list"
)]

use super::creeping::Creep;
use super::journey::Journey;
use super::merging::Share;
use super::outward::raised;
use super::parting::{CLEAR, Portion, Undecided, ends};
use super::passing::Passing;
use super::range::range;
use super::regime::Regime;
use super::set::Form;
use super::surfaces::Signs;
use veribound_interval::Interval;

/// Sets are divided where they rest only while there are fewer parts: it is worth it where solutions meet again later, and each part
/// goes all the way.
const AT_REST: usize = 8;

/// Solutions that leave in more stretches do not become one form.
const MOST: usize = 24;

/// What becomes one form at a sample takes so many multiplications of polynomials.
const SAMPLE: f64 = 8.0;

/// Whether all leave is asked of so large a share of those that stay, which do so for the longest, and takes so many multiplications of
/// polynomials.
const LAST: f64 = 1.0 / 64.0;
const OUTLOOK: f64 = 16.0;

/// The border of those that leave a rest is at least and at most so wide a share of one unknown.
const BORDER: f64 = 1.0 / 16_384.0;
const BROAD: f64 = 1.0 / 256.0;

/// Those that leave are cut in slices, each so much wider than the one nearer to the border, where they do not move alike.
const DOUBLE: f64 = 2.0;

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

/// Where one unknown parts those that stay from those that leave.
struct Divided {
    unknown: usize,
    /// Between these values.
    stays: (f64, f64),
    leaves: (f64, f64),
    /// The end, on the side of those that leave, of what is not told.
    border: f64,
    leaves_above: bool,
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
    gone: Leavers,
    passing: Passing,
}

/// Those that leave in one stretch.
#[derive(Clone)]
struct Leavers {
    /// All of them, before.
    all: Form,
    /// The unknown that tells them apart.
    unknown: usize,
    /// The border is the last one.
    slices: Vec<Gone>,
    /// Where those of the border would stand.
    creep: Option<Creep>,
}

/// Those that left in one stretch on their way, and which part of the whole they are.
struct OnTheWay<'a> {
    all: Form,
    unknown: usize,
    slices: Vec<(Journey<'a>, Share)>,
    share: Share,
}

impl OnTheWay<'_> {
    /// Goes on to the next sample.
    async fn go_on(&mut self, passing: &mut Passing) -> Option<()> {
        for (journey, _) in &mut self.slices {
            let end = journey.go_to_sample(passing).await?;
            passing.at(end);
        }
        // Where all of them move, the border is too thin to be seen.
        if let [_, (border, _)] = &self.slices[..]
            && border.creep.is_none()
        {
            let form = self.form()?;
            self.slices.truncate(1);
            let (journey, share) = &mut self.slices[0];
            (journey.form, *share) = (form, Share::WHOLE);
        }
        Some(())
    }

    /// All of them.
    fn form(&self) -> Option<Form> {
        match &self.slices[..] {
            [(journey, _)] => Some(journey.form.clone()),
            slices => {
                let slices = slices
                    .iter()
                    .map(|(journey, share)| (&journey.form, *share));
                joined(&self.all, self.unknown, slices)
            }
        }
    }
}

/// Slices as one form.
fn joined<'a>(
    all: &Form,
    unknown: usize,
    slices: impl Iterator<Item = (&'a Form, Share)>,
) -> Option<Form> {
    let mut form = all.joined(unknown, &slices.collect::<Vec<_>>())?;
    form.settle().ok()?;
    Some(form)
}

/// Those that left in one stretch, and which part of the whole they are.
type Gone = (Form, Share);

impl<'a> Journey<'a> {
    /// Takes a form that rests when a stretch begins to where all its solutions have left the surface, each in a stretch of its own, as one form or
    /// as parts, if there may be so many; or divides it into those that stay and those that leave in this stretch. `None`, and nothing is
    /// changed, if neither is proved.
    pub(super) async fn break_away(&mut self, undecided: &Undecided) -> Option<()> {
        if self.is_border {
            return None;
        }
        self.spend(OUTLOOK).await;
        let divided = self.form.divided(undecided)?;
        let surface = undecided.open.surface;
        // Where some rest on, all are only moved on if the set may be divided.
        let may_all_leave = self.may_all_leave(&divided, surface);
        if !may_all_leave && self.may_part < 2 {
            return None;
        }
        let parted = self.parted(divided).await?;
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
        let all_gone = match may_all_leave {
            true => self.all_break_away(&parted, surface).await,
            false => None,
        };
        if let Some((mut samples, gone)) = all_gone {
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
        let left = &parted.gone;
        let slices = left.slices.iter().map(|(form, share)| (form, *share));
        let mut form = joined(&left.all, left.unknown, slices)?;
        form.options = options;
        let mut gone = self.fork(portion(form.clone()));
        gone.pass_samples(vec![parted.passing], form);
        self.parts = vec![self.fork(portion(parted.stay)), gone];
        Some(())
    }

    /// Whether those that rest for the longest leave in one of the next stretches: a hint.
    fn may_all_leave(&self, divided: &Divided, surface: usize) -> bool {
        let (near, far) = match divided.leaves_above {
            true => (divided.stays.1, divided.stays.0),
            false => divided.stays,
        };
        let ends = (far, far + LAST * (near - far));
        let Some((last, _)) = self.form.between(divided.unknown, ends) else {
            return false;
        };
        let mut last = self.beside(last);
        (self.current..self.until.min(self.current + MOST)).any(|stretch| {
            let inputs = |stretch: usize| &self.stretches[stretch].inputs;
            let is_new = stretch == self.current || inputs(stretch) != inputs(stretch - 1);
            last.enter(stretch);
            let leaves = |regime: Regime| regime.signs[surface] != Signs::ZERO;
            is_new && last.regime().is_ok_and(leaves)
        })
    }

    /// Takes those that leave a rest at the begin of the stretch at hand to its end.
    async fn parted(&self, divided: Divided) -> Option<Parted> {
        let (whole, v) = (&self.form, divided.unknown);
        let (stay, stays) = whole.between(v, divided.stays)?;
        let (mut all, leaves) = whole.between(v, divided.leaves)?;
        // Fresh unknowns stay what they are.
        all.options.absorb = f64::INFINITY;
        // The border within those that leave, and how far the others are from its end, at most.
        let (centre, radius) = leaves.mid_rad();
        let cut = (divided.border - centre) / radius;
        let outward = if divided.leaves_above { 1.0 } else { -1.0 };
        let (thin, wide) = (1.0 + outward * cut, 1.0 - outward * cut);
        let mut passing = Passing::new(whole.states.len());
        let slice = (&all, v);
        let mut together = passing.clone();
        let others = self
            .moved(slice, &mut together, (cut, outward), false)
            .await;
        // One right-hand side was certain all the way, unless boxes were asked.
        let mut slices = match others.filter(|(journey, _)| journey.workspace.is_none()) {
            Some(others) => {
                passing = together;
                vec![others]
            }
            // The nearer to the border, the slower they are at first: speeds of one slice compare.
            None => {
                let between = ends(thin, wide, Some(DOUBLE));
                let between = between.into_iter().map(|far| cut + outward * far);
                let edges = [cut].into_iter().chain(between).chain([outward]);
                let edges: Vec<f64> = edges.collect();
                let mut slices = Vec::with_capacity(edges.len());
                for edges in edges.windows(2) {
                    let edges = (edges[0], edges[1]);
                    slices.push(self.moved(slice, &mut passing, edges, false).await?);
                }
                slices
            }
        };
        let border = (-outward, cut);
        slices.push(self.moved(slice, &mut passing, border, true).await?);
        let creep = slices
            .last_mut()
            .and_then(|(border, _)| border.creep.take());
        let slices = slices
            .into_iter()
            .map(|(journey, share)| (journey.form, share));
        Some(Parted {
            unknown: v,
            stays,
            leaves,
            stay,
            gone: Leavers {
                slices: slices.collect(),
                all,
                unknown: v,
                creep,
            },
            passing,
        })
    }

    /// Those of `all` for whom an unknown lies between these ends, at the end of the stretch at hand.
    async fn moved(
        &self,
        (all, unknown): (&Form, usize),
        passing: &mut Passing,
        ends: (f64, f64),
        is_border: bool,
    ) -> Option<(Journey<'a>, Share)> {
        let (form, place) = all.between(unknown, ends)?;
        let mut journey = self.beside(form);
        journey.is_border = is_border;
        if is_border {
            journey.creep_from_rest();
        }
        let end = journey.go_to_sample(passing).await?.to_vec();
        passing.at(&end);
        Some((journey, Share::of(place)))
    }

    /// The way to the end of the stretch in which the last solutions leave, if they leave in few stretches; and there the forms of those that left in
    /// the same stretch.
    async fn all_break_away(
        &self,
        first: &Parted,
        surface: usize,
    ) -> Option<(Vec<Passing>, Vec<Gone>)> {
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
        let mut gone: Vec<OnTheWay<'_>> = Vec::new();
        let mut samples = Vec::new();
        for stretch in self.current..self.until.min(self.current + MOST) {
            let mut passing = Passing::new(self.form.states.len());
            for part in &mut gone {
                part.go_on(&mut passing).await?;
            }
            let parted = match resting.regime() {
                _ if stretch == self.current => Some(first.clone()),
                Ok(_) => None,
                Err(undecided) => {
                    let divided = resting.form.divided(&undecided?)?;
                    Some(resting.parted(divided).await?)
                }
            };
            if let Some(parted) = parted {
                if parted.unknown != v {
                    return None;
                }
                let own = &parted.passing;
                passing.at(&own.hull);
                passing.through(&own.tube, own.modes, own.steps);
                let left = parted.gone;
                let slices = left.slices.iter();
                let slices = slices.map(|(form, share)| (beside(form, stretch + 1), *share));
                let mut slices: Vec<_> = slices.collect();
                if let Some((border, _)) = slices.last_mut() {
                    border.is_border = true;
                    border.creep = left.creep;
                }
                gone.push(OnTheWay {
                    all: left.all,
                    unknown: left.unknown,
                    slices,
                    share: share.part(parted.leaves),
                });
                share = share.part(parted.stays);
                resting = beside(&parted.stay, stretch);
            }
            let is_last = resting.regime().ok()?.signs[surface] != Signs::ZERO;
            let end = resting.go_to_sample(&mut passing).await?;
            passing.at(end);
            if is_last {
                samples.push(passing);
                let mut forms = Vec::with_capacity(gone.len() + 1);
                for part in &gone {
                    forms.push((part.form()?, part.share));
                }
                forms.push((resting.form, share));
                return Some((samples, forms));
            }
            self.spend(SAMPLE).await;
            if self.meet.is_some() {
                let forms = gone.iter().map(OnTheWay::form);
                let forms = forms.collect::<Option<Vec<_>>>()?;
                let shares = gone.iter().map(|part| part.share);
                let all = forms.iter().zip(shares).chain([(&resting.form, share)]);
                let all: Vec<_> = all.collect();
                passing.copy = Some((self.form.joined(v, &all)?, None));
            }
            samples.push(passing);
        }
        None
    }
}

impl Form {
    /// Where the unknown that decides parts those that stay from those that leave.
    fn divided(&self, undecided: &Undecided) -> Option<Divided> {
        let open = &undecided.open;
        let way = undecided.way?;
        let zeros = self.zeros_along(&open.polynomial, open.off)?;
        let (lo, hi) = (zeros.lo, zeros.hi);
        let leaves_above = (way == Signs::POSITIVE) == zeros.grows;
        let (stays, leaves, border) = if leaves_above {
            ((-1.0, lo), (lo, 1.0), hi)
        } else {
            ((hi, 1.0), (-1.0, hi), lo)
        };
        Some(Divided {
            unknown: zeros.unknown,
            stays,
            leaves,
            border,
            leaves_above,
        })
    }

    /// The part in which an unknown lies between two numbers of the unit interval, and where that is.
    fn between(&self, v: usize, (from, to): (f64, f64)) -> Option<(Form, Interval)> {
        let mut unit = vec![Interval::symmetric(1.0); self.unknowns.len()];
        unit[v] = Interval::new(from.min(to), from.max(to))?;
        let mut form = self.clone();
        form.narrow(&unit);
        Some((form, unit[v]))
    }

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
