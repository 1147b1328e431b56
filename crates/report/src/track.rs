//! Series over time in bounded memory: neighbouring samples share a cell that keeps their extremes.

/// A closed range that holds a quantity; never NaN, never empty, perhaps unbounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Band {
    pub lo: f64,
    pub hi: f64,
}

impl Band {
    /// The band of two bounds. A NaN bound knows nothing, so it is infinite; `None` where lo > hi,
    /// the empty set.
    pub fn of((lo, hi): (f64, f64)) -> Option<Self> {
        let lo = if lo.is_nan() { f64::NEG_INFINITY } else { lo };
        let hi = if hi.is_nan() { f64::INFINITY } else { hi };
        (lo <= hi).then_some(Self { lo, hi })
    }

    /// The smallest band that holds both.
    pub fn hull(self, other: Self) -> Self {
        Self {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }
}

/// The samples from `t0` to `t1`: for each series the hull of its bands and the union of its marks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cell {
    pub t0: f64,
    pub t1: f64,
    pub bands: Box<[Option<Band>]>,
    pub marks: Box<[u8]>,
}

impl Cell {
    fn absorb(&mut self, later: &Self) {
        self.t1 = later.t1;
        for (mine, theirs) in self.bands.iter_mut().zip(&later.bands) {
            *mine = match (*mine, *theirs) {
                (Some(a), Some(b)) => Some(a.hull(b)),
                (a, b) => a.or(b),
            };
        }
        for (mine, theirs) in self.marks.iter_mut().zip(&later.marks) {
            *mine |= theirs;
        }
    }

    /// The band of one series, if any sample of the cell has one.
    pub fn band(&self, series: usize) -> Option<Band> {
        self.bands.get(series).copied().flatten()
    }

    /// The marks of one series, of all samples of the cell together.
    pub fn mark(&self, series: usize) -> u8 {
        self.marks.get(series).copied().unwrap_or(0)
    }
}

/// At most `capacity` cells, in the order of time.
#[derive(Clone, Debug)]
pub(crate) struct Track {
    cells: Vec<Cell>,
    capacity: usize,
    /// A sample joins the last cell while the cell stays at most this long.
    length: f64,
}

impl Track {
    pub fn new(capacity: usize) -> Self {
        Self {
            cells: Vec::new(),
            capacity: capacity.clamp(8, 100_000),
            length: 0.0,
        }
    }

    /// As fine as memory allows: about 50 MB for any number of series, but not coarser than `columns`.
    pub fn fine(series: usize, columns: usize) -> Self {
        const BANDS: usize = 2_000_000;
        Self::new((BANDS / series.max(1)).max(columns))
    }

    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Takes the next sample, a cell of one moment.
    pub fn push(&mut self, sample: Cell) {
        match self.cells.last_mut() {
            Some(last) if sample.t1 - last.t0 <= self.length => last.absorb(&sample),
            _ => self.cells.push(sample),
        }
        if self.cells.len() > self.capacity {
            self.coarsen();
        }
    }

    /// Joins neighbours so that at most half of the capacity, plus one cell, is left: two cells in
    /// a row are together longer than `length`, and at most capacity/4 such lengths fit.
    fn coarsen(&mut self) {
        let (Some(first), Some(last)) = (self.cells.first(), self.cells.last()) else {
            return;
        };
        let span = last.t1 - first.t0;
        self.length = (4.0 * span / self.capacity as f64).max(2.0 * self.length);
        let mut joined: Vec<Cell> = Vec::with_capacity(self.capacity + 1);
        for cell in self.cells.drain(..) {
            match joined.last_mut() {
                Some(last) if cell.t1 - last.t0 <= self.length => last.absorb(&cell),
                _ => joined.push(cell),
            }
        }
        self.cells = joined;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(t: f64, lo: f64, hi: f64, mark: u8) -> Cell {
        let bands = vec![Band::of((lo, hi))].into();
        Cell {
            t0: t,
            t1: t,
            bands,
            marks: vec![mark].into(),
        }
    }

    /// A fixed stream of numbers in [0, 1), for records that look irregular.
    fn stream(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    #[test]
    fn every_sample_stays_inside_its_cell() {
        for seed in 1..40 {
            let mut next = stream(seed);
            let mut track = Track::new(8 + (next() * 60.0) as usize);
            let mut all = Vec::new();
            let mut t = 0.0;
            for k in 0..2000 {
                t += if next() < 0.01 { 50.0 } else { 1e-3 + next() };
                let mid = (next() - 0.5) * 100.0;
                let one = sample(t, mid - next(), mid + next(), u8::from(k % 97 == 0));
                all.push(one.clone());
                track.push(one);
                assert!(track.cells().len() <= track.capacity);
            }
            let mut cells = track.cells().iter().peekable();
            for one in &all {
                while cells.peek().is_some_and(|cell| cell.t1 < one.t0) {
                    cells.next();
                }
                let cell = cells.peek().expect("a cell for every sample");
                assert!(cell.t0 <= one.t0 && one.t1 <= cell.t1);
                let (outer, inner) = (cell.band(0).unwrap(), one.band(0).unwrap());
                assert!(outer.lo <= inner.lo && inner.hi <= outer.hi);
                assert_eq!(cell.mark(0) & one.mark(0), one.mark(0));
            }
        }
    }

    #[test]
    fn a_cell_holds_nothing_but_the_hull_of_its_samples() {
        let mut track = Track::new(8);
        for k in 0..9 {
            let v = f64::from(k);
            track.push(sample(v, v, v + 1.0, 0));
        }
        for cell in track.cells() {
            assert_eq!(cell.band(0), Band::of((cell.t0, cell.t1 + 1.0)));
        }
    }

    #[test]
    fn a_missing_sample_neither_adds_nor_removes() {
        let mut track = Track::new(8);
        for k in 0..100 {
            let t = f64::from(k);
            let (lo, hi) = if k % 2 == 0 {
                (1.0, 2.0)
            } else {
                (f64::INFINITY, -f64::INFINITY)
            };
            track.push(sample(t, lo, hi, 0));
        }
        assert!(
            track
                .cells()
                .iter()
                .all(|c| c.band(0) == Band::of((1.0, 2.0)))
        );
    }

    #[test]
    fn not_a_number_is_no_knowledge() {
        let band = Band::of((f64::NAN, 3.0)).unwrap();
        assert_eq!((band.lo, band.hi), (f64::NEG_INFINITY, 3.0));
        assert!(Band::of((2.0, 1.0)).is_none());
    }
}
