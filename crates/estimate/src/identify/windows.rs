//! Windows: stretches of a record that are passed with start states of their own, where one form does not come to its
//! end, and what all of them say together.
//!
//! Parameters are the same in all windows, and the states that one window comes to are those that the next one begins
//! with. The unknowns of all windows and these equations are one system of rows: what a sample says goes on through the
//! states to all windows, though no form does.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: unknowns, rows and records of the same region and problem"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::cell::{BELIEVED, of_record};
use super::eigen::eigenvectors;
use super::pass::{Aim, Anchor, Conflict, GoOn, Passed, Span, contract_curved, narrow, pass};
use super::problem::Problem;
use super::region::{Region, scales_of};
use super::rows::{Affine, Rows, SLIGHT, in_order};
use super::simplex::{Deepest, Program, Side, deepest};
use veribound_flow::form::Parallelotope;
use veribound_interval::Interval;

/// Later windows are left for the next round when one leaves less than this share of an axis.
const ENOUGH: f64 = 0.6;

/// Where so many windows in a row tell nothing of what they have in common, later ones are left until more is known.
const IDLE: usize = 48;

/// What leaves this share of every axis tells nothing of them.
const WHOLE: f64 = 0.999;

/// States are known about as well where they are this much wider.
const AS_WELL: f64 = 2.0;

/// Where one window goes over to the next, what is no function of its unknowns should be less than this share.
const LOST: f64 = 0.5;

/// So many unknowns of windows are looked at together for the states where they begin: parameters, which all others told
/// of, bound these beside their neighbours.
const BESIDE: usize = 16;

/// Samples of a record at which states are known, and these.
pub(crate) type Junctions = BTreeMap<usize, Vec<Interval>>;

/// How well each state is known at junctions, in the mean.
pub(crate) fn widths(junctions: &[Junctions]) -> Vec<f64> {
    let boxes = || junctions.iter().flat_map(Junctions::values);
    let states = boxes().next().map_or(0, Vec::len);
    let mean = |state: usize| {
        let sum: f64 = boxes().map(|box_| box_[state].width()).sum();
        sum / boxes().count() as f64
    };
    (0..states).map(mean).collect()
}

/// A passed window of a record.
pub(crate) struct Window {
    /// Of its unknowns the states at its begin are first, where they are its own.
    pub(crate) passed: Passed,
    /// The axes of the region that its other unknowns are.
    pub(crate) kept: Vec<usize>,
    pub(crate) record: usize,
    /// How the window before leads to its own start states.
    pub(crate) link: Option<Link>,
}

/// Where one window goes over to the next.
pub(crate) struct Link {
    sample: usize,
    /// States there, in the unknowns of the window before and these products of them,
    states: Vec<Affine>,
    products: Vec<(usize, usize)>,
    /// and as what the next one begins with.
    starts: Region,
}

impl Window {
    /// How many unknowns are its own.
    pub(crate) fn own(&self) -> usize {
        self.link.as_ref().map_or(0, |link| link.starts.axes())
    }
}

/// How much each of so many axes is to blame that windows of a record end before the sample `until`, or bends what one that does
/// not end tells: a hint.
///
/// What is not affine in the unknowns of a window, its own start states among them, ends it; what ends after few samples counts most.
pub(crate) fn blames(windows: &[&Window], axes: usize, until: usize) -> Vec<f64> {
    let mut blames = vec![0.0; axes];
    for window in windows {
        let begin = window.link.as_ref().map_or(0, |link| link.sample);
        let bends = &window.passed.curvature;
        let all: f64 = bends.iter().sum();
        let share = match window.passed.reached < until {
            true if all > 0.0 => 1.0 / all,
            // The last of several is as long as there is something left.
            false if windows.len() == 1 => 1.0,
            _ => continue,
        };
        let length = (window.passed.reached - begin + 1) as f64;
        for (axis, bend) in window.kept.iter().zip(&bends[window.own()..]) {
            blames[*axis] += share * bend / length;
        }
    }
    blames
}

