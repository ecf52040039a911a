//! One pair of axes with its curves.

use crate::layout::{colour, series_attributes};
use crate::pen::{Anchor, At, Colour, GRID, INK, Pen};
use crate::ticks::{label, ticks};
use crate::{Panel, Point};

/// Opacity of a band.
pub(crate) const BAND: f64 = 0.18;
/// Width of a curve.
pub(crate) const LINE: f64 = 2.0;
const TICK_SIZE: f64 = 12.0;
/// Ends that differ by less than this share are equal.
const ROUNDING: f64 = 1e-5;
/// Fewer evaluations than this are marked by dots.
const DOTS: usize = 16;

/// Where the axes of a panel are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Frame {
    /// Leaves room for title, ticks and names around the axes.
    pub(crate) fn inside(x: f64, y: f64, (width, height): (f64, f64)) -> Self {
        Self { left: x + 68.0, right: x + width - 18.0, top: y + 30.0, bottom: y + height - 46.0 }
    }
}

/// Both axes' ranges: from 0 to the last step, and over all bands and lines with a little room.
struct Axes {
    frame: Frame,
    last_step: f64,
    low: f64,
    high: f64,
}

impl Axes {
    fn new(frame: &Frame, panel: &Panel) -> Self {
        let points = || {
            panel
                .series
                .iter()
                .flat_map(|series| &series.points)
                .filter(|point| point.is_drawable())
        };
        let thin = || panel.series.iter().flat_map(|series| series.thin.iter().flatten());
        let thin = || thin().filter(|at| is_finite(at));
        let values = || thin().map(|&[_, value]| value);
        let steps = points().map(|point| point.step).chain(thin().map(|&[step, _]| step));
        let last_step = steps.fold(0.0, f64::max);
        let low = points().map(|point| point.low).chain(values()).fold(f64::INFINITY, f64::min);
        let high =
            points().map(|point| point.high).chain(values()).fold(f64::NEG_INFINITY, f64::max);
        let limit = panel.limit;
        let (low, high) = widened(
            limit.map_or(low, |limit| low.min(limit)),
            limit.map_or(high, |limit| high.max(limit)),
        );
        let last_step = if last_step > 0.0 { last_step } else { 1.0 };
        Self { frame: *frame, last_step, low, high }
    }

    /// Where it is and what it spans, for a script that shows what is under the pointer.
    fn attributes(&self) -> [(&'static str, String); 3] {
        let Frame { left, right, top, bottom } = self.frame;
        [
            ("class", "panel".to_owned()),
            ("data-frame", format!("{left} {right} {top} {bottom}")),
            ("data-range", format!("{} {} {}", self.last_step, self.low, self.high)),
        ]
    }

    fn x(&self, step: f64) -> f64 {
        self.frame.left + (self.frame.right - self.frame.left) * step / self.last_step
    }

    fn y(&self, value: f64) -> f64 {
        self.frame.bottom
            - (self.frame.bottom - self.frame.top) * (value - self.low) / (self.high - self.low)
    }

    fn at(&self, step: f64, value: f64) -> At {
        (self.x(step), self.y(value))
    }
}

/// Room above and below; equal ends, or none at all, still need an axis.
fn widened(low: f64, high: f64) -> (f64, f64) {
    if low > high {
        return (0.0, 1.0);
    }
    let size = low.abs().max(high.abs());
    let room =
        if high - low > ROUNDING * size { 0.05 * (high - low) } else { (0.05 * size).max(0.5) };
    // An axis of positive numbers may end at 0, not below.
    let keep_sign = |end: f64, moved: f64| if end * moved < 0.0 { 0.0 } else { moved };
    (keep_sign(low, low - room), keep_sign(high, high + room))
}

/// Whether a thin line's step and value can be drawn.
fn is_finite(at: &[f64; 2]) -> bool {
    at.iter().all(|x| x.is_finite())
}

impl Point {
    pub(crate) fn is_drawable(&self) -> bool {
        self.middle.is_finite() && self.low.is_finite() && self.high.is_finite()
    }
}

/// Draws a panel: grid, bands, then lines on top of all bands.
pub(crate) fn draw(pen: &mut Pen, frame: &Frame, panel: &Panel) {
    let axes = Axes::new(frame, panel);
    pen.begin(axes.attributes());
    grid(pen, &axes);
    let curves: Vec<Vec<Point>> = panel
        .series
        .iter()
        .map(|series| series.points.iter().copied().filter(Point::is_drawable).collect())
        .collect();
    for (i, points) in curves.iter().enumerate() {
        pen.begin(series_attributes(i));
        band(pen, &axes, points, colour(i));
        pen.end();
    }
    for (i, (points, series)) in curves.iter().zip(&panel.series).enumerate() {
        pen.begin(series_attributes(i));
        thin(pen, &axes, &series.thin, colour(i));
        line(pen, &axes, points, colour(i));
        pen.end();
    }
    if let Some(limit) = panel.limit {
        dashes(pen, &axes, limit);
    }
    if curves.iter().all(Vec::is_empty) {
        let middle = (0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom));
        pen.word("nothing to draw", middle, 14.0, Anchor::Top);
    }
    names(pen, frame, panel);
    pen.end();
}

