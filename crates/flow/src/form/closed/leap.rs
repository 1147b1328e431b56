//! A form moves by the closed form, as far as the right-hand side is certain.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, matrices `n * n`; a walk begins with a place"
)]

use std::sync::Arc;

use super::super::frame::Frame;
use super::super::journey::{Acting, Journey};
use super::super::outward::raised;
use super::super::set::{Form, ParamForm};
use super::super::step::{Arrival, Obstacle};
use super::super::surfaces::Signs;
use super::chain::{Chain, During};
use super::linear::{Drive, Linear};
use super::value::{Matrix, Value, image, product};
use veribound_interval::Interval;
use veribound_model::ExprId;

/// Times are told apart up to this power of one half of the time to go, where a sign may change.
const FINEST: usize = 12;

/// Bounds during a window may be wider than what both its ends say, by this share of the width met so far, and besides by
/// this share of the size of a state; the second ones where there are many windows, with what is the size of a state
/// beside the others.
const WIDER: [f64; 2] = [0.02, 0.1];
const NOTHING: [f64; 2] = [1e-11, 1e-3];

/// So many windows are many, and so many a leap has at most.
const MANY: usize = 256;
const MOST: usize = 4096;

/// The leap ends so much before the first solution may meet a surface, as share of the time that all take.
const SLACK: f64 = 0.4;

/// Exponentials that are kept.
const KEPT: usize = 12;

/// Exponentials that were met.
#[derive(Default)]
pub(in super::super) struct Chains(Vec<(Key, Arc<Chain>)>);

/// What an exponential depends on.
#[derive(PartialEq)]
struct Key {
    rates: Vec<ExprId>,
    signs: Vec<Signs>,
    length: f64,
    steering: Vec<Interval>,
    params: Vec<ParamForm>,
}

/// Solutions on their way.
#[derive(Clone)]
struct Place {
    /// Time since the start, in shortest levels.
    at: u64,
    /// The states of those that start in the polynomials, and their velocities with inputs in the middle.
    states: Vec<Value>,
    velocity: Vec<Value>,
    /// How deviations are moved.
    map: Vec<Interval>,
    /// How far inputs have moved them besides.
    apart: Vec<f64>,
}

/// All solutions during a window of time.
struct Window {
    tube: Vec<Interval>,
    velocity: Vec<Interval>,
    /// The hull of both its ends.
    ends: Vec<Interval>,
    /// Where they are at its end.
    end: Place,
}

/// What the windows of one leap share.
struct Leap<'a> {
    form: &'a Form,
    chain: &'a Chain,
    drive: Drive,
    /// What dependence could not keep.
    rest: Vec<Interval>,
}

