//! Which balances to take: functions of time that cut off most of a region.
//!
//! At a point that nothing refutes a half-line to a vertex of what rows leave begins, and ends where a function refutes it: that one's row is the
//! next, until the vertex is refuted no more or does not move (Veinott 1967).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one view and one list of functions per track, one value per axis"
)]

use std::collections::BTreeSet;
use std::ops::Range;

use super::super::pass::contract;
use super::super::region::Region;
use super::super::rows::Rows;
use super::super::simplex::{Program, Side, deepest};
use super::said::{Posed, View, Window};
use super::track::{Choices, Track};
use veribound_interval::Interval;

/// A point that nothing refutes is looked for so often,
const MIDDLES: usize = 40;

/// and the border on the way from there to a vertex so often.
const STEPS: usize = 8;

/// An end is looked for no longer where a vertex brings less than this share of the region.
const WORTHWHILE: f64 = 2e-3;

/// Of all functions that refute a point so many are taken.
const BEST: usize = 8;

/// Functions are such that they refute a point also if states were known that much worse, the first of these shares where some do:
/// what refutes a point by little refutes no others.
const MARGINS: [f64; 3] = [0.5, 0.1, 0.0];

/// So many points of a region are refuted before a stop is taken to be where it is asked about,
const TRIALS: usize = 6;

/// and all stops are asked about so often.
const TRIMS: usize = 2;

/// Functions for a region, and their rows.
pub(super) struct Cuts<'a> {
    tracks: &'a [Track],
    /// Where stops of tracks may be.
    pub(super) choices: Vec<Choices>,
    views: Vec<View>,
    region: Region,
    whole: Vec<Interval>,
    /// What all functions say,
    pub(super) rows: Rows,
    /// and about how far from linear each row is in each axis.
    bents: Vec<Vec<f64>>,
    /// New functions, by track.
    pub(super) found: Vec<Vec<Window>>,
    /// The first of [`MARGINS`] that is tried: points that are asked about one after the other are refuted by about as much.
    level: usize,
}

