//! What the figures of a run are about: names, units, priors, and which window is zoomed.

use std::ops::Range;

/// A named quantity with its unit, as the axis shows it: `name [unit]`.
///
/// ```
/// use veribound_report::Quantity;
///
/// assert_eq!(Quantity::new("omega", "rad/s").label(), "omega [rad/s]");
/// assert_eq!(Quantity::new("share", "").label(), "share");
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quantity {
    /// Name as in the model file.
    pub name: String,
    /// Unit as in the model file; empty for none.
    pub unit: String,
}

impl Quantity {
    /// A quantity from its name and unit.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            unit: unit.into(),
        }
    }

    /// The axis label, `name [unit]`, or the name alone where there is no unit.
    pub fn label(&self) -> String {
        if self.unit.is_empty() {
            self.name.clone()
        } else {
            format!("{} [{}]", self.name, self.unit)
        }
    }
}

/// A parameter: what its panel shows beside the proved band.
///
/// Example: [`FigureMeta`].
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name and unit.
    pub quantity: Quantity,
    /// Prior bounds, drawn dotted; infinite where there is none.
    pub prior: (f64, f64),
    /// A value for orientation, drawn dashed; never part of a proof.
    pub nominal: Option<f64>,
}

/// Which stretch of time the inset of the output figure shows in full resolution.
///
/// Example: [`FigureMeta`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Zoom {
    /// The stretch of 31 samples where the proved band is narrowest against the measured one while
    /// the output moves by a few band widths.
    #[default]
    Auto,
    /// From the first to the second time, in the figures' time unit.
    Window(f64, f64),
    /// No inset.
    Off,
}

/// Names, units and options of all figures of one run.
///
/// ```
/// use veribound_report::{Figure, FigureMeta, History, Parameter, Quantity, ReportError, SampleRow, Zoom};
///
/// let mass = Parameter { quantity: Quantity::new("m", "kg"), prior: (0.5, 5.0), nominal: Some(2.0) };
/// let meta = FigureMeta { params: vec![mass], zoom: Zoom::Off, ..FigureMeta::default() };
/// let mut history = History::new(meta);
/// history.push(&SampleRow { t: 0.0, params: &[(1.0, 3.0)], ..SampleRow::default() })?;
/// let earlier = history.push(&SampleRow { t: 0.0, params: &[(1.5, 2.5)], ..SampleRow::default() });
/// assert_eq!(earlier, Err(ReportError::TimeNotIncreasing { before: 0.0, found: 0.0 }));
/// let figures: Vec<Figure> = history.render_all();
/// assert_eq!(figures[0].name, "params");
/// # Ok::<(), ReportError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FigureMeta {
    /// Title of the run: in the SVG's title element, for screen readers and tool tips, not drawn.
    pub title: String,
    /// What this run is called in a legend where two runs are compared.
    pub label: String,
    /// Unit of the time axis.
    pub time_unit: String,
    /// Outputs, in the order of `SampleRow::outputs` and `SampleRow::measured`.
    pub outputs: Vec<Quantity>,
    /// States, in the order of `SampleRow::states`.
    pub states: Vec<Quantity>,
    /// Parameters, in the order of `SampleRow::params` and `SampleRow::resets`.
    pub params: Vec<Parameter>,
    /// Modes, in the order of `SampleRow::modes`.
    pub modes: Vec<String>,
    /// Positions in `modes` of those of which one acts at a time; where none is given, all together.
    pub mode_groups: Vec<Range<usize>>,
    /// Stretch of time that the output figure zooms.
    pub zoom: Zoom,
    /// Time between two samples in milliseconds, drawn as the deadline of the work; `None` draws none.
    pub sample_time_ms: Option<f64>,
    /// Most columns kept for each series, 8 to 100 000: memory is proportional to it, whatever the
    /// length of the record.
    pub columns: usize,
    /// Whether finer columns are kept beside them, for a page that can be zoomed: up to 100 000, less where there
    /// are many series.
    pub page: bool,
}

impl Default for FigureMeta {
    fn default() -> Self {
        Self {
            title: String::new(),
            label: "this run".to_owned(),
            time_unit: "s".to_owned(),
            outputs: Vec::new(),
            states: Vec::new(),
            params: Vec::new(),
            modes: Vec::new(),
            mode_groups: Vec::new(),
            zoom: Zoom::Auto,
            sample_time_ms: None,
            columns: 4000,
            page: false,
        }
    }
}