/// Thin lines under a curve.
fn thin(pen: &mut Pen, axes: &Axes, lines: &[Vec<[f64; 2]>], colour: Colour) {
    if lines.is_empty() {
        return;
    }
    pen.begin([("class", "thin".to_owned()), ("opacity", "0.55".to_owned())]);
    for line in lines {
        let drawable = line.iter().filter(|at| is_finite(at));
        let points: Vec<At> = drawable.map(|&[step, value]| axes.at(step, value)).collect();
        pen.line(&points, 0.5 * LINE, colour);
    }
    pen.end();
}

fn grid(pen: &mut Pen, axes: &Axes) {
    let Frame { left, right, top, bottom } = axes.frame;
    let largest = axes.low.abs().max(axes.high.abs());
    for value in ticks(axes.low, axes.high, 7) {
        let y = axes.y(value);
        pen.line(&[(left, y), (right, y)], 0.75, GRID);
        pen.word(&label(value, largest), (left - 7.0, y), TICK_SIZE, Anchor::Right);
    }
    for step in ticks(0.0, axes.last_step, 5) {
        let x = axes.x(step);
        pen.line(&[(x, top), (x, bottom)], 0.75, GRID);
        pen.word(&label(step, axes.last_step), (x, bottom + 6.0), TICK_SIZE, Anchor::Top);
    }
    pen.line(&[(left, top), (left, bottom), (right, bottom)], 1.0, INK);
}

fn band(pen: &mut Pen, axes: &Axes, points: &[Point], colour: Colour) {
    if points.len() < 2 {
        return;
    }
    let there = points.iter().map(|point| axes.at(point.step, point.high));
    let back = points.iter().rev().map(|point| axes.at(point.step, point.low));
    pen.fill(&there.chain(back).collect::<Vec<_>>(), colour, BAND);
}

fn line(pen: &mut Pen, axes: &Axes, points: &[Point], colour: Colour) {
    let points: Vec<At> = points.iter().map(|point| axes.at(point.step, point.middle)).collect();
    if points.len() > 1 {
        pen.line(&points, LINE, colour);
    }
    if points.len() < DOTS {
        for &at in &points {
            pen.dot(at, 1.6 * LINE, colour);
        }
    }
}

/// A dashed line across.
fn dashes(pen: &mut Pen, axes: &Axes, value: f64) {
    let y = axes.y(value);
    pen.dashes([(axes.frame.left, y), (axes.frame.right, y)], LINE, INK);
}

fn names(pen: &mut Pen, frame: &Frame, panel: &Panel) {
    let middle = 0.5 * (frame.left + frame.right);
    let centre = 0.5 * (frame.top + frame.bottom);
    pen.word(&panel.title, (middle, frame.top - 22.0), 14.0, Anchor::Top);
    pen.word(panel.along, (middle, frame.bottom + 24.0), TICK_SIZE, Anchor::Top);
    pen.word(&panel.unit, (frame.left - 58.0, centre), TICK_SIZE, Anchor::Turned);
}

#[cfg(test)]
mod tests {
    use super::widened;
    use crate::{Figure, Panel, Point, Series};

    /// A seed that has come further than the others has its line inside.
    #[test]
    fn thin_lines_stay_in_their_panel() {
        let mean = vec![Point::within(0.0, 1.0, 0.5), Point::within(10.0, 2.0, 0.5)];
        let seeds = vec![vec![[0.0, 1.0], [10.0, 2.0]], vec![[0.0, 1.0], [40.0, 2.0]]];
        let panel = Panel::new("return").series(Series::new("a", mean).thin(seeds));
        let svg = Figure::new("Two seeds", "").panel(panel).svg().unwrap();
        assert!(svg.contains("data-range=\"40 "), "{svg}");
    }

    #[test]
    fn an_axis_has_room_and_rounding_is_no_range() {
        assert_eq!(widened(1.0, 101.0), (0.0, 106.0));
        assert_eq!(widened(-100.0, 100.0), (-110.0, 110.0));
        let (low, high) = widened(41.99830, 41.99831);
        assert!(high - low > 4.0, "a flat curve is not a wall of digits: {low} to {high}");
        assert_eq!(widened(0.0, 0.0), (-0.5, 0.5));
        assert_eq!(widened(f64::INFINITY, f64::NEG_INFINITY), (0.0, 1.0));
    }
}
