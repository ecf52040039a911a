//! A plane with points, closed curves and arrows: two objectives against each other.

use std::path::Path;

use copq::{Error, Result, files};

use crate::animation::gif;
use crate::canvas;
use crate::layout::{colour, round, series_attributes};
use crate::pen::{Anchor, At, GRID, INK, Pen};
use crate::ticks::{label, ticks};

const WIDTH: u32 = 480;
/// Makes the axes as high as they are wide.
const HEIGHT: u32 = 512;
/// Room around the axes: left, right, top, bottom.
const ROOM: [f64; 4] = [72.0, 18.0, 44.0, 78.0];
const SMALL: f64 = 12.0;
/// Height of a row of the legend.
const ROW: f64 = 20.0;

/// What a [`Plane`] shows.
#[derive(Clone, Debug)]
pub(crate) enum Mark {
    /// Dots.
    Points(Vec<[f64; 2]>),
    /// A curve whose end meets its beginning.
    Closed(Vec<[f64; 2]>),
    /// A line from one place to another, with a dot at its end.
    Arrow([[f64; 2]; 2]),
    /// A dashed line.
    Line([[f64; 2]; 2]),
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
    pub(crate) limit: Option<f64>,
    pub(crate) ranges: Option<[[f64; 2]; 2]>,
}

impl Plane {
    /// An empty plane with its axes' names, across and up.
    pub fn new(title: impl Into<String>, axes: [&str; 2]) -> Self {
        let axes = axes.map(str::to_owned);
        Self { title: title.into(), axes, marks: Vec::new(), limit: None, ranges: None }
    }

    /// Shows only this range of each axis, whatever lies outside; by default, everything.
    pub fn ranges(self, ranges: [[f64; 2]; 2]) -> Self {
        Self { ranges: Some(ranges), ..self }
    }

    /// A vertical dashed line at a place of the first axis.
    pub fn limit(self, limit: f64) -> Self {
        Self { limit: Some(limit), ..self }
    }

    /// Adds dots; each mark has the next colour, and its name in the legend.
    pub fn points(self, label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        self.mark(label, Mark::Points(points))
    }

    /// Adds a curve whose end meets its beginning.
    pub fn closed(self, label: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        self.mark(label, Mark::Closed(points))
    }

    /// Adds a dashed line from one place to another.
    pub fn line(self, label: impl Into<String>, from_to: [[f64; 2]; 2]) -> Self {
        self.mark(label, Mark::Line(from_to))
    }

    /// Adds a line from one place to another, with a dot at its end.
    pub fn arrow(self, label: impl Into<String>, from_to: [[f64; 2]; 2]) -> Self {
        self.mark(label, Mark::Arrow(from_to))
    }

    fn mark(mut self, label: impl Into<String>, mark: Mark) -> Self {
        self.marks.push((label.into(), mark));
        self
    }

    /// The plane as SVG.
    pub fn svg(&self) -> Result<String> {
        let rows = self.legend(&Pen::new(1, 1)?);
        let last = rows.iter().map(|&(_, row)| row).max().unwrap_or(0);
        let mut pen = Pen::new(WIDTH, HEIGHT + (last as f64 * ROW) as u32)?;
        self.draw(&mut pen, &rows);
        Ok(pen.svg())
    }

    /// Writes the plane to a file, whose ending decides the format: `.svg` or `.png`.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        canvas::write(path.as_ref(), &self.svg()?)
    }

    /// Writes planes as an animated GIF, one after the other, each for this many hundredths of a
    /// second. Give them [`Plane::ranges`], and marks with the same names.
    pub fn write_gif(planes: &[Self], hundredths: u16, path: impl AsRef<Path>) -> Result<()> {
        let [first, ..] = planes else {
            return Err(Error::invalid("pictures of an animation", "at least one", 0));
        };
        let (width, height, _) = canvas::pixels(&first.svg()?)?;
        let mut picture = |i: usize| match canvas::pixels(&planes[i].svg()?)? {
            (w, h, pixels) if (w, h) == (width, height) => Ok(pixels),
            (w, h, _) => {
                let wanted = format!("{width} x {height} pixels");
                Err(Error::invalid("a picture of an animation", wanted, format!("{w} x {h}")))
            }
        };
        let delays = vec![u64::from(hundredths); planes.len()];
        files::replace(path.as_ref(), &gif::encode([width, height], &delays, &mut picture)?)
    }

    /// Where each mark's name begins, and in which row.
    fn legend(&self, pen: &Pen) -> Vec<(f64, usize)> {
        let [left, right, ..] = ROOM;
        let end = f64::from(WIDTH) - right;
        let mut at = (left, 0);
        let mut places = Vec::new();
        for (name, mark) in &self.marks {
            if mark.is_empty() {
                places.push(at);
                continue;
            }
            let width = 30.0 + pen.width(name, SMALL);
            if at.0 + width > end && at.0 > left {
                at = (left, at.1 + 1);
            }
            places.push(at);
            at.0 += width;
        }
        places
    }

    fn draw(&self, pen: &mut Pen, legend: &[(f64, usize)]) {
        let axes = Axes::new([0, 1].map(|axis| self.range(axis)));
        let size = pen.fitted(&self.title, 16.0, f64::from(WIDTH) - 20.0);
        pen.word(&self.title, (f64::from(WIDTH) / 2.0, 12.0), size, Anchor::Top);
        axes.draw(pen, &self.axes);
        if let Some(limit) = self.limit {
            let (across, _) = axes.at([limit, axes.ranges[1][0]]);
            let [_, _, top, bottom] = axes.frame;
            pen.dashes([(across, top), (across, bottom)], 1.5, INK);
        }
        pen.begin_clipped(axes.frame);
        for (n, (_, mark)) in self.marks.iter().enumerate() {
            pen.begin(series_attributes(n));
            mark.draw(pen, &axes, n);
            pen.end();
        }
        pen.end();
        for (n, ((name, mark), &(x, row))) in self.marks.iter().zip(legend).enumerate() {
            if mark.is_empty() {
                continue;
            }
            let y = f64::from(HEIGHT) - 18.0 + row as f64 * ROW;
            pen.begin(series_attributes(n));
            spot(pen, (x + 5.0, y), 5.0, n);
            let room = f64::from(WIDTH) - x - 20.0;
            pen.word(name, (x + 15.0, y), pen.fitted(name, SMALL, room), Anchor::Left);
            pen.end();
        }
    }

    /// An axis's range: from the smallest to the largest of what is shown, with a little room.
    fn range(&self, axis: usize) -> [f64; 2] {
        if let Some(ranges) = self.ranges {
            return ranges[axis];
        }
        let mut low = f64::INFINITY;
        let mut high = f64::NEG_INFINITY;
        let limit = self.limit.filter(|_| axis == 0);
        for value in self.places().map(|place| place[axis]).chain(limit) {
            if value.is_finite() {
                low = low.min(value);
                high = high.max(value);
            }
        }
        if low > high {
            return [0.0, 1.0];
        }
        let size = low.abs().max(high.abs());
        // Ends that differ by rounding alone are equal.
        let room =
            if high - low > 1e-5 * size { 0.08 * (high - low) } else { (0.05 * size).max(0.5) };
        [low - room, high + room]
    }

    /// Every place that is shown.
    pub(crate) fn places(&self) -> impl Iterator<Item = [f64; 2]> {
        self.marks.iter().flat_map(|(_, mark)| match mark {
            Mark::Points(points) | Mark::Closed(points) => points.clone(),
            Mark::Arrow(from_to) | Mark::Line(from_to) => from_to.to_vec(),
        })
    }
}