impl Leap<'_> {
    /// Where all solutions start.
    fn start(&self) -> Place {
        let states = self.form.states.iter();
        let states: Vec<Value> = states.map(|x| Value::of(x.clone(), 0.0)).collect();
        let n = states.len();
        let identity = (0..n * n).map(|k| Interval::point(f64::from(u8::from(k % (n + 1) == 0))));
        Place {
            at: 0,
            velocity: self.velocity(&states),
            states,
            map: identity.collect(),
            apart: vec![0.0; n],
        }
    }

    /// `A x + g` with inputs in the middle.
    fn velocity(&self, states: &[Value]) -> Vec<Value> {
        let moved = self.chain.slopes.applied(states, &self.form.monomials);
        let both = moved.iter().zip(&self.drive.middle);
        both.map(|(x, g)| x.plus(g)).collect()
    }

    /// From `place` on, after the time of a level.
    fn after(&self, place: &Place, number: usize) -> Place {
        let level = &self.chain.levels[number];
        let applied = |matrix: &Matrix, x: &[Value]| matrix.applied(x, &self.form.monomials);
        // What has decayed is not the difference of two large numbers, and what hardly moves is not their sum.
        let steps = applied(&level.integral, &place.velocity);
        let decayed = applied(&level.flow, &place.states);
        let driven = applied(&level.integral, &self.drive.middle);
        let parts = place
            .states
            .iter()
            .zip(&steps)
            .zip(decayed.iter().zip(&driven));
        let states = parts.map(|((x, step), (decayed, driven))| {
            let (moved, sum) = (x.plus(step), decayed.plus(driven));
            if moved.radius() <= sum.radius() {
                moved
            } else {
                sum
            }
        });
        let states: Vec<Value> = states.collect();
        let gathered = self.chain.gathered(number, &self.drive.spread).into_iter();
        let apart = level.carried(&place.apart).into_iter().zip(gathered);
        Place {
            at: place.at + (1 << number),
            velocity: self.velocity(&states),
            states,
            map: product(self.rest.len(), &level.end, &place.map),
            apart: apart.map(|(x, more)| sum(x, more)).collect(),
        }
    }

    /// Deviations from those that start in the polynomials.
    fn deviation(&self, place: &Place) -> Vec<Interval> {
        let moved = image(self.rest.len(), &place.map, &self.rest);
        let both = moved.iter().zip(&place.apart);
        both.map(|(x, apart)| *x + Interval::symmetric(*apart))
            .collect()
    }

    /// The window of one level from `place` to `end`.
    fn window(&self, place: &Place, number: usize, end: Place) -> Window {
        let level = &self.chain.levels[number];
        let gathered = self.chain.gathered(number, &self.drive.spread);
        let (mut tube, mut speeds, rest) = self.during(place, &level.during, &gathered);
        let ends = hulls(&place.states).into_iter().zip(hulls(&end.states));
        let mut ends: Vec<(Interval, Interval)> = ends.collect();
        let deviations = self.deviation(place).into_iter().zip(self.deviation(&end));
        for (i, (before, after)) in deviations.enumerate() {
            // What moves one way stays between its ends.
            if speeds[i].lo() >= 0.0 || speeds[i].hi() <= 0.0 {
                tube[i] = tube[i].intersect(ends[i].0.hull(ends[i].1));
            }
            tube[i] += rest[i];
            ends[i] = (ends[i].0 + before, ends[i].1 + after);
        }
        let ends = ends.iter().map(|(from, to)| from.hull(*to)).collect();
        self.disturb(&mut speeds, &rest);
        Window {
            tube,
            velocity: speeds,
            ends,
            end,
        }
    }

    /// Solutions that start in the polynomials, and their velocities, both with inputs in the middle; and how far all
    /// others can be from them.
    fn during(
        &self,
        place: &Place,
        during: &During,
        gathered: &[f64],
    ) -> (Vec<Interval>, Vec<Interval>, Vec<Interval>) {
        let velocity = hulls(&place.velocity);
        let states = hulls(&place.states).into_iter();
        let tube = states.zip(during.moves(&velocity));
        let rest = during.carry(&self.deviation(place)).into_iter();
        (
            tube.map(|(x, moved)| x + moved).collect(),
            during.carry(&velocity),
            rest.zip(gathered)
                .map(|(x, more)| x + Interval::symmetric(*more))
                .collect(),
        )
    }

    /// What dependence could not keep after some windows, less a vector, where inputs are uncertain: what each window adds is
    /// turned by those that follow, instead of put into one box.
    fn by_windows(&self, numbers: &[usize]) -> Option<(Frame, Vec<f64>)> {
        let spread = &self.drive.spread;
        if numbers.len() < 2 || spread.iter().all(|x| *x == 0.0) {
            return None;
        }
        let mut frame = self.form.frame.clone();
        let mut shift = vec![0.0; spread.len()];
        for &number in numbers {
            let level = &self.chain.levels[number];
            let before: Vec<Interval> = shift.iter().map(|x| Interval::point(*x)).collect();
            let offset = image(spread.len(), &level.end, &before);
            let (moved, next) = frame.moved(&level.end, &offset);
            let gathered = self.chain.gathered(number, spread).into_iter();
            let more: Vec<Interval> = gathered.map(Interval::symmetric).collect();
            (frame, shift) = (moved.completed(&more), next);
        }
        Some((frame, shift))
    }

    /// Adds to velocities what deviations and inputs do to them.
    fn disturb(&self, velocity: &mut [Interval], rest: &[Interval]) {
        let by_rest = image(rest.len(), &self.chain.steep, rest);
        let more = by_rest.iter().zip(&self.drive.spread);
        for (v, (x, spread)) in velocity.iter_mut().zip(more) {
            *v += *x + Interval::symmetric(*spread);
        }
    }

    /// The tube and the velocity during `off` seconds from `place` on, which is less than the shortest level.
    fn shortly(&self, place: &Place, off: f64) -> (Vec<Interval>, Vec<Interval>) {
        let during = self.chain.short(off);
        // |exp(A r)| at all times, so long.
        let rows = during.flow.chunks_exact(self.rest.len());
        let gathered = rows.map(|row| {
            let parts = row.iter().zip(&self.drive.spread);
            let all: f64 = parts.map(|(a, x)| a.mag() * x).sum();
            if all == 0.0 {
                0.0
            } else {
                raised(off * all, row.len() + 2)
            }
        });
        let gathered: Vec<f64> = gathered.collect();
        let (tube, mut speeds, rest) = self.during(place, &during, &gathered);
        self.disturb(&mut speeds, &rest);
        let tube = tube.into_iter().zip(rest).map(|(x, rest)| x + rest);
        (tube.collect(), speeds)
    }
}

