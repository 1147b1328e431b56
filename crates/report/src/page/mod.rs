//! One page that shows a run: verdict, numbers, plots that can be zoomed, and what was assumed.
//!
//! The page is a single file and asks for nothing: style, plotting library and data are in it, and its own policy
//! forbids the browser to load anything else. Texts are escaped by the template (`maud`), so that names and model
//! files may contain anything.

mod pack;
mod plots;

pub use plots::Plots;

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// plotly.js, compressed, as text.
const LIBRARY: &str = include_str!(concat!(env!("OUT_DIR"), "/plotly.js.gz.base64"));
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 4] = [
    include_str!("numbers.js"),
    include_str!("ribbon.js"),
    include_str!("paving.js"),
    include_str!("page.js"),
];

/// What the browser may use: what is in the page, and nothing else.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:";

/// All that is shown of a run. Texts are plain: they are escaped when the page is made.
///
/// ```
/// use veribound_report::{Block, Entry, Page, Section, Table, Tone, Value};
///
/// let value = |text: &str, at: &str| Value { text: text.to_owned(), at: at.to_owned() };
/// let bounds = Entry::Bounds(value("0.9", "/parameters/k/lo"), value("1.1", "/parameters/k/hi"));
/// let table = Table {
///     head: vec!["parameter".to_owned(), "proved bounds".to_owned()],
///     rows: vec![vec![Entry::Text("k".to_owned()), bounds]],
/// };
/// let page = Page {
///     title: "decay".to_owned(),
///     headline: "Consistent".to_owned(),
///     tone: Tone::Bounds,
///     before: vec![Section { title: "Bounds".to_owned(), blocks: vec![Block::Table(table)] }],
///     ..Page::default()
/// };
/// assert!(page.render().contains("<data data-at=\"/parameters/k/lo\">0.9</data>"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Name of what was looked at: the model.
    pub title: String,
    /// What was done with it, as `observe`.
    pub task: String,
    /// What is proved, in a few words.
    pub headline: String,
    /// How the page looks at it.
    pub tone: Tone,
    /// Sentences below the headline.
    pub sentences: Vec<String>,
    /// What stands before the plots.
    pub before: Vec<Section>,
    /// The plots.
    pub plots: Plots,
    /// What stands after the plots.
    pub after: Vec<Section>,
    /// The program and its version.
    pub program: String,
}

/// What a verdict says to the eye.
///
/// Example: [`Page`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// Bounds were proved.
    Bounds,
    /// Model and record were proved to contradict each other.
    Refuted,
    /// Something was not decided.
    #[default]
    Open,
}

/// A part of the page under its own heading.
///
/// Example: [`Page`].
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// The heading.
    pub title: String,
    /// What stands below it.
    pub blocks: Vec<Block>,
}

/// A piece of a section.
///
/// Example: [`Page`].
#[derive(Clone, Debug)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// Sentences, one below the other.
    List(Vec<String>),
    /// Names and what they stand for.
    Facts(Vec<(String, Entry)>),
    /// A table.
    Table(Table),
    /// A text as it is, folded away behind the title where there is one.
    Listing {
        /// What it is.
        title: Option<String>,
        /// The text.
        text: String,
    },
}

/// Rows of entries below a head.
///
/// Example: [`Page`].
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// Titles of the columns.
    pub head: Vec<String>,
    /// One entry for every column.
    pub rows: Vec<Vec<Entry>>,
}

/// An entry of a table.
///
/// Example: [`Page`].
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// Words.
    Text(String),
    /// A number of the summary.
    Value(Value),
    /// Bounds of the summary.
    Bounds(Value, Value),
    /// A picture of bounds inside others.
    Bar {
        /// The prior.
        prior: (f64, f64),
        /// Proved to hold all values.
        outer: Option<(f64, f64)>,
        /// Proved to be reached.
        inner: Option<(f64, f64)>,
    },
}

