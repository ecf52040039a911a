//! A plane with points, closed curves and arrows: two objectives against each other.

use std::path::Path;

use copq::{Result, files};

use crate::canvas;

/// What a [`Plane`] shows.
#[derive(Clone, Debug)]
pub(crate) enum Mark {
    /// Dots.
    Points(Vec<[f64; 2]>),
    /// A curve whose end meets its beginning.
    Closed(Vec<[f64; 2]>),
    /// A line from one place to another, with a dot at its end.
    Arrow([[f64; 2]; 2]),
}

/// Points, closed curves and arrows in the plane of two quantities.
///
/// ```
/// use copq_render::Plane;
///
/// let plane = Plane::new("Two critics", ["safety", "speed"])
///     .points("critics", vec![[1.0, 2.0], [3.0, 1.0]])
///     .arrow("bound", [[2.0, 1.5], [1.0, 1.0]]);
/// assert!(plane.svg()?.starts_with("<svg"));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Plane {
    pub(crate) title: String,
    pub(crate) axes: [String; 2],
    pub(crate) marks: Vec<(String, Mark)>,
}

impl Plane {
    /// An empty plane with its axes' names, across and up.
    pub fn new(title: impl Into<String>, axes: [&str; 2]) -> Self {
        Self { title: title.into(), axes: axes.map(str::to_owned), marks: Vec::new() }
    }

    /// Adds dots; each mark has the next colour, and its name in the legend.
    pub fn points(self, label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        self.mark(label, Mark::Points(points))
    }

    /// Adds a curve whose end meets its beginning.
    pub fn closed(self, label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        self.mark(label, Mark::Closed(points))
    }

    /// Adds a line from one place to another.
    pub fn arrow(self, label: impl Into<String>, from_to: [[f64; 2]; 2]) -> Self {
        self.mark(label, Mark::Arrow(from_to))
    }

    fn mark(mut self, label: impl Into<String>, mark: Mark) -> Self {
        self.marks.push((label.into(), mark));
        self
    }

    /// The plane as SVG.
    pub fn svg(&self) -> Result<String> {
        canvas::plane_svg(self)
    }

    /// Writes the plane as SVG.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::replace(path.as_ref(), self.svg()?.as_bytes())
    }

    /// Every place that is shown.
    pub(crate) fn places(&self) -> impl Iterator<Item = [f64; 2]> {
        self.marks.iter().flat_map(|(_, mark)| match mark {
            Mark::Points(points) | Mark::Closed(points) => points.clone(),
            Mark::Arrow(from_to) => from_to.to_vec(),
        })
    }
}
