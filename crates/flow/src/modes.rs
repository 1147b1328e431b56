//! Sets of modes.

use std::ops::Range;
use veribound_interval::lanes::{LANES, Mask};
use veribound_model::MOST_MODES;

/// Numbers that have a bit for every mode that a model can have.
const WORDS: usize = MOST_MODES.div_ceil(u64::BITS as usize);

/// A set of modes of one model, by their position in [`veribound_model::Model::modes`].
///
/// ```
/// use veribound_flow::ModeSet;
///
/// let mut modes = ModeSet::EMPTY;
/// modes.insert(2);
/// modes.insert(200);
/// assert!(modes.contains(2) && !modes.contains(3));
/// assert_eq!(modes.iter().collect::<Vec<_>>(), [2, 200]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ModeSet([u64; WORDS]);

impl ModeSet {
    /// No mode.
    pub const EMPTY: ModeSet = ModeSet([0; WORDS]);

    /// Adds a mode; no model has one at a position from [`MOST_MODES`] on.
    pub fn insert(&mut self, mode: usize) {
        if let Some(word) = self.0.get_mut(mode / 64) {
            *word |= 1 << (mode % 64);
        }
    }

    /// True when `mode` is in the set.
    pub fn contains(self, mode: usize) -> bool {
        self.0
            .get(mode / 64)
            .is_some_and(|word| word & (1 << (mode % 64)) != 0)
    }

    /// Modes in either set.
    pub fn union(self, other: ModeSet) -> ModeSet {
        let mut all = self;
        for (word, more) in all.0.iter_mut().zip(other.0) {
            *word |= more;
        }
        all
    }

    /// Number of modes in the set.
    pub fn len(self) -> usize {
        self.0.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// True when no mode is in the set.
    pub fn is_empty(self) -> bool {
        self == ModeSet::EMPTY
    }

    /// The modes, in order.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        self.0.into_iter().enumerate().flat_map(|(position, word)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                if rest == 0 {
                    return None;
                }
                let bit = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                Some(position * 64 + bit)
            })
        })
    }
}

/// Sets of modes of eight boxes side by side: for every mode, the boxes that have it.
#[derive(Debug, Clone, Default)]
pub(crate) struct ModeMasks(Vec<Mask>);

impl ModeMasks {
    /// No mode of `count`, on any box.
    pub(crate) fn clear(&mut self, count: usize) {
        self.0.clear();
        self.0.resize(count, Mask::NONE);
    }

    /// Adds a mode to some boxes.
    pub(crate) fn insert(&mut self, mode: usize, lanes: Mask) {
        if let Some(mask) = self.0.get_mut(mode) {
            *mask |= lanes;
        }
    }

    /// Takes over the sets of some boxes.
    pub(crate) fn assign(&mut self, lanes: Mask, other: &ModeMasks) {
        for (mask, new) in self.0.iter_mut().zip(&other.0) {
            *mask = mask.without(lanes) | (*new & lanes);
        }
    }

    /// The boxes that have a mode.
    pub(crate) fn of(&self, mode: usize) -> Mask {
        self.0.get(mode).copied().unwrap_or(Mask::NONE)
    }

    /// The boxes that have some mode of a group.
    pub(crate) fn any_of(&self, group: Range<usize>) -> Mask {
        let masks = self.0.get(group).unwrap_or_default();
        masks.iter().fold(Mask::NONE, |all, mask| all | *mask)
    }

    /// The set of every box.
    pub(crate) fn sets(&self) -> [ModeSet; LANES] {
        let mut sets = [ModeSet::EMPTY; LANES];
        for (mode, mask) in self.0.iter().enumerate() {
            for (lane, set) in sets.iter_mut().enumerate() {
                if mask.get(lane) {
                    set.insert(mode);
                }
            }
        }
        sets
    }
}

#[cfg(test)]
mod tests {
    use super::ModeSet;

    #[test]
    fn holds_what_was_inserted() {
        let mut set = ModeSet::EMPTY;
        for mode in [0, 63, 64, 200, 255] {
            set.insert(mode);
        }
        assert_eq!(set.iter().collect::<Vec<_>>(), [0, 63, 64, 200, 255]);
        assert!(set.contains(200) && !set.contains(199));
        assert_eq!(set.len(), 5);
    }
}
