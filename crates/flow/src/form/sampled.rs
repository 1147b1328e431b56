//! All solutions cross a surface, each in a stretch with inputs of its own.
//!
//! When a set takes several samples to cross (`crossing.rs`), inputs are levels that differ from stretch to stretch, and not any
//! function in their hull. So all solutions go on as if there were no surface, stretch by stretch with the inputs there are. Those that
//! meet it in one of the stretches are taken across in that one, and go on from there on their own:
//! every such form is true for the unknowns of these solutions alone. Once all have crossed, the forms become one (`merging.rs`).
//!
//! 1. What is watched is a function `e` of the state that falls along the right-hand side (or grows; here it falls) at all times, also
//!    beyond the surface. So a solution has crossed by a sample if and only if `e <= 0` there, on its way as if there were no surface.
//! 2. In one stretch the lemma of `crossing.rs` is used for unknowns whose solutions cross in it. The times computed there are
//!    *later* than the crossings, by more than they can be off: so no solution has to be followed from before the stretch. They can be after
//!    its end by as little; then a solution is at its end where it would be some moments later, up to that many moments of its rates.
//! 3. The unknowns of solutions that cross in a stretch lie between two zeros of `e` at samples. In terms of about the time of the
//!    crossing, in place of one unknown, they are a slice of the unit box, with what is not known of its ends.
//!
//! As positions and speeds at a capture are continuous in the unknowns, and nearly smooth, so that the forms of one slice nearly fit to
//! the next, little is lost.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, probes and watches in the same order, samples in theirs"
)]

use super::ahead::around;
use super::crossing::Captured;
use super::journey::{Acting, Journey};
use super::merging::Slice;
use super::outward::raised;
use super::parting::Turn;
use super::passing::Passing;
use super::piece::Piece;
use super::set::Form;
use super::step::{End, Prepared};
use super::surfaces::Signs;
use crate::modes::ModeSet;
use veribound_interval::Interval;
use veribound_interval::round::add_up;

/// A crossing that takes more stretches is not divided.
const MOST: usize = 24;

/// What a stretch takes, and what all that have crossed by a sample take to be one form, in multiplications of polynomials.
const STRETCH: f64 = 24.0;
const SAMPLE: f64 = 8.0;

/// Steps are longer than their stretch by this share, for times of crossings that are too late.
const LONGER: f64 = 1.0 / 16.0;

/// A value as function of the unknowns, and how far it can be from that.
struct Value {
    polynomial: Vec<f64>,
    off: f64,
}

impl Value {
    fn hull(&self) -> Interval {
        around(&self.polynomial).inflate(self.off)
    }
}

/// All solutions at a sample on the way across.
struct Sample {
    /// As if none had crossed.
    ahead: Form,
    /// What is watched, with the sign it has before: there it is positive.
    value: Value,
    /// Those that have crossed, each with the number of the stretch they did it in.
    behind: Vec<(usize, Form)>,
    /// What is told of them.
    passing: Passing,
}

/// All solutions of a set at the end of a stretch.
struct Passed {
    ahead: Form,
    value: Value,
    during: Vec<Interval>,
    across: Option<Across>,
}

/// Those that crossed.
struct Across {
    form: Form,
    tube: Vec<Interval>,
    modes: ModeSet,
    /// About when, in seconds since the begin of the stretch.
    times: Vec<f64>,
    captured: Option<Captured>,
}

/// The way of all solutions across.
struct Way {
    samples: Vec<Sample>,
    /// About when they cross, in seconds, as a set that crosses in the middle tells it.
    times: Vec<f64>,
    captured: Option<Captured>,
}

