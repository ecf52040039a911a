//! What a figure shows.

use std::path::Path;

use copq::Result;

use crate::pen::Pen;
use crate::{canvas, layout};

/// A line with a band around it.
///
/// ```
/// use copq_render::{Figure, Panel, Point, Series};
///
/// let to = |last| vec![Point::within(0.0, 0.0, 0.5), Point::within(1_000.0, last, 0.5)];
/// let panel = Panel::new("return")
///     .series(Series::new("cholesky", to(20.0)))
///     .series(Series::new("extremum", to(10.0)));
/// let svg = Figure::new("Two projections", "Band: half a unit.").panel(panel).svg()?;
/// assert!(svg.contains("#0072b2") && svg.contains("#d55e00")); // blue and vermilion
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Series {
    pub(crate) label: String,
    pub(crate) points: Vec<Point>,
    pub(crate) thin: Vec<Vec<[f64; 2]>>,
}

impl Series {
    /// A curve with its name in the legend.
    pub fn new(label: impl Into<String>, points: Vec<Point>) -> Self {
        Self { label: label.into(), points, thin: Vec::new() }
    }

    /// Whether any of it can be seen.
    pub(crate) fn is_drawn(&self) -> bool {
        self.points.iter().any(Point::is_drawable) || self.thin.iter().any(|line| !line.is_empty())
    }

    /// With thin lines of the same colour under it, such as one per seed: steps and values.
    pub fn thin(self, thin: Vec<Vec<[f64; 2]>>) -> Self {
        Self { thin, ..self }
    }
}

/// One evaluation, or the same evaluation of several seeds.
///
/// ```
/// use copq_render::Point;
///
/// let point = Point::within(5_000.0, 20.0, 3.0);
/// assert_eq!((point.low, point.middle, point.high), (17.0, 20.0, 23.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Its place on the axis of steps.
    pub step: f64,
    /// Where the line goes.
    pub middle: f64,
    /// The band's lower edge.
    pub low: f64,
    /// The band's upper edge.
    pub high: f64,
}

impl Point {
    /// A point with a band of half-width `margin`.
    pub fn within(step: f64, middle: f64, margin: f64) -> Self {
        Self { step, middle, low: middle - margin, high: middle + margin }
    }
}

/// One pair of axes.
///
/// ```
/// use copq_render::{Figure, Panel, Point, Series};
///
/// let points = vec![Point::within(0.0, 10.0, 1.0), Point::within(1.0, 30.0, 1.0)];
/// let cost = Panel::new("cost").series(Series::new("cop-cal", points));
/// let svg = |panel| Figure::new("A cost", "Dashed: its limit.").panel(panel).svg();
/// let plain = svg(cost.clone())?;
/// let limited = svg(cost.limit(Some(25.0)))?;
/// assert!(limited.len() > plain.len()); // by the dashes
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Panel {
    pub(crate) title: String,
    pub(crate) unit: String,
    pub(crate) along: &'static str,
    pub(crate) limit: Option<f64>,
    pub(crate) series: Vec<Series>,
}

impl Panel {
    /// Empty axes with a title.
    pub fn new(title: impl Into<String>) -> Self {
        let unit = "return of an episode".to_owned();
        let along = "environment steps";
        Self { title: title.into(), unit, along, limit: None, series: Vec::new() }
    }

    /// What its values are, written beside their axis; returns by default.
    pub fn unit(self, unit: impl Into<String>) -> Self {
        Self { unit: unit.into(), ..self }
    }

    /// What is written under its axis; environment steps by default.
    pub fn along(self, along: &'static str) -> Self {
        Self { along, ..self }
    }

    /// A dashed line across.
    pub fn limit(self, limit: Option<f64>) -> Self {
        Self { limit, ..self }
    }

    /// Adds a curve; the n-th one of every panel has the same colour.
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }
}

/// Panels that share their axes' names, their colours and one legend.
///
/// ```
/// use copq_render::{Figure, Panel};
///
/// let empty = Figure::new("Nothing yet", "").panel(Panel::new("return"));
/// assert!(empty.png()?.starts_with(b"\x89PNG"));
/// let error = empty.write("curves.pdf").unwrap_err(); // curves.svg or curves.png would do
/// let words = "figure's file: wanted a name that ends in .svg or .png, got curves.pdf";
/// assert_eq!(error.to_string(), words);
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Figure {
    pub(crate) title: String,
    pub(crate) note: String,
    pub(crate) columns: Option<usize>,
    pub(crate) panels: Vec<Panel>,
}

impl Figure {
    /// An empty figure; the note, in small print under the title, says what line and band mean.
    pub fn new(title: impl Into<String>, note: impl Into<String>) -> Self {
        Self { title: title.into(), note: note.into(), columns: None, panels: Vec::new() }
    }

    /// Puts the panels in this many columns; by default, in at most three.
    pub fn columns(self, columns: usize) -> Self {
        Self { columns: Some(columns.max(1)), ..self }
    }

    /// Adds a panel.
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// The figure as SVG.
    pub fn svg(&self) -> Result<String> {
        let (width, height) = layout::size(self);
        let mut pen = Pen::new(width, height)?;
        layout::draw(&mut pen, self);
        Ok(pen.svg())
    }

    /// The figure as the bytes of a PNG file, two pixels per unit of the layout.
    pub fn png(&self) -> Result<Vec<u8>> {
        canvas::rasterise(&self.svg()?)
    }

    /// Writes the figure to a file, whose ending decides the format: `.svg` or `.png`.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        canvas::write(path.as_ref(), &self.svg()?)
    }
}
