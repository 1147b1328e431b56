//! All tiles of a paving under way, as they are saved.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: a row of a frame stands for a list that was found to have one per parameter"
)]

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use super::super::answer::{Reason, Tile};
use super::local::Local;
use super::turn::Turn;
use serde::{Deserialize, Serialize};
use veribound_interval::Interval;

/// A tile that is not decided.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Open {
    /// Its coordinates: parameters, or unknowns of a frame.
    pub(super) within: Vec<Interval>,
    /// A position in [`State::turns`].
    pub(super) frame: Option<usize>,
    pub(super) volume: f64,
    /// The rows that hold on it, unless it has to be moved itself: a key of [`State::locals`].
    pub(super) local: Option<usize>,
    /// The coordinate to halve.
    pub(super) axis: usize,
    /// The share of it that agrees, as far as rows told that do not decide it.
    pub(super) agrees: Interval,
    pub(super) order: usize,
}

impl PartialEq for Open {
    fn eq(&self, other: &Open) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Open) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Open) -> Ordering {
        let volumes = self.volume.total_cmp(&other.volume);
        volumes.then(other.order.cmp(&self.order))
    }
}

/// All tiles.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct State {
    pub(super) open: BinaryHeap<Open>,
    /// Rows by key, and how many open tiles they hold on.
    pub(super) locals: BTreeMap<usize, (Local, usize)>,
    pub(super) tiles: Vec<Tile>,
    pub(super) turns: Vec<Turn>,
    pub(super) undecided: f64,
    pub(super) inside: f64,
    pub(super) next: usize,
    /// Bytes that rows take, about.
    pub(super) held: usize,
    /// No more tiles are moved through the records.
    pub(super) is_spent: bool,
    pub(crate) sets: usize,
    pub(crate) passes: usize,
}

impl State {
    /// Whether its lists have the lengths of a problem with so many parameters, and what it points to is there.
    pub(crate) fn fits(&self, params: usize) -> bool {
        let coordinates = |frame: Option<usize>| match frame {
            None => Some(params),
            Some(frame) => Some(
                self.turns
                    .get(frame)?
                    .frame
                    .axes
                    .first()
                    .map_or(0, Vec::len),
            ),
        };
        let is_frame = |turn: &Turn| {
            let axes = &turn.frame.axes;
            let lists = [turn.frame.centre.len(), axes.len(), turn.clip.len()];
            lists == [params; 3] && axes.iter().all(|row| row.len() == axes[0].len())
        };
        let is_open = |open: &Open| {
            let local = open.local.map(|key| self.locals.get(&key));
            coordinates(open.frame).is_some_and(|coordinates| {
                open.within.len() == coordinates
                    && (open.axis < coordinates || coordinates == 0)
                    && local.is_none_or(|local| local.is_some_and(|own| own.0.fits(coordinates)))
            })
        };
        let is_closed = |tile: &Tile| {
            let turned = tile.turned.as_ref();
            tile.params.len() == params
                && turned.is_none_or(|turned| {
                    coordinates(Some(turned.frame)) == Some(turned.unknowns.len())
                })
                && match tile.reason {
                    Reason::Needle { frame } => frame < self.turns.len(),
                    _ => true,
                }
        };
        self.turns.iter().all(is_frame)
            && self.open.iter().all(is_open)
            && self.tiles.iter().all(is_closed)
    }
}