impl Problem {
    /// Goes on behind the last of `windows`, with start states of their own, to the end of its record; where they are
    /// `known` at some samples, this is taken. It ends earlier where it may not go on.
    pub(crate) fn later_windows(
        &self,
        region: &Region,
        known: &Junctions,
        windows: &mut Vec<Window>,
        passes: &mut usize,
        go_on: &GoOn<'_>,
    ) -> Result<(), (usize, Conflict)> {
        let Some(record) = windows.last().map(|window| window.record) else {
            return Ok(());
        };
        let course = &self.courses[record];
        let until = course.end();
        let (own, kept) = region.rows_of(&self.fixed_of(record, false));
        let mut from = 0;
        let first = windows.last().and_then(|window| {
            let rows = window.passed.rows.curved(BELIEVED);
            let part = contract_curved(&rows).ok()?;
            anchored(&window.passed, &rows, &part, from, known)
        });
        let mut link = first;
        let mut idle = 0;
        while let Some(next) = link.filter(|_| go_on()) {
            from = next.sample;
            let fresh = next.starts.axes();
            let zeros = |count: usize| vec![0.0; count];
            let widened = next.starts.axes.iter();
            let widened = widened.map(|row| [&row[..], &zeros(kept.len())].concat());
            let shifted = own.axes.iter().map(|row| [&zeros(fresh)[..], row].concat());
            let rows = Parallelotope {
                centre: [&next.starts.centre[..], &own.centre].concat(),
                axes: widened.chain(shifted).collect(),
                rest: [&next.starts.rest[..], &own.rest].concat(),
            };
            let span = Span {
                from,
                until,
                aim: Aim::Bounds,
                go_on,
            };
            *passes += 1;
            let wanted = known.range(from..).map(|(sample, _)| *sample).collect();
            let mut passed = pass(self, course, span, self.set(record, rows, false), wanted);
            if let Some(conflict) = passed.conflict {
                return Err(of_record(record, conflict));
            }
            passed.rows.prune();
            let rows = passed.rows.curved(BELIEVED);
            let part = contract_curved(&rows).map_err(|conflict| of_record(record, conflict))?;
            let ended = passed.reached == until;
            link = anchored(&passed, &rows, &part, from, known).filter(|_| !ended);
            let both = passed.scales[fresh..].iter().zip(&part[fresh..]);
            let shrunk = both.map(|(scale, x)| scale.1.hi() * x.rad());
            let shrunk = shrunk.fold(1.0, f64::min);
            windows.push(Window {
                passed,
                kept: kept.clone(),
                record,
                link: Some(next),
            });
            idle = if shrunk > WHOLE { idle + 1 } else { 0 };
            // A narrower set goes farther.
            if shrunk < ENOUGH || idle >= IDLE {
                break;
            }
        }
        Ok(())
    }
}

/// The last sample after `from` at which states are known about as well as anywhere on the way of a pass: what comes
/// after a sample tells as much of it as what was before, so that this is seldom the last one of all.
///
/// The rows are those of the pass, with what bounds their products.
fn anchored(
    passed: &Passed,
    rows: &Rows,
    part: &[Interval],
    from: usize,
    known: &Junctions,
) -> Option<Link> {
    let mut program = Program::new(rows, part, Side::Outer);
    let every: Vec<usize> = (0..rows.plain()).collect();
    let products = passed.rows.products();
    let later = passed.anchors.iter().filter(|anchor| anchor.sample > from);
    let boxes: Vec<(&Anchor, Vec<Interval>)> = later
        .map(|anchor| {
            let states = anchor.states.iter();
            let states = states.map(|state| rows.adopt(state, products, &every));
            let mut box_: Vec<Interval> = states.map(|state| program.around(&state)).collect();
            for (x, known) in box_
                .iter_mut()
                .zip(known.get(&anchor.sample).into_iter().flatten())
            {
                *x = x.intersect(*known);
            }
            (anchor, box_)
        })
        .filter(|(_, box_)| box_.iter().all(|x| x.is_bounded() && !x.is_empty()))
        .collect();
    let least: Vec<f64> = (0..boxes.first()?.1.len())
        .map(|state| {
            let widths = boxes.iter().map(|(_, box_)| box_[state].width());
            widths.fold(f64::INFINITY, f64::min)
        })
        .collect();
    let wider = |box_: &[Interval]| {
        let pairs = box_.iter().zip(&least);
        let shares = pairs.map(|(x, least)| x.width() / least.max(f64::MIN_POSITIVE));
        shares.filter(|share| share.is_finite()).fold(1.0, f64::max)
    };
    let best = boxes.iter().map(|(_, box_)| wider(box_));
    let best = best.fold(f64::INFINITY, f64::min);
    let mut as_well = boxes
        .iter()
        .filter(|(_, box_)| wider(box_) <= AS_WELL * best);
    let is_linked = |(anchor, box_): &&(&Anchor, Vec<Interval>)| {
        let mut states = anchor.states.iter().zip(box_);
        states.all(|(state, x)| state.rest.width() <= LOST * x.width())
    };
    let linked = as_well.clone().rev().find(is_linked);
    let (anchor, box_) = linked.or_else(|| as_well.next_back())?;
    Some(Link {
        sample: anchor.sample,
        states: anchor.states.clone(),
        products: products.to_vec(),
        starts: Region::of_box(box_),
    })
}

