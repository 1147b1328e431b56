//! The stretch of time that the output figure shows in full resolution.

use crate::meta::Zoom;
use crate::track::{Band, Cell, Track};

/// Samples in an automatically chosen window: at 10 ms, the 0.3 s of a readable zoom.
const WINDOW: usize = 31;

/// Keeps the samples of the zoomed window, in bounded memory, without knowing the record's end.
#[derive(Clone, Debug)]
pub(crate) enum Spotlight {
    Off,
    Window {
        from: f64,
        to: f64,
        track: Track,
    },
    Auto {
        outputs: usize,
        block: Vec<Cell>,
        best: Option<(f64, Vec<Cell>)>,
    },
}

impl Spotlight {
    pub fn new(zoom: Zoom, outputs: usize, columns: usize) -> Self {
        match zoom {
            Zoom::Off => Self::Off,
            Zoom::Window(from, to) => Self::Window {
                from,
                to,
                track: Track::new(columns),
            },
            Zoom::Auto => Self::Auto {
                outputs,
                block: Vec::with_capacity(WINDOW),
                best: None,
            },
        }
    }

    /// Takes the next sample: the outputs' bands first, then the measured ones.
    pub fn push(&mut self, sample: Cell) {
        match self {
            Self::Off => {}
            Self::Window { from, to, track } => {
                if (*from..=*to).contains(&sample.t0) {
                    track.push(sample);
                }
            }
            Self::Auto {
                outputs,
                block,
                best,
            } => {
                block.push(sample);
                if block.len() == WINDOW {
                    let merit = merit(block, *outputs);
                    if merit > best.as_ref().map_or(0.0, |(most, _)| *most) {
                        *best = Some((merit, block.clone()));
                    }
                    // Windows overlap by half, so none of the interesting places is cut in two.
                    block.drain(..WINDOW / 2);
                }
            }
        }
    }

    /// An automatic window shows the last samples: what comes next refutes the model.
    pub fn end_here(&mut self) {
        if let Self::Auto { block, best, .. } = self
            && block.len() > 1
        {
            *best = Some((f64::INFINITY, block.clone()));
        }
    }

    /// The samples of the window; fewer than two are nothing to zoom.
    pub fn cells(&self) -> Option<&[Cell]> {
        let cells = match self {
            Self::Off => return None,
            Self::Window { track, .. } => track.cells(),
            Self::Auto { best, .. } => best.as_ref()?.1.as_slice(),
        };
        (cells.len() > 1).then_some(cells)
    }
}

/// How much a window tells, 0 for nothing: how much narrower the proved band is than the measured
/// one, weighed down where the output moves far less or far more than three band widths, since
/// then the two bands cannot be told apart.
fn merit(block: &[Cell], outputs: usize) -> f64 {
    (0..outputs)
        .map(|j| output_merit(block, j, outputs + j))
        .sum()
}

fn output_merit(block: &[Cell], proved: usize, measured: usize) -> f64 {
    let bounded = |series: usize| {
        block
            .iter()
            .filter_map(move |cell| cell.band(series))
            .filter(|band| band.lo.is_finite() && band.hi.is_finite())
    };
    let mean_width = |series: usize| {
        let (sum, count) = bounded(series).fold((0.0, 0u32), |(sum, count), band: Band| {
            (sum + (band.hi - band.lo), count + 1)
        });
        (count > 0).then(|| sum / f64::from(count))
    };
    let Some(inner) = mean_width(proved) else {
        return 0.0;
    };
    let outer = mean_width(measured).unwrap_or(inner);
    let (least, most) = bounded(proved)
        .map(|band| band.lo / 2.0 + band.hi / 2.0)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), mid| {
            (a.min(mid), b.max(mid))
        });
    if !(outer > 0.0 && outer.is_finite() && most >= least) {
        return 0.0;
    }
    let travel = (most - least) / outer;
    let motion = if travel < 3.0 {
        travel / 3.0
    } else {
        3.0 / travel
    };
    (0.05 + (1.0 - inner / outer).max(0.0)) * (0.05 + motion)
}