impl Cuts<'_> {
    pub(super) fn of(tracks: &[Track], region: Region) -> Cuts<'_> {
        let axes = region.axes();
        let choices: Vec<Choices> = tracks.iter().map(Track::choices).collect();
        let pairs = tracks.iter().zip(&choices);
        let mut cuts = Cuts {
            tracks,
            views: pairs.map(|(track, own)| track.view(&region, own)).collect(),
            choices,
            region,
            whole: vec![Interval::symmetric(1.0); axes],
            rows: Rows::new(axes),
            bents: Vec::new(),
            found: tracks.iter().map(|_| Vec::new()).collect(),
            level: 0,
        };
        cuts.say();
        cuts
    }

    /// There are no such solutions: a row that no unknowns of the unit box satisfy.
    fn leave_nothing(&mut self) {
        let mut slopes = vec![0.0; self.region.axes()];
        if let Some(slope) = slopes.first_mut() {
            *slope = 1.0;
        }
        self.rows.push_outer(&slopes, Interval::point(2.0));
        self.bents.push(vec![0.0; self.region.axes()]);
    }

    /// What all functions say, anew.
    fn say(&mut self) {
        self.rows.truncate(0);
        self.bents.clear();
        for (position, track) in self.tracks.iter().enumerate() {
            for window in track.windows().iter().chain(&self.found[position]) {
                let at = (&self.region, &self.views[position]);
                let bent = track.say(window, at, &mut self.rows);
                self.bents.resize(self.rows.len(), bent);
            }
        }
        if self.tracks.iter().any(|track| track.is_refuted) {
            self.leave_nothing();
        }
    }

    /// Takes the best functions of those whose rows refute a point; whether there are any.
    fn refute(&mut self, point: &[f64]) -> bool {
        let pairs = self.tracks.iter().zip(&self.choices);
        let posed = pairs.map(|(track, own)| track.posed((&self.region, point), own, track.all()));
        let posed: Vec<Posed<'_>> = posed.collect();
        for (level, margin) in MARGINS.iter().enumerate().skip(self.level) {
            if self.refute_by((point, &posed), *margin) {
                self.level = level.saturating_sub(1);
                return true;
            }
        }
        self.level = 0;
        false
    }

    fn refute_by(&mut self, (point, posed): (&[f64], &[Posed<'_>]), margin: f64) -> bool {
        let mut all = Vec::new();
        for (position, (track, posed)) in self.tracks.iter().zip(posed).enumerate() {
            for window in posed.refuting(margin) {
                let mut rows = Rows::new(self.region.axes());
                let at = (&self.region, &self.views[position]);
                let bent = track.say(&window, at, &mut rows);
                let by = outside(&rows, point);
                if by > 0.0 {
                    all.push((by, position, window, rows, bent));
                }
            }
        }
        let is_refuted = !all.is_empty();
        let every: Vec<usize> = (0..self.region.axes()).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, position, window, rows, bent) in all.into_iter().take(BEST) {
            self.found[position].push(window);
            self.rows.take(&rows, &every, 0);
            self.bents.resize(self.rows.len(), bent);
        }
        is_refuted
    }

    /// Finds out, for all solutions with parameters in the region, where stops are.
    pub(super) fn trim(&mut self) {
        for _ in 0..TRIMS {
            let mut known = self.rows.clone();
            known.prune();
            let before = self.choices.clone();
            for track in 0..self.tracks.len() {
                for stop in 0..self.choices[track].len() {
                    self.trim_one(track, stop, &known);
                }
            }
            if self.choices == before {
                return;
            }
            let pairs = self.tracks.iter().zip(&self.choices);
            let views = pairs.map(|(track, own)| track.view(&self.region, own));
            self.views = views.collect();
            self.say();
            if self.choices.iter().flatten().any(Range::is_empty) {
                self.leave_nothing();
                return;
            }
        }
    }

    fn trim_one(&mut self, track: usize, stop: usize, known: &Rows) {
        let own = |choices: &[Choices]| choices[track][stop].clone();
        while let Some(first) = own(&self.choices).next()
            && !self.may_be(track, stop, first, known)
        {
            self.choices[track][stop].start = first + 1;
        }
        while let Some(last) = own(&self.choices).next_back()
            && !self.may_be(track, stop, last, known)
        {
            self.choices[track][stop].end = last;
        }
    }

    /// Whether a stop may be in this stretch, as far as rows that are known and functions that are looked for tell.
    fn may_be(&self, track: usize, stop: usize, stretch: usize, known: &Rows) -> bool {
        let mut choices = self.choices[track].clone();
        choices[stop] = stretch..stretch + 1;
        let track = &self.tracks[track];
        let around = track.around(stop);
        let view = track.view(&self.region, &choices);
        let mut rows = known.clone();
        for _ in 0..TRIALS {
            let (point, depth) = deepest(&rows, &self.whole);
            if depth < 0.0 && contract(&rows).is_err() {
                return false;
            }
            let found = track.posed((&self.region, &point), &choices, around.clone());
            let found = found.refuting(0.0);
            if found.is_empty() {
                return true;
            }
            for window in &found {
                track.say(window, (&self.region, &view), &mut rows);
            }
        }
        contract(&rows).is_ok()
    }

    /// A point that nothing refutes.
    fn inner(&mut self) -> Option<Vec<f64>> {
        for _ in 0..MIDDLES {
            let (point, depth) = deepest(&self.rows, &self.whole);
            if depth < 0.0 && contract(&self.rows).is_err() {
                break;
            }
            if !self.refute(&point) {
                return Some(point);
            }
        }
        None
    }

    /// Finds functions for both ends of every parameter, for each with so many vertices at most, and about what they leave of
    /// all quantities; nothing where nothing is left.
    pub(super) fn ends(&mut self, vertices: usize) -> Option<Vec<Interval>> {
        let inner = self.inner();
        let mut box_ = self.region.hull();
        let params = self.tracks.iter().flat_map(Track::params);
        for param in params.collect::<BTreeSet<usize>>() {
            let axes = self.region.axes[param].clone();
            if axes.iter().all(|axis| *axis == 0.0) {
                continue;
            }
            let ends = [1.0, -1.0].map(|sign| {
                let direction: Vec<f64> = axes.iter().map(|axis| sign * axis).collect();
                Some(sign * self.end(&direction, inner.as_deref(), vertices)?)
            });
            let [Some(lo), Some(hi)] = ends else {
                return None;
            };
            let left = Interval::new(lo, hi)? + self.region.offset(param);
            box_[param] = box_[param].intersect(left);
        }
        box_.iter().all(|x| !x.is_empty()).then_some(box_)
    }

    /// About how far from linear what decides the ends of parameters is, in each axis.
    pub(super) fn bends(&self) -> Vec<f64> {
        let mut bends = vec![0.0; self.region.axes()];
        let params = self.tracks.iter().flat_map(Track::params);
        for param in params.collect::<BTreeSet<usize>>() {
            let axes = &self.region.axes[param];
            let reach: f64 = axes.iter().map(|axis| axis.abs()).sum();
            if reach == 0.0 {
                continue;
            }
            for sign in [1.0, -1.0] {
                let direction: Vec<f64> = axes.iter().map(|axis| sign * axis / reach).collect();
                let mut program = Program::new(&self.rows, &self.whole, Side::Outer);
                for (row, multiplier) in program.minimize(&direction).multipliers {
                    let pairs = bends.iter_mut().zip(&self.bents[row]);
                    pairs.for_each(|(sum, bent)| *sum += multiplier.abs() * bent);
                }
            }
        }
        bends
    }

    /// About the least value in a direction.
    fn end(&mut self, direction: &[f64], inner: Option<&[f64]>, vertices: usize) -> Option<f64> {
        let reach: f64 = direction.iter().map(|x| x.abs()).sum();
        let mut before = f64::NEG_INFINITY;
        for _ in 0..vertices {
            let vertex = Program::new(&self.rows, &self.whole, Side::Outer).minimize(direction);
            if vertex.is_impossible {
                return None;
            }
            let pairs = direction.iter().zip(&vertex.point);
            let value: f64 = pairs.map(|(d, x)| d * x).sum();
            if value - before < WORTHWHILE * reach {
                return Some(value);
            }
            before = value;
            let mut old = self.rows.len();
            if !self.refute(&vertex.point) {
                return Some(value);
            }
            let mut share = 1.0;
            for _ in 0..STEPS {
                let Some(inner) = inner else { break };
                let nearer = self.border(old, inner, &vertex.point);
                if nearer >= share {
                    break;
                }
                (share, old) = (nearer, self.rows.len());
                let pairs = inner.iter().zip(&vertex.point);
                let point: Vec<f64> = pairs.map(|(a, b)| a + share * (b - a)).collect();
                if !self.refute(&point) {
                    break;
                }
            }
        }
        Some(before)
    }

    /// The share of the way from a point to another one at which rows from some on end it.
    fn border(&self, from: usize, inner: &[f64], outer: &[f64]) -> f64 {
        let mut share: f64 = 1.0;
        for row in from..self.rows.len() {
            let (begin, end) = (self.value(row, inner), self.value(row, outer));
            let bounds = self.rows.outer(row);
            for (begin, end, bound) in [(begin, end, bounds.hi()), (-begin, -end, -bounds.lo())] {
                if end > bound {
                    share = share.min(((bound - begin) / (end - begin)).max(0.0));
                }
            }
        }
        share
    }

    fn value(&self, row: usize, point: &[f64]) -> f64 {
        value(&self.rows, row, point)
    }
}

fn value(rows: &Rows, row: usize, point: &[f64]) -> f64 {
    let slopes = rows.slopes(row).iter().zip(point);
    slopes.map(|(slope, x)| slope * x).sum()
}

/// How far outside of rows a point is, as share of what a row is on the unit box.
fn outside(rows: &Rows, point: &[f64]) -> f64 {
    let outside = (0..rows.len()).map(|row| {
        let value = value(rows, row, point);
        let reach: f64 = rows.slopes(row).iter().map(|slope| slope.abs()).sum();
        let bounds = rows.outer(row);
        (value - bounds.hi()).max(bounds.lo() - value) / reach
    });
    outside.fold(f64::NEG_INFINITY, f64::max)
}