/// The parts of the axes of a region that all windows leave, as scales.
pub(crate) fn common(
    windows: &[Window],
    axes: usize,
) -> Result<Vec<(Interval, Interval)>, (usize, Conflict)> {
    let unit = Interval::symmetric(1.0);
    if let [window] = windows {
        let mut scales = vec![(Interval::ZERO, Interval::ONE); axes];
        for (axis, scale) in window.kept.iter().zip(&window.passed.scales) {
            scales[*axis] = *scale;
        }
        return Ok(scales);
    }
    let mut part = vec![unit; axes];
    for window in windows {
        let scales = &window.passed.scales[window.own()..];
        for (axis, (middle, radius)) in window.kept.iter().zip(scales) {
            part[*axis] = part[*axis].intersect(*middle + *radius * unit);
        }
    }
    if let Some(axis) = part.iter().position(|x| x.is_empty()) {
        let told = windows.iter().filter(|window| window.kept.contains(&axis));
        let samples = told.map(|window| (window.passed.reached, window.record));
        let samples = samples.collect();
        return Err((0, Conflict::Rows { samples }));
    }
    Ok(scales_of(&part))
}

/// Unknowns `common.0 + common.1 δ'` in terms of `own.0 + own.1 δ`.
fn into(own: &(Interval, Interval), common: &(Interval, Interval)) -> (Interval, Interval) {
    if own == common {
        return (Interval::ZERO, Interval::ONE);
    }
    if own.1.contains(0.0) {
        return (Interval::ENTIRE, Interval::ENTIRE);
    }
    ((common.0 - own.0) / own.1, common.1 / own.1)
}

/// What windows say together.
pub(crate) struct Joined {
    /// Of the axes of the region.
    pub(crate) rows: Rows,
    /// The axes of the deepest point, where all windows were looked at together.
    pub(crate) deepest: Option<Deepest>,
}

/// Writes what windows say in the common scales of the axes of the region.
pub(crate) fn in_common(windows: &mut [Window], scales: &[(Interval, Interval)]) {
    for position in 0..windows.len() {
        let window = &windows[position];
        let own = window.own();
        let mut to_common = vec![(Interval::ZERO, Interval::ONE); own];
        let kept = window.kept.iter().zip(&window.passed.scales[own..]);
        to_common.extend(kept.map(|(axis, own)| into(own, &scales[*axis])));
        windows[position].passed.rows.rescale(&to_common);
        if let Some(Window {
            link: Some(link), ..
        }) = windows.get_mut(position + 1)
        {
            for state in &mut link.states {
                state.rescale(&link.products, &to_common);
            }
        }
    }
}

/// Windows of a record in a row with at most so many unknowns of their own, and how many they have; those that have none are alone.
fn groups(windows: &[Window], together_at_most: usize) -> Vec<(&[Window], usize)> {
    let mut groups = Vec::new();
    let mut begin = 0;
    while begin < windows.len() {
        let (mut end, mut fresh) = (begin, 0);
        let fits = |end: usize, fresh: usize| {
            let is_same = windows[end].record == windows[begin].record;
            end == begin || is_same && fresh + windows[end].own() <= together_at_most
        };
        while end < windows.len() && fits(end, fresh) {
            fresh += windows[end].own();
            end += 1;
        }
        groups.push((&windows[begin..end], fresh));
        begin = end;
    }
    groups
}