/// An upper bound of the sum of two numbers that are not negative.
fn sum(a: f64, b: f64) -> f64 {
    if a == 0.0 && b == 0.0 {
        return 0.0;
    }
    raised(a + b, 1)
}

fn hulls(values: &[Value]) -> Vec<Interval> {
    values.iter().map(Value::hull).collect()
}

impl Journey<'_> {
    /// Moves the form by the closed form to the end of the stretch, or to a time before something that is watched
    /// may change its sign; `None` where it cannot be moved that way, else whether another leap may follow.
    pub(in super::super) fn leap(&mut self, acting: &Acting) -> Result<Option<bool>, Obstacle> {
        let Some(landing) = self.landing(acting) else {
            return Ok(None);
        };
        for tube in &landing.tubes {
            let outputs = self.outputs_on(tube, self.inputs());
            self.proved.pass(&outputs, acting.regime.modes);
        }
        let goes_on = landing.end == Reached::Somewhere;
        if let Some(frame) = landing.frame {
            self.form.frame = frame;
        }
        match landing.end {
            Reached::Whole => {
                self.land(acting, landing.arrival, self.left)?;
                self.left = Interval::ZERO;
            }
            _ => self.land(acting, landing.arrival, landing.moved)?,
        }
        Ok(Some(goes_on))
    }

    fn landing(&mut self, acting: &Acting) -> Option<Landing> {
        let linear = self.flow.linear(&acting.regime)?;
        let inputs = self.inputs();
        let length = self.left.mid();
        let off = (self.left - Interval::point(length)).mag();
        let chain = self.chain(acting, &linear, length)?;
        let leap = Leap {
            form: &self.form,
            chain: &chain,
            drive: linear.drive(&self.form, inputs)?,
            rest: self.form.frame.hull(),
        };
        if off > chain.levels[0].length {
            return None;
        }
        let n = leap.rest.len();
        let steady = acting.steady(inputs);
        let certain = |tube: &[Interval]| self.is_certain(acting, &steady, tube);
        let mut walk = Walk::new(&leap);
        let mut reached = walk.go(&certain);
        let mut last = walk.places.len() - 1;
        let mut more = vec![0.0; n];
        if reached == Reached::Whole && off > 0.0 {
            // The end is not known better than that.
            let (tube, velocity) = leap.shortly(&walk.places[last], off);
            if certain(&tube) {
                let count = if off <= walk.lengths[last - 1] {
                    1
                } else {
                    last
                };
                let before = walk.velocities[last - count..last].iter();
                for (i, more) in more.iter_mut().enumerate() {
                    let speeds = before.clone().map(|v| v[i].mag());
                    *more = raised(off * speeds.fold(velocity[i].mag(), f64::max), 1);
                }
                walk.tubes.push(tube);
            } else {
                reached = Reached::Sign;
            }
        }
        if reached == Reached::Sign {
            let met = walk.places[last].at;
            let slack = SLACK * self.crossing_time(acting, &leap, &walk.places[last]);
            let unit = chain.levels[0].length;
            last = (0..=last).rev().find(|place| {
                let at = walk.places[*place].at;
                (met - at) as f64 * unit >= slack && at < 1 << chain.halvings
            })?;
            if last == 0 {
                return None;
            }
            walk.tubes.truncate(last);
        }
        let by_windows = leap.by_windows(&walk.numbers[..last]);
        let is_whole = reached == Reached::Whole && last > 1;
        let at_once = chain.levels.get(chain.halvings).filter(|_| is_whole);
        let place = match at_once {
            Some(_) => leap.after(&walk.places[0], chain.halvings),
            None => walk.places[last].clone(),
        };
        let unit = Interval::point(chain.levels[0].length);
        let moved = Interval::point(place.at as f64) * unit;
        // Both contain all there is.
        let direct = leap.deviation(&place);
        let by_windows = by_windows.filter(|(frame, _)| {
            let both = frame.hull().into_iter().zip(direct);
            let shares = both.map(|(a, b)| a.width() / (b.width() + 1e-300));
            shares.sum::<f64>() < n as f64
        });
        let (place, more) = match by_windows {
            Some(_) => {
                let map = leap.start().map;
                (Place { map, ..place }, more)
            }
            None => {
                let both = place.apart.iter().zip(&more);
                let more = both.map(|(apart, off)| sum(*apart, *off)).collect();
                (place, more)
            }
        };
        let gone = (reached, moved);
        let mut landing = Landing::new(&self.form, place, &more, walk.tubes, gone)?;
        if let Some((frame, shift)) = by_windows {
            landing.arrival.lows = shift;
            landing.frame = Some(frame);
        }
        Some(landing)
    }

    /// Whether all that is watched keeps its sign, or moves towards it, on a tube.
    fn is_certain(&self, acting: &Acting, steady: &[bool], tube: &[Interval]) -> bool {
        if acting.regime.watches.is_empty() {
            return true;
        }
        let quantities = self.quantities(tube, self.inputs());
        let Some(found) = acting.piece.on_box(&quantities) else {
            return false;
        };
        let watched = found.watched.iter().zip(steady);
        watched
            .zip(&acting.regime.watches)
            .all(|(([value, rate], steady), watch)| {
                let keeps = |x: Interval| Signs::strict(x) == Some(watch.sign);
                keeps(*value) || (*steady && keeps(*rate))
            })
    }

    /// About the time in which all solutions pass what is watched and next to change its sign.
    fn crossing_time(&self, acting: &Acting, leap: &Leap<'_>, place: &Place) -> f64 {
        let states = hulls(&place.states).into_iter().zip(leap.deviation(place));
        let states: Vec<Interval> = states.map(|(x, rest)| x + rest).collect();
        let quantities = self.quantities(&states, self.inputs());
        let Some(found) = acting.piece.on_box(&quantities) else {
            return 0.0;
        };
        let nearest = found.watched.iter().min_by(|a, b| {
            let ahead = |[value, rate]: &[Interval; 2]| value.mig() / (rate.mag() + 1e-300);
            ahead(a).total_cmp(&ahead(b))
        });
        nearest.map_or(0.0, |[value, rate]| value.width() / (rate.mag() + 1e-300))
    }

    /// The exponential of a regime over so many seconds.
    fn chain(&mut self, acting: &Acting, linear: &Linear, length: f64) -> Option<Arc<Chain>> {
        let inputs = self.inputs();
        let steering: Vec<Interval> = linear.steering.iter().map(|u| inputs[*u]).collect();
        if steering.iter().any(|u| !u.is_point()) {
            return None;
        }
        let key = Key {
            rates: acting.regime.rates.clone(),
            signs: acting.regime.signs.clone(),
            length,
            steering,
            params: self.form.params.clone(),
        };
        if let Some((_, known)) = self.chains.0.iter().find(|known| known.0 == key) {
            return Some(Arc::clone(known));
        }
        let slopes = linear.matrix(&self.form, inputs)?;
        let chain = Arc::new(Chain::new(slopes, length, &self.form.monomials)?);
        if self.chains.0.len() >= KEPT {
            self.chains.0.remove(0);
        }
        self.chains.0.push((key, Arc::clone(&chain)));
        Some(chain)
    }
}

