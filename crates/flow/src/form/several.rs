//! One prepared step over several stretches.
//!
//! Samples are often so near to each other that a step could go much further. Where stretches in a row have the same
//! inputs, a step is prepared for all of them, and who is shown the form at the samples between gets it from there:
//! what is proved of a prepared step holds at all of its times, and inputs may be any measurable functions in bounds that
//! are the same. That goes on until somebody narrows the form; then what is left sets out anew.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: the stretch at hand is one of the list"
)]

use super::journey::{Acting, Journey};
use super::outward::raised;
use super::piece::Piece;
use super::set::Form;
use super::step::{Obstacle, Prepared};
use veribound_interval::Interval;

/// So many stretches at most.
const MOST: usize = 32;

/// Samples are told with what the whole step neglects: not more than this share of a state's width.
const NEGLIGIBLE: f64 = 1e-4;

/// Where a step over several is not certain, it is tried again after so many stretches at most.
const PATIENCE: usize = 64;

/// A prepared step that may reach over more stretches.
pub(super) struct Ahead {
    acting: Acting,
    prepared: Prepared,
    /// The form that set out.
    origin: Form,
    /// The form at the end of the last stretch, and the time until there.
    here: Form,
    since: Interval,
}

/// How many stretches a step is prepared for: a hint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Several {
    count: usize,
    /// So many stretches until it is tried again, and after the next failure.
    wait: usize,
    next_wait: usize,
}

impl Several {
    pub(super) fn new() -> Several {
        Several {
            count: 2,
            wait: 0,
            next_wait: 1,
        }
    }

    fn fail(&mut self) {
        self.count = 2;
        self.wait = self.next_wait;
        self.next_wait = PATIENCE.min(2 * self.next_wait);
    }
}

/// What a step that was tried for several stretches is good for.
pub(super) enum Reach {
    /// The first of them, and more.
    Several(Prepared),
    /// A part of the first.
    Less(Prepared),
}

impl Journey<'_> {
    /// A step from the begin of a stretch that is prepared for more than this one, where it is certain as far as it reaches.
    pub(super) fn prepare_several(&mut self, acting: &mut Acting) -> Option<Reach> {
        // Tubes and outputs would be those of all the time.
        let may = self.meet.is_some()
            && !self.tells_outputs
            && self.may_part < 2
            && self.flow.system.domain.is_none()
            && self.left == self.stretches[self.current].dt;
        if !may {
            return None;
        }
        if self.several.wait > 0 {
            self.several.wait -= 1;
            return None;
        }
        let inputs = self.inputs();
        let until = self.until.min(self.current + self.several.count);
        let same = self.stretches[self.current..until].iter();
        let same = same.take_while(|stretch| stretch.inputs == inputs);
        let (count, longest) = same.fold((0, Interval::ZERO), |(count, sum), stretch| {
            (count + 1, sum + stretch.dt)
        });
        if count < 2 {
            return None;
        }
        let prepared = acting.prepare(&self.form, inputs, longest, self.shortest());
        let Some(prepared) = prepared.ok() else {
            self.several.fail();
            return None;
        };
        if !prepared.covers(self.left) {
            self.several.fail();
            // What ends within the rounding of the stretch's end is not told to be before it.
            let is_less = prepared.bounds.span * prepared.unit < self.left.lo();
            return is_less.then_some(Reach::Less(prepared));
        }
        let steady = acting.steady(inputs);
        let place = (&acting.scratch, &*self.form.monomials);
        let span = prepared.bounds.span;
        let neglected = prepared.bounds.deviation.iter().zip(&self.form.states);
        let mut neglected = neglected.map(|(off, polynomial)| {
            let width: f64 = polynomial[1..].iter().map(|x| x.abs()).sum();
            *off <= NEGLIGIBLE * width
        });
        let mut watches = acting.regime.watches.iter().enumerate();
        let is_certain = neglected.all(|small| small)
            && watches.all(|(watch, asked)| {
                let asked = (watch, asked.sign, steady[watch]);
                acting.piece.is_calm(place, asked, span)
            });
        if !is_certain {
            self.several.fail();
            return None;
        }
        self.several.next_wait = 1;
        self.several.count = if prepared.last {
            MOST.min(2 * self.several.count)
        } else {
            count
        };
        Some(Reach::Several(prepared))
    }

    /// Goes to the end of the first stretch of a step that is prepared for several.
    pub(super) fn set_out(&mut self, acting: Acting, prepared: Prepared) -> Result<(), Obstacle> {
        let origin = self.form.clone();
        let since = self.left;
        let end = Piece::last(since, prepared.unit);
        self.arrive(&acting, &prepared, &end, since)?;
        self.keep_going((acting, prepared), origin, since);
        Ok(())
    }

    /// Goes to the end of the stretch at hand by a step that was prepared before it; `None` if that is not possible: then what acted
    /// goes on acting, where it still does.
    pub(super) fn go_ahead(&mut self, ahead: Ahead) -> Option<()> {
        let stretch = &self.stretches[self.current];
        let before = self.current.checked_sub(1);
        let same = before.is_some_and(|before| self.stretches[before].inputs == stretch.inputs);
        let since = ahead.since + stretch.dt;
        let may = same
            && self.left == stretch.dt
            && ahead.prepared.covers(since)
            && self.form.says_the_same(&ahead.here);
        let here = may.then(|| std::mem::replace(&mut self.form, ahead.origin.clone()));
        let arrived = here.and_then(|here| {
            self.form.tube.clone_from(&here.tube);
            let end = Piece::last(since, ahead.prepared.unit);
            let arrived = self.arrive(&ahead.acting, &ahead.prepared, &end, since);
            if arrived.is_err() {
                self.form = here;
                self.left = stretch.dt;
            }
            arrived.ok()
        });
        if arrived.is_none() {
            let acting = ahead.acting;
            let is_over = acting.regime.has_kinks || acting.depends_on_inputs();
            self.acting = (!is_over).then_some(acting);
            return None;
        }
        self.keep_going((ahead.acting, ahead.prepared), ahead.origin, since);
        Some(())
    }

    /// The form has arrived at the end of a stretch.
    fn keep_going(&mut self, step: (Acting, Prepared), origin: Form, since: Interval) {
        let (acting, prepared) = step;
        self.left = Interval::ZERO;
        self.form.step = prepared.next_step(origin.step);
        self.form.signs.clone_from(&acting.regime.signs);
        self.ahead = Some(Ahead {
            acting,
            prepared,
            origin,
            here: self.form.clone(),
            since,
        });
    }
}

impl Prepared {
    /// Whether it is possible for all this time.
    fn covers(&self, time: Interval) -> bool {
        raised(time.hi() / self.unit, 1) <= self.bounds.span
    }
}

impl Form {
    /// Whether it tells the same of solutions as another one on the way.
    fn says_the_same(&self, other: &Form) -> bool {
        self.unknowns == other.unknowns
            && self.states == other.states
            && self.params == other.params
            && self.frame == other.frame
            && self.signs == other.signs
            && self.within == other.within
    }
}