/// A number as the summary prints it.
///
/// Example: [`Page`].
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Its digits.
    pub text: String,
    /// Where it stands in the summary: a JSON pointer such as `/parameters/k/lo`.
    pub at: String,
}

impl Page {
    /// The page as HTML.
    ///
    /// # Guarantee
    /// Numbers are shown as they were given, to the digit. A band is never drawn narrower than the bounds given
    /// for it: the page keeps bounds as floats, bit by bit, joins samples that share a column of the picture into
    /// the hull of their bounds, and rounds numbers that it prints outward. The same page gives the same bytes.
    pub fn render(&self) -> String {
        let title = format!("{}: {}", self.title, self.task);
        let tone = match self.tone {
            Tone::Bounds => "bounds",
            Tone::Refuted => "refuted",
            Tone::Open => "open",
        };
        let plots = self.plots.json();
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    main {
                        header class=(tone) {
                            p.task { (self.task) " · " (self.title) }
                            h1 { (self.headline) }
                            @for sentence in &self.sentences { p { (sentence) } }
                        }
                        @for section in &self.before { (section.markup()) }
                        @if !self.plots.is_empty() {
                            nav #tools aria-label="Time shown" {}
                            div #plots { noscript { p { "The plots need JavaScript." } } }
                        }
                        @for section in &self.after { (section.markup()) }
                        footer {
                            p { (self.program) ". Plots: plotly.js, MIT licence. This page is complete: it loads nothing." }
                        }
                    }
                    @if !self.plots.is_empty() {
                        script #meta type="application/json" { (PreEscaped(plots)) }
                        script #data type="text/plain" { (PreEscaped(self.plots.packed())) }
                        script #library type="text/plain" { (PreEscaped(LIBRARY)) }
                        script { @for part in SCRIPTS { (PreEscaped(part)) } }
                    }
                }
            }
        };
        page.into_string()
    }
}

impl Section {
    fn markup(&self) -> Markup {
        html! {
            section {
                h2 { (self.title) }
                @for block in &self.blocks { (block.markup()) }
            }
        }
    }
}

impl Block {
    fn markup(&self) -> Markup {
        html! {
            @match self {
                Block::Text(text) => { p { (text) } }
                Block::List(lines) => { ul { @for line in lines { li { (line) } } } }
                Block::Facts(facts) => {
                    dl { @for (name, entry) in facts { dt { (name) } dd { (entry.markup()) } } }
                }
                Block::Table(table) if table.rows.len() > MANY => {
                    details {
                        summary {
                            (table.rows.len()) " rows"
                            @if let Some(title) = table.head.first() { ": " (title) }
                        }
                        (table.markup())
                    }
                }
                Block::Table(table) => { (table.markup()) }
                Block::Listing {
                    title: Some(title),
                    text,
                } => {
                    details { summary { (title) } pre { (text) } }
                }
                Block::Listing { title: None, text } => { pre { (text) } }
            }
        }
    }
}

/// Tables with more rows are folded.
const MANY: usize = 24;

impl Table {
    fn markup(&self) -> Markup {
        html! {
            div.wide { table {
                thead { tr { @for title in &self.head { th scope="col" { (title) } } } }
                tbody { @for row in &self.rows { tr {
                    @for (at, entry) in row.iter().enumerate() {
                        @if at == 0 { th scope="row" { (entry.markup()) } } @else { td { (entry.markup()) } }
                    }
                } } }
            } }
        }
    }
}

/// Width of the picture of bounds, in units of its own.
const BAR: f64 = 120.0;
/// Least width at which bounds are still seen.
const SEEN: f64 = 1.5;

impl Entry {
    fn markup(&self) -> Markup {
        let value = |value: &Value| html! { data data-at=(value.at) { (value.text) } };
        match self {
            Entry::Text(text) => html! { (text) },
            Entry::Value(number) => value(number),
            Entry::Bounds(lo, hi) => html! { span.range { "[" (value(lo)) ", " (value(hi)) "]" } },
            Entry::Bar {
                prior,
                outer,
                inner,
            } => bar(*prior, *outer, *inner),
        }
    }
}

