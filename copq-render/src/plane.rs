//! A plane with points, closed curves and arrows: two objectives against each other.

use std::path::Path;

use copq::{Result, files};

use crate::layout::colour;
use crate::pen::{Anchor, At, GRID, INK, Pen};
use crate::ticks::{label, ticks};

const WIDTH: u32 = 480;
const HEIGHT: u32 = 460;
/// Room around the axes: left, right, top, bottom.
const ROOM: [f64; 4] = [72.0, 18.0, 44.0, 78.0];
const SMALL: f64 = 12.0;

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
        let mut pen = Pen::new(WIDTH, HEIGHT)?;
        self.draw(&mut pen);
        Ok(pen.svg())
    }

    /// Writes the plane as SVG.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::replace(path.as_ref(), self.svg()?.as_bytes())
    }

    fn draw(&self, pen: &mut Pen) {
        let axes = [0, 1].map(|axis| self.range(axis));
        let [left, right, top, bottom] = ROOM;
        let right = f64::from(WIDTH) - right;
        let bottom = f64::from(HEIGHT) - bottom;
        let share = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        let at = |[x, y]: [f64; 2]| -> At {
            (left + (right - left) * share(x, axes[0]), bottom - (bottom - top) * share(y, axes[1]))
        };
        pen.word(&self.title, (f64::from(WIDTH) / 2.0, 12.0), 16.0, Anchor::Top);
        for x in ticks(axes[0][0], axes[0][1], 5) {
            let (across, _) = at([x, axes[1][0]]);
            pen.line(&[(across, top), (across, bottom)], 0.75, GRID);
            pen.word(&label(x, x), (across, bottom + 6.0), SMALL, Anchor::Top);
        }
        for y in ticks(axes[1][0], axes[1][1], 6) {
            let (_, up) = at([axes[0][0], y]);
            pen.line(&[(left, up), (right, up)], 0.75, GRID);
            pen.word(&label(y, y), (left - 7.0, up), SMALL, Anchor::Right);
        }
        pen.line(&[(left, top), (left, bottom), (right, bottom)], 1.0, INK);
        pen.word(&self.axes[0], (0.5 * (left + right), bottom + 24.0), SMALL, Anchor::Top);
        pen.word(&self.axes[1], (14.0, 0.5 * (top + bottom)), SMALL, Anchor::Turned);
        let mut legend = left;
        for (n, (name, mark)) in self.marks.iter().enumerate() {
            match mark {
                Mark::Points(points) => {
                    points.iter().for_each(|&point| pen.dot(at(point), 3.0, colour(n)))
                }
                Mark::Closed(points) => {
                    let edge: Vec<At> =
                        points.iter().chain(points.first()).map(|&point| at(point)).collect();
                    pen.fill(&edge, colour(n), 0.1);
                    pen.line(&edge, 1.5, colour(n));
                }
                Mark::Arrow([from, to]) => {
                    pen.line(&[at(*from), at(*to)], 2.0, colour(n));
                    pen.dot(at(*to), 4.0, colour(n));
                }
            }
            let row = f64::from(HEIGHT) - 18.0;
            pen.dot((legend + 5.0, row), 5.0, colour(n));
            pen.word(name, (legend + 15.0, row), SMALL, Anchor::Left);
            legend += 30.0 + pen.width(name, SMALL);
        }
    }

    /// An axis from the smallest to the largest of what is shown, with a little room.
    fn range(&self, axis: usize) -> [f64; 2] {
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        for place in self.places().filter(|place| place[axis].is_finite()) {
            low = low.min(place[axis]);
            high = high.max(place[axis]);
        }
        if low > high {
            return [0.0, 1.0];
        }
        let room = if high > low { 0.08 * (high - low) } else { 0.5 };
        [low - room, high + room]
    }

    /// Every place that is shown.
    pub(crate) fn places(&self) -> impl Iterator<Item = [f64; 2]> {
        self.marks.iter().flat_map(|(_, mark)| match mark {
            Mark::Points(points) | Mark::Closed(points) => points.clone(),
            Mark::Arrow(from_to) => from_to.to_vec(),
        })
    }
}
