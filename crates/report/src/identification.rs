//! What records leave of the parameters: bounds from both sides, and a paving.

use crate::figure::Figure;
use crate::history::History;
use crate::meta::Quantity;

/// A parameter with its bounds from both sides. Bounds are pairs lo, hi; those of priors may be infinite.
///
/// Example: [`PavingTile`].
#[derive(Clone, Debug, PartialEq)]
pub struct ProvedParameter {
    /// Name and unit.
    pub quantity: Quantity,
    /// Prior bounds.
    pub prior: (f64, f64),
    /// Proved to hold all values; `None` where none is left.
    pub outer: Option<(f64, f64)>,
    /// Proved to be reached.
    pub inner: Option<(f64, f64)>,
    /// How many times wider than the inner bounds the outer ones are, at most; infinite without inner ones.
    pub tightness: f64,
}

/// What is known of the parameters in a tile.
///
/// Example: [`PavingTile`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TileStatus {
    /// All agree with the records.
    Inside,
    /// None does.
    Outside,
    /// Not known.
    Undecided,
}

/// A box of parameters.
///
/// ```
/// use veribound_report::{Identification, PavingTile, Plots, ProvedParameter, Quantity, TileStatus};
///
/// let param = |name: &str| ProvedParameter {
///     quantity: Quantity::new(name, ""),
///     prior: (0.0, 2.0),
///     outer: Some((0.0, 1.0)),
///     inner: None,
///     tightness: f64::INFINITY,
/// };
/// let tile = |lo: f64, status| PavingTile { params: vec![(lo, lo + 1.0), (0.0, 2.0)], status };
/// let found = Identification {
///     params: vec![param("a"), param("b")],
///     tiles: vec![tile(0.0, TileStatus::Inside), tile(1.0, TileStatus::Outside)],
///     ..Identification::default()
/// };
/// assert_eq!(found.render_all()[1].name, "paving_a_b");
/// assert!(!Plots::of_identification(&found, &[]).is_empty());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PavingTile {
    /// One pair lo, hi per parameter.
    pub params: Vec<(f64, f64)>,
    /// What is known.
    pub status: TileStatus,
}

/// What is known along one of the records.
///
/// ```
/// use veribound_report::{Course, FigureMeta, History, Identification, Page, Plots, Quantity, SampleRow};
///
/// let outputs = vec![Quantity::new("x_m", "m")];
/// let mut history = History::new(FigureMeta { outputs, page: true, ..FigureMeta::default() });
/// let (outputs, measured) = (&[(0.4, 0.6)], &[Some((0.2, 0.7))]);
/// history.push(&SampleRow { outputs, measured, ..SampleRow::default() })?;
/// let course = Course { record: None, is_whole: true, history };
/// let plots = Plots::of_identification(&Identification::default(), &[course]);
/// assert!(Page { plots, ..Page::default() }.render().contains("x_m"));
/// # Ok::<(), veribound_report::ReportError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Course {
    /// The name of the record, where there are several.
    pub record: Option<String>,
    /// Whether all samples are in it.
    pub is_whole: bool,
    /// What is proved of every sample.
    pub history: History,
}

/// All that is drawn of an identification.
///
/// ```
/// use veribound_report::{Identification, ProvedParameter, Quantity};
///
/// let mass = ProvedParameter {
///     quantity: Quantity::new("m", "kg"),
///     prior: (0.5, 5.0),
///     outer: Some((1.9, 2.1)),
///     inner: Some((1.95, 2.05)),
///     tightness: 2.0,
/// };
/// let found = Identification { params: vec![mass], ..Identification::default() };
/// let figure = &found.render_all()[0];
/// assert_eq!(figure.name, "bounds");
/// assert!(figure.svg.starts_with("<svg"));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identification {
    /// Title of the run: in the SVG's title element, not drawn.
    pub title: String,
    /// Parameters.
    pub params: Vec<ProvedParameter>,
    /// Tiles that cover the prior; none where no paving was asked for.
    pub tiles: Vec<PavingTile>,
}

impl Identification {
    /// The bounds of all parameters, and of a paving every two of the first parameters that are not known.
    ///
    /// # Guarantee
    /// Outer bounds and what is inside or undecided are never drawn narrower than they are, inner bounds never
    /// wider: coordinates are rounded that way. Where a paving has more than two parameters, a point of the
    /// picture is shown as inside when it is proved to agree with some values of the others, and as outside when
    /// it is proved to agree with none. The same bounds give the same bytes.
    pub fn render_all(&self) -> Vec<Figure> {
        let mut figures = Vec::new();
        if !self.params.is_empty() {
            figures.push(Figure {
                name: "bounds".to_owned(),
                svg: self.draw_bounds(),
            });
        }
        figures.extend(self.draw_pavings());
        figures
    }
}