impl Mark {
    /// Whether none of it can be seen.
    fn is_empty(&self) -> bool {
        matches!(self, Self::Points(points) if !points.iter().any(is_finite))
    }

    fn draw(&self, pen: &mut Pen, axes: &Axes, n: usize) {
        let colour = colour(n);
        match self {
            Self::Points(points) => {
                points
                    .iter()
                    .filter(|at| is_finite(at))
                    .for_each(|&at| spot(pen, axes.at(at), 3.5, n));
            }
            Self::Closed(points) => {
                let edge = points.iter().chain(points.first());
                let edge: Vec<At> = edge.map(|&point| axes.at(point)).collect();
                pen.fill(&edge, colour, 0.1);
                pen.line(&edge, 1.5, colour);
            }
            Self::Arrow([from, to]) => {
                pen.line(&[axes.at(*from), axes.at(*to)], 2.0, colour);
                pen.dot(axes.at(*to), 4.0, colour);
            }
            Self::Line(from_to) => pen.dashes(from_to.map(|end| axes.at(end)), 1.5, colour),
        }
    }
}

fn is_finite(at: &[f64; 2]) -> bool {
    at.iter().all(|x| x.is_finite())
}

/// The n-th mark's dot: a disc, and when all colours are used up a ring, a square, a diamond.
fn spot(pen: &mut Pen, (x, y): At, r: f64, n: usize) {
    let square = [(x - r, y - r), (x + r, y - r), (x + r, y + r), (x - r, y + r)];
    let diamond = [(x - r, y), (x, y - r), (x + r, y), (x, y + r)];
    match round(n) % 4 {
        0 => pen.dot((x, y), r, colour(n)),
        1 => {
            pen.dot((x, y), r, colour(n));
            pen.dot((x, y), 0.55 * r, [255; 3]);
        }
        2 => pen.fill(&square, colour(n), 1.0),
        _ => pen.fill(&diamond, colour(n), 1.0),
    }
}

/// Where the axes are (left, right, top, bottom), and what they span.
struct Axes {
    frame: [f64; 4],
    ranges: [[f64; 2]; 2],
}

impl Axes {
    fn new(ranges: [[f64; 2]; 2]) -> Self {
        let [left, right, top, bottom] = ROOM;
        let frame = [left, f64::from(WIDTH) - right, top, f64::from(HEIGHT) - bottom];
        Self { frame, ranges }
    }

    fn at(&self, [x, y]: [f64; 2]) -> At {
        let [left, right, top, bottom] = self.frame;
        let share = |value: f64, [low, high]: [f64; 2]| (value - low) / (high - low);
        let [across, up] = self.ranges;
        (left + (right - left) * share(x, across), bottom - (bottom - top) * share(y, up))
    }

    /// Draws a grid, and the axes with their names.
    fn draw(&self, pen: &mut Pen, names: &[String; 2]) {
        let [left, right, top, bottom] = self.frame;
        let [[first, last], [low, high]] = self.ranges;
        for x in ticks(first, last, 5) {
            let (across, _) = self.at([x, low]);
            pen.line(&[(across, top), (across, bottom)], 0.75, GRID);
            pen.word(&label(x, x), (across, bottom + 6.0), SMALL, Anchor::Top);
        }
        for y in ticks(low, high, 6) {
            let (_, up) = self.at([first, y]);
            pen.line(&[(left, up), (right, up)], 0.75, GRID);
            pen.word(&label(y, y), (left - 7.0, up), SMALL, Anchor::Right);
        }
        pen.line(&[(left, top), (left, bottom), (right, bottom)], 1.0, INK);
        pen.word(&names[0], (0.5 * (left + right), bottom + 24.0), SMALL, Anchor::Top);
        pen.word(&names[1], (14.0, 0.5 * (top + bottom)), SMALL, Anchor::Turned);
    }
}