/// How far a leap goes.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reached {
    /// To the end of the stretch.
    Whole,
    /// To a time before something may change its sign.
    Sign,
    /// Through as many windows as it has.
    Somewhere,
}

/// Where a leap ends.
struct Landing {
    arrival: Arrival,
    tubes: Vec<Vec<Interval>>,
    /// What dependence could not keep, where it has been moved already.
    frame: Option<Frame>,
    end: Reached,
    /// The time, if it is not the whole stretch.
    moved: Interval,
}

impl Landing {
    /// `None` if a number is too large.
    fn new(
        form: &Form,
        place: Place,
        more: &[f64],
        tubes: Vec<Vec<Interval>>,
        (end, moved): (Reached, Interval),
    ) -> Option<Landing> {
        let count = form.monomials.len();
        let (states, radii): (Vec<_>, Vec<f64>) =
            place.states.iter().map(|x| x.parts(count)).unzip();
        let more = radii
            .iter()
            .zip(more)
            .map(|(radius, more)| match radius + more {
                0.0 => Interval::ZERO,
                sum => Interval::symmetric(raised(sum, 2)),
            });
        let more: Vec<Interval> = more.collect();
        let mut during = vec![Interval::EMPTY; states.len()];
        for tube in &tubes {
            for (whole, x) in during.iter_mut().zip(tube) {
                *whole = whole.hull(*x);
            }
        }
        let are_bounded = more.iter().chain(&during).all(|x| x.is_bounded());
        let are_known = !place.states.iter().any(Value::is_lost);
        (are_bounded && are_known).then(|| Landing {
            arrival: Arrival {
                lows: vec![0.0; states.len()],
                map: place.map,
                states,
                more,
                during,
            },
            tubes,
            frame: None,
            end,
            moved,
        })
    }
}