/// What windows in the common scales of so many axes say of these; windows with so many unknowns of their own are looked
/// at together.
pub(crate) fn joined(
    windows: &[Window],
    axes: usize,
    together_at_most: usize,
) -> Result<Joined, (usize, Conflict)> {
    let mut rows = Rows::new(axes);
    for window in windows.iter().filter(|window| window.link.is_none()) {
        rows.take_curved(&window.passed.rows, &window.kept, window.record);
    }
    let mut deep = None;
    let every: Vec<usize> = (0..axes).collect();
    for (part, fresh) in groups(windows, together_at_most) {
        // What a window without products says is among the rows.
        if fresh == 0 && part[0].passed.rows.products().is_empty() {
            continue;
        }
        let record = part[0].record;
        let joint = together(part, (fresh, axes)).rows;
        let mut left = joint.whole();
        narrow(&joint, &mut left, fresh..fresh + axes).map_err(|conflict| (record, conflict))?;
        if part.len() == windows.len() {
            let (point, depth) = deepest(&joint, &left);
            deep = Some((point[fresh..fresh + axes].to_vec(), depth));
        }
        rows.take(
            &projected(&joint, &left, fresh..fresh + axes),
            &every,
            record,
        );
    }
    Ok(Joined {
        rows,
        deepest: deep,
    })
}

/// The states at the begins of windows, of which so much of the axes is `left`, by record.
pub(crate) fn junctions(
    windows: &[Window],
    left: &[Interval],
) -> Result<Vec<Junctions>, (usize, Conflict)> {
    let records = windows.last().map_or(0, |window| window.record + 1);
    let mut junctions = vec![Junctions::new(); records];
    for (part, fresh) in groups(windows, BESIDE) {
        if fresh == 0 {
            continue;
        }
        let joint = together(part, (fresh, left.len()));
        let mut all = joint.rows.whole();
        all[fresh..fresh + left.len()].copy_from_slice(left);
        narrow(&joint.rows, &mut all, 0..fresh).map_err(|conflict| (part[0].record, conflict))?;
        for (window, columns) in part.iter().zip(&joint.columns) {
            let Some(link) = &window.link else { continue };
            let own = columns[..window.own()].iter().map(|column| all[*column]);
            let own: Vec<Interval> = own.collect();
            let starts = link.starts.rescaled(&window.passed.scales[..window.own()]);
            let box_ = (0..starts.centre.len()).map(|state| starts.range(state, &own));
            junctions[window.record].insert(link.sample, box_.collect());
        }
    }
    Ok(junctions)
}

/// What windows say of their own unknowns, which are first, and the axes.
struct Together {
    rows: Rows,
    /// For every window the positions of its unknowns.
    columns: Vec<Vec<usize>>,
}

/// What windows say, and that each begins where the one before leads to.
fn together(windows: &[Window], (fresh, axes): (usize, usize)) -> Together {
    let mut columns: Vec<Vec<usize>> = Vec::with_capacity(windows.len());
    let mut products = BTreeSet::new();
    let mut begin = 0;
    for window in windows {
        let own = begin..begin + window.own();
        begin = own.end;
        let kept = window.kept.iter().map(|axis| fresh + axis);
        let own: Vec<usize> = own.chain(kept).collect();
        let pairs = window.passed.rows.notable().into_iter();
        products.extend(pairs.map(|(i, j)| in_order(own[i], own[j])));
        columns.push(own);
    }
    let links = windows.iter().enumerate().skip(1);
    let links = links.filter_map(|(position, window)| Some((position, window.link.as_ref()?)));
    for (position, link) in links.clone() {
        let own = &columns[position - 1];
        let pairs = link.notable().into_iter();
        products.extend(pairs.map(|(i, j)| in_order(own[i], own[j])));
    }
    let mut rows = Rows::with_products(fresh + axes, products.into_iter().collect());
    for (window, own) in windows.iter().zip(&columns) {
        rows.take_curved(&window.passed.rows, own, window.record);
    }
    for (position, link) in links {
        let window = &windows[position];
        let fresh = link.starts.axes();
        let starts = link.starts.rescaled(&window.passed.scales[..fresh]);
        for (state, before) in link.states.iter().enumerate() {
            let before = rows.adopt(before, &link.products, &columns[position - 1]);
            let mut slopes = before.slopes;
            for (column, slope) in columns[position].iter().zip(&starts.axes[state]) {
                slopes[*column] -= slope;
            }
            let rest = before.rest - starts.offset(state);
            rows.push(&slopes, rest, Interval::ZERO, BELIEVED, window.record);
        }
    }
    rows.prune();
    rows.bound_products(BELIEVED);
    Together { rows, columns }
}