impl Journey<'_> {
    /// Takes the form across the zero of a watched expression to the end of the stretch in which the last solution crosses, where inputs
    /// change in a window of so many `seconds`; `None`, and nothing is changed, if that is not proved.
    pub(super) async fn cross_by_samples(
        &mut self,
        acting: &mut Acting,
        watch: usize,
        seconds: f64,
    ) -> Option<()> {
        let (inputs, _) = self.window(seconds, 0.0)?;
        if inputs == self.inputs() || !acting.is_of_states(watch) {
            return None;
        }
        let mut way = self.all_across(acting, watch).await?;
        let turn = Turn::new(&self.form, &way.times).or_else(|| {
            let mut straight = way.times.clone();
            straight[1 + self.form.unknowns.len()..].fill(0.0);
            Turn::new(&self.form, &straight)
        })?;
        let monomials = &*self.form.monomials;
        let zeros: Vec<Interval> = way
            .samples
            .iter()
            .map(|sample| turn.zeros(monomials, &sample.value.polynomial, sample.value.off))
            .collect();
        let place = |number: usize| {
            let from = number.checked_sub(1).map_or(-1.0, |k| zeros[k].lo());
            Interval::new(from, zeros[number].hi())
        };
        let last = way.samples.len() - 1;
        for (number, sample) in way.samples.iter_mut().enumerate() {
            self.spend(SAMPLE).await;
            let mut slices = slices(&sample.behind, &place)?;
            let behind = slices.iter().map(|slice| (slice, &slice.form.signs));
            let ahead = Slice {
                form: &sample.ahead,
                place: Interval::new(zeros[number].lo(), 1.0)?,
            };
            let before = (number < last).then_some((&ahead, &acting.regime.signs));
            for (slice, signs) in behind.chain(before) {
                let mut hull = turn.hull(slice);
                self.clip(signs, &mut hull);
                sample.passing.at(&hull);
            }
            if self.meet.is_some() && number < last {
                let arriving = way
                    .captured
                    .map(|captured| captured.arriving(&sample.ahead));
                slices.push(ahead);
                sample.passing.copy = Some((turn.merged(&slices)?, arriving));
            }
        }
        let mut form = turn.merged(&slices(&way.samples[last].behind, &place)?)?;
        form.options = self.form.options;
        form.settle().ok()?;
        // Nothing fails from here on.
        let samples = way.samples.into_iter();
        self.pass_samples(samples.map(|sample| sample.passing).collect(), form);
        Some(())
    }

    /// The way across, stretch by stretch.
    async fn all_across(&self, acting: &mut Acting, watch: usize) -> Option<Way> {
        let mut ahead = self.form.clone();
        // Fresh unknowns stay what they are.
        ahead.options.absorb = f64::INFINITY;
        let mut across: Vec<(usize, Journey<'_>)> = Vec::new();
        let mut samples: Vec<Sample> = Vec::new();
        let mut times: Vec<Vec<f64>> = Vec::new();
        let mut captured = None;
        let mut since = 0.0;
        for number in 0..MOST.min(self.until - self.current) {
            let next = self.current + number + 1;
            let mut own = self.beside(ahead);
            if number > 0 {
                own.enter(next - 1);
            }
            let left = own.left;
            self.spend(STRETCH).await;
            let passed = own.in_stretch(acting, watch)?;
            let mut passing = Passing::new(passed.during.len());
            passing.through(&passed.during, acting.regime.modes, 1);
            for (_, journey) in &mut across {
                journey.go_to_sample(&mut passing).await?;
            }
            if let Some(found) = passed.across {
                passing.through(&found.tube, found.modes, 1);
                let mut list = found.times;
                list[0] += since;
                times.push(list);
                captured = found.captured;
                let mut journey = self.beside(found.form);
                journey.enter(next);
                across.push((number, journey));
            }
            let behind = across.iter();
            let behind = behind.map(|(number, journey)| (*number, journey.form.clone()));
            let is_last = Signs::strict(passed.value.hull()) == Some(Signs::NEGATIVE);
            ahead = passed.ahead;
            samples.push(Sample {
                ahead: ahead.clone(),
                value: passed.value,
                behind: behind.collect(),
                passing,
            });
            if is_last {
                let times = times.swap_remove(times.len() / 2);
                return Some(Way {
                    samples,
                    times,
                    captured,
                });
            }
            since += left.mid();
        }
        None
    }

    /// All solutions at the end of the stretch at hand: as if none had crossed, and those that have.
    fn in_stretch(&self, acting: &mut Acting, watch: usize) -> Option<Passed> {
        let (inputs, form) = (self.inputs(), &self.form);
        let asked = acting.regime.watches[watch];
        let longest = raised(self.left.hi() * (1.0 + LONGER), 2);
        let prepared = acting.prepare_seconds((form, form), inputs, longest)?;
        if !prepared.last {
            return None;
        }
        let speed = acting.speed_across(form, inputs, watch, prepared.bounds.span)?;
        let end = Piece::last(self.left, prepared.unit);
        let arrival = acting.piece.arrival(form, &acting.scratch, &prepared, &end);
        let mut arrival = arrival.ok()?;
        let during = arrival.during.clone();
        self.hold(&acting.regime, &mut arrival);
        let mut ahead = form.clone();
        arrival.land(&mut ahead);
        ahead.elapsed += self.left;
        let expr = self.flow.quantity(asked.expr);
        let (polynomial, off) = ahead.evaluate(&expr, inputs).ok()?;
        let value = Value {
            polynomial: match asked.sign {
                Signs::POSITIVE => polynomial,
                _ => polynomial.iter().map(|x| -x).collect(),
            },
            off,
        };
        let across = if Signs::strict(value.hull()) == Some(Signs::POSITIVE) {
            None
        } else {
            let mut across = self.across(acting, watch, (&prepared, speed))?;
            across.form.elapsed = ahead.elapsed;
            Some(across)
        };
        Some(Passed {
            ahead,
            value,
            during,
            across,
        })
    }

    /// Those solutions that cross in the stretch at hand, at its end.
    fn across(
        &self,
        acting: &Acting,
        watch: usize,
        (prepared, speed): (&Prepared, Interval),
    ) -> Option<Across> {
        let (inputs, form) = (self.inputs(), &self.form);
        let asked = acting.regime.watches[watch];
        let (unit, last) = (prepared.unit, prepared.bounds.span);
        let mut scaled = acting.times(form, watch, acting.root(watch, unit).0 / unit)?;
        let slopes = acting.slopes_of(watch);
        // How much later than the crossing a time is, in seconds.
        let late = |scaled: &[f64]| {
            let end = End::Own {
                scaled: scaled.to_vec(),
                last,
            };
            let arrival = acting.piece.arrival(form, &acting.scratch, prepared, &end);
            let arrival = arrival.ok()?;
            let deviation = arrival.deviation(&form.frame.hull());
            let left_over = acting.left_over(form, watch, scaled);
            let terms = slopes.iter().zip(&deviation);
            let off = terms.fold(left_over, |sum, (slope, d)| sum + *slope * *d);
            Some((arrival, deviation, left_over, off / speed))
        };
        let (.., about) = late(&scaled)?;
        scaled[0] += raised(2.0 * about.mag() / unit, 4) + 4.0 * f64::EPSILON * last;
        let (arrival, deviation, left_over, late) = late(&scaled)?;
        let apart = late.hi();
        if late.lo() <= 0.0 || add_up(self.left.hi(), apart) > last * unit {
            return None;
        }
        let passage = self.passage((acting, inputs), asked, (&arrival, &deviation), apart);
        let passage = passage.ok()?;
        if passage.leaving.is_some() {
            return None;
        }
        let landed = (&slopes[..], speed, left_over);
        let begin = self.landed((acting, inputs), &arrival, &passage, landed)?;
        let mut next = Acting::new(self.flow, passage.regime.clone(), &begin);
        let after = next.prepare_seconds((&begin, form), inputs, raised(self.left.hi(), 2))?;
        if !after.last || !next.lasts((&begin, inputs), &after, asked, &passage) {
            return None;
        }
        let place = self.late(
            (&next, &begin, &after),
            (&scaled, unit),
            self.left,
            (apart, &passage),
        )?;
        let before = passage.rates.iter().map(|r| raised(apart * r.mag(), 1));
        let tube = place.during.iter().zip(before);
        let tube = tube.map(|(x, before)| x.inflate(before)).collect();
        let mut form = place.of(&begin);
        form.signs.clone_from(&next.regime.signs);
        Some(Across {
            form,
            tube,
            modes: next.regime.modes,
            times: scaled.iter().map(|x| x * unit).collect(),
            captured: self.captured(asked, &passage),
        })
    }
}

/// Forms with the slices in which they are true.
fn slices<'a>(
    forms: &'a [(usize, Form)],
    place: &dyn Fn(usize) -> Option<Interval>,
) -> Option<Vec<Slice<'a>>> {
    let slice = |(number, form): &'a (usize, Form)| {
        let place = place(*number)?;
        Some(Slice { form, place })
    };
    forms.iter().map(slice).collect()
}