/// From window to window.
struct Walk<'a> {
    leap: &'a Leap<'a>,
    /// Where solutions are before each window and after the last; what holds during each.
    places: Vec<Place>,
    tubes: Vec<Vec<Interval>>,
    velocities: Vec<Vec<Interval>>,
    lengths: Vec<f64>,
    /// The levels of the windows.
    numbers: Vec<usize>,
    /// The hull of all tubes.
    whole: Vec<Interval>,
}

impl<'a> Walk<'a> {
    fn new(leap: &'a Leap<'a>) -> Walk<'a> {
        Walk {
            leap,
            places: vec![leap.start()],
            tubes: Vec::new(),
            velocities: Vec::new(),
            lengths: Vec::new(),
            numbers: Vec::new(),
            whole: vec![Interval::EMPTY; leap.rest.len()],
        }
    }

    /// Goes to the end, or to the last time known before a tube is not `certain`.
    ///
    /// Proof. While the right-hand side acts, solutions lie in the tube of the window; there it is certain. So there is
    /// no first time in the window at which it ends to act.
    fn go(&mut self, certain: &dyn Fn(&[Interval]) -> bool) -> Reached {
        let chain = self.leap.chain;
        let end = 1_u64 << chain.halvings;
        let top = chain.levels.len() - 1;
        let lowest = chain.halvings.saturating_sub(FINEST).min(top);
        let mut number = top;
        while self.places.len() <= MOST {
            let place = &self.places[self.places.len() - 1];
            if place.at >= end {
                return Reached::Whole;
            }
            while !place.at.is_multiple_of(1 << number) || place.at + (1 << number) > end {
                number -= 1;
            }
            let level = &chain.levels[number];
            let end = self.place(place.at + (1 << number), top);
            let window = self.leap.window(place, number, end);
            let is_certain = certain(&window.tube);
            if !is_certain && number <= lowest {
                return Reached::Sign;
            }
            let is_narrow = number == 0 || self.is_narrow(&window);
            if !is_certain || !is_narrow {
                number -= 1;
                continue;
            }
            for (whole, x) in self.whole.iter_mut().zip(&window.tube) {
                *whole = whole.hull(*x);
            }
            self.places.push(window.end);
            self.tubes.push(window.tube);
            self.velocities.push(window.velocity);
            self.lengths.push(level.length);
            self.numbers.push(number);
            number = (number + 1).min(top);
        }
        Reached::Somewhere
    }

    /// The place at some time, by the longest level that its number is a multiple of: so errors are not moved
    /// from window to window, but by as few levels as its number has digits.
    ///
    /// The place before was met: if it were inside of a window, so would be the time asked for, since windows begin at
    /// multiples of their lengths.
    fn place(&self, at: u64, top: usize) -> Place {
        let number = top.min(at.trailing_zeros() as usize);
        let before = at - (1 << number);
        let met = self.places.partition_point(|place| place.at < before);
        self.leap.after(&self.places[met], number)
    }

    /// Whether its tube is hardly wider than both ends say.
    fn is_narrow(&self, window: &Window) -> bool {
        let are_many = self.places.len() > MANY;
        let (wider, nothing) = (WIDER[usize::from(are_many)], NOTHING[usize::from(are_many)]);
        let known = self.whole.iter().zip(&window.ends);
        let known: Vec<Interval> = known.map(|(whole, ends)| whole.hull(*ends)).collect();
        let weights = &self.leap.chain.sizes.weights;
        let sizes = known.iter().zip(weights).map(|(x, w)| x.mag() / w);
        let size = if are_many {
            sizes.fold(0.0, f64::max)
        } else {
            0.0
        };
        let parts = window
            .tube
            .iter()
            .zip(&window.ends)
            .zip(known.iter().zip(weights));
        let mut parts = parts.map(|((tube, ends), (known, weight))| {
            let size = known.mag().max(size * weight);
            tube.width() - ends.width() <= wider * known.width() + nothing * size
        });
        parts.all(|narrow| narrow)
    }
}