impl Link {
    /// The products that the states depend on notably, beside what they are known to.
    fn notable(&self) -> Vec<(usize, usize)> {
        let plain = |state: &Affine| state.slopes.len() - self.products.len();
        let is_notable = |position: &usize| {
            let mut states = self.states.iter().zip(&self.starts.axes);
            states.any(|(state, axes)| {
                let width: f64 = axes.iter().map(|x| 2.0 * x.abs()).sum();
                state.slopes[plain(state) + position].abs() > SLIGHT * width
            })
        };
        let positions = (0..self.products.len()).filter(is_notable);
        positions.map(|position| self.products[position]).collect()
    }
}

/// What rows say of some of the unknowns.
fn projected(rows: &Rows, part: &[Interval], wanted: Range<usize>) -> Rows {
    let n = part.len();
    let matrix = information(rows, part);
    // What is left of the information when the other unknowns are free.
    let mut left = matrix;
    for v in (0..n).filter(|v| !wanted.contains(v)) {
        let pivot = left[v * n + v];
        if pivot <= 0.0 {
            continue;
        }
        for i in 0..n {
            let factor = left[i * n + v] / pivot;
            for l in 0..n {
                if i != v {
                    left[i * n + l] -= factor * left[v * n + l];
                }
            }
        }
    }
    let kept = wanted.len();
    let row = |i: usize| left[i * n + wanted.start..i * n + wanted.end].to_vec();
    let corner: Vec<f64> = wanted.clone().flat_map(row).collect();
    let mut directions = eigenvectors(kept, &corner);
    directions.extend((0..kept).map(|v| {
        let mut unit = vec![0.0; kept];
        unit[v] = 1.0;
        unit
    }));
    let mut program = Program::new(rows, part, Side::Outer);
    let mut told = Rows::new(kept);
    let sample = (0..rows.len()).map(|row| rows.origin(row).0).max();
    for direction in directions {
        let mut whole = vec![0.0; n];
        whole[wanted.clone()].copy_from_slice(&direction);
        let bounds = program.bounds(&whole);
        if bounds.is_bounded() && wanted.start == 0 {
            told.push_outer(&direction, bounds);
        } else if bounds.is_bounded() {
            told.push(&direction, Interval::ZERO, bounds, sample.unwrap_or(0), 0);
        }
    }
    told
}

/// How much rows say of the directions of unknowns, seen from a part of their box: a hint.
pub(crate) fn information(rows: &Rows, part: &[Interval]) -> Vec<f64> {
    let n = part.len();
    let mut matrix = vec![0.0; n * n];
    let mut entries: Vec<(usize, f64)> = Vec::with_capacity(n);
    for row in 0..rows.len() {
        let slopes = rows.slopes(row).iter().copied().enumerate();
        entries.clear();
        entries.extend(slopes.filter(|(_, g)| *g != 0.0));
        let reach = entries.iter().map(|(v, g)| g.abs() * part[*v].rad());
        let width = rows.outer(row).rad().max(1e-30);
        if reach.sum::<f64>() < width {
            continue;
        }
        for (i, g) in &entries {
            for (l, h) in &entries {
                matrix[i * n + l] += g * h / (width * width);
            }
        }
    }
    matrix
}