/// Bounds inside the prior: the outer ones are never drawn narrower than they are, the inner ones never wider.
fn bar(prior: (f64, f64), outer: Option<(f64, f64)>, inner: Option<(f64, f64)>) -> Markup {
    let width = prior.1 - prior.0;
    if !(width > 0.0 && width.is_finite()) {
        return html! {};
    }
    let place = |x: f64| ((x - prior.0) / width).clamp(0.0, 1.0) * BAR;
    let tenths = |x: f64| format!("{:.1}", x / 10.0);
    let outer = outer.map(|(lo, hi)| {
        let (lo, hi) = ((place(lo) * 10.0).floor(), (place(hi) * 10.0).ceil());
        let missing = (SEEN * 10.0 - (hi - lo)).max(0.0);
        let lo = (lo - missing / 2.0).clamp(0.0, (BAR - SEEN) * 10.0);
        (tenths(lo), tenths((hi - lo).max(SEEN * 10.0)))
    });
    let inner = inner.and_then(|(lo, hi)| {
        let (lo, hi) = ((place(lo) * 10.0).ceil(), (place(hi) * 10.0).floor());
        (hi > lo).then(|| (tenths(lo), tenths(hi - lo)))
    });
    html! {
        svg.bar viewBox=(format!("0 0 {BAR} 12")) role="img" aria-label="bounds inside the prior" {
            rect.prior x="0" y="4" width=(BAR) height="4" {}
            @if let Some((x, width)) = outer { rect.outer x=(x) y="1" width=(width) height="10" {} }
            @if let Some((x, width)) = inner { rect.inner x=(x) y="3.5" width=(width) height="5" {} }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outer_bounds_are_drawn_outward_and_inner_ones_inward() {
        let drawn = bar((0.0, 120.0), Some((10.04, 20.06)), Some((10.04, 20.06))).into_string();
        assert!(
            drawn.contains(r#"class="outer" x="10.0" y="1" width="10.1""#),
            "{drawn}"
        );
        assert!(
            drawn.contains(r#"class="inner" x="10.1" y="3.5" width="9.9""#),
            "{drawn}"
        );
        let thin = bar((0.0, 120.0), Some((120.0, 120.0)), Some((120.0, 120.0))).into_string();
        assert!(
            thin.contains(r#"class="outer" x="118.5" y="1" width="1.5""#),
            "{thin}"
        );
        assert!(!thin.contains("inner"), "{thin}");
        assert_eq!(bar((0.0, f64::INFINITY), None, None).into_string(), "");
    }

    #[test]
    fn texts_cannot_leave_their_place() {
        let evil = "</script><script>alert(1)</script>&\"'";
        let page = Page {
            title: evil.to_owned(),
            headline: evil.to_owned(),
            sentences: vec![evil.to_owned()],
            before: vec![Section {
                title: evil.to_owned(),
                blocks: vec![
                    Block::List(vec![evil.to_owned()]),
                    Block::Facts(vec![(evil.to_owned(), Entry::Text(evil.to_owned()))]),
                    Block::Listing {
                        title: Some(evil.to_owned()),
                        text: evil.to_owned(),
                    },
                    Block::Table(Table {
                        head: vec![evil.to_owned()],
                        rows: vec![vec![Entry::Value(Value {
                            text: evil.to_owned(),
                            at: evil.to_owned(),
                        })]],
                    }),
                ],
            }],
            ..Page::default()
        };
        let text = page.render();
        assert!(!text.contains("alert(1)</script>"), "{text}");
        assert!(!text.contains("<script"), "{text}");
        assert_eq!(
            text.matches("&lt;/script&gt;&lt;script&gt;alert(1)")
                .count(),
            13
        );
    }
}
