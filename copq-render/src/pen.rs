//! Lines, bands and words in layout units, on a sheet that becomes an SVG.

use ab_glyph::{Font, FontRef, ScaleFont};
use copq::{Error, Result};
use svg::node::element::{Circle, ClipPath, Group, Polygon, Polyline, Rectangle, Text};
use svg::{Document, Node};

use crate::font::{DEJAVU_SANS, FAMILY};

/// A position in layout units, from the upper left corner.
pub(crate) type At = (f64, f64);

/// Red, green and blue.
pub(crate) type Colour = [u8; 3];

/// Dark grey, for words and frames.
pub(crate) const INK: Colour = [45, 45, 45];
/// Light grey, for grids.
pub(crate) const GRID: Colour = [226, 226, 226];
/// Longest dashed line.
const FARTHEST: f64 = 1e5;
/// Length of a dash, and of the gap after it.
const DASH: f64 = 6.0;
/// How far below a word's middle its baseline lies, as a share of its size, and how far below its
/// upper edge.
const MIDDLE: f64 = 0.36;
const ASCENT: f64 = 0.9;

/// Which point of a word is at its position.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Anchor {
    /// The middle of its left edge.
    Left,
    /// The middle of its right edge.
    Right,
    /// The middle of its upper edge.
    Top,
    /// Its centre, the word turned to read upwards.
    Turned,
}

/// Draws on a white sheet.
pub(crate) struct Pen {
    sheet: Document,
    /// Open groups, the innermost last; what is drawn goes into that.
    groups: Vec<Group>,
    font: FontRef<'static>,
}

impl Pen {
    pub(crate) fn new(width: u32, height: u32) -> Result<Self> {
        let font = FontRef::try_from_slice(DEJAVU_SANS)
            .map_err(|e| Error::other("reading the font", e))?;
        let white =
            Rectangle::new().set("width", "100%").set("height", "100%").set("fill", "white");
        let sheet = Document::new()
            .set("width", width)
            .set("height", height)
            .set("viewBox", (0, 0, width, height));
        Ok(Self { sheet: sheet.add(white), groups: Vec::new(), font })
    }

    /// What has been drawn, as SVG.
    pub(crate) fn svg(&self) -> String {
        self.sheet.to_string()
    }

    /// What is drawn until [`Pen::end`] is seen only inside a frame: left, right, top, bottom.
    pub(crate) fn begin_clipped(&mut self, [left, right, top, bottom]: [f64; 4]) {
        let inside = Rectangle::new().set("x", tidy(left)).set("y", tidy(top));
        let inside = inside.set("width", tidy(right - left)).set("height", tidy(bottom - top));
        // Frames of one size share a name, so that several pictures can be on one page.
        let name = format!("inside-{left}-{right}-{top}-{bottom}");
        self.put(ClipPath::new().set("id", name.as_str()).add(inside));
        self.begin([("clip-path", format!("url(#{name})"))]);
    }

    /// What is drawn until [`Pen::end`] becomes a group with these attributes.
    pub(crate) fn begin<const N: usize>(&mut self, attributes: [(&str, String); N]) {
        let group = Group::new();
        let group =
            attributes.into_iter().fold(group, |group, (name, value)| group.set(name, value));
        self.groups.push(group);
    }

    /// Ends the group that was begun last.
    pub(crate) fn end(&mut self) {
        if let Some(group) = self.groups.pop() {
            self.put(group);
        }
    }

    fn put(&mut self, node: impl Node) {
        match self.groups.last_mut() {
            Some(group) => group.append(node),
            None => self.sheet.append(node),
        }
    }

    pub(crate) fn line(&mut self, points: &[At], width: f64, colour: Colour) {
        let line = Polyline::new().set("points", listed(points)).set("fill", "none");
        self.put(line.set("stroke", css(colour)).set("stroke-width", width));
    }

    /// A dashed line from one place to another.
    pub(crate) fn dashes(&mut self, from_to: [At; 2], width: f64, colour: Colour) {
        let [(x0, y0), (x1, y1)] = from_to;
        let length = (x1 - x0).hypot(y1 - y0);
        // A line to a place that cannot be drawn is left out.
        if !length.is_finite() || length > FARTHEST {
            return;
        }
        let at = |way: f64| {
            let share = (way / length).min(1.0);
            (x0 + share * (x1 - x0), y0 + share * (y1 - y0))
        };
        let mut way = 0.0;
        while way < length {
            self.line(&[at(way), at(way + DASH)], width, colour);
            way += 2.0 * DASH;
        }
    }

    pub(crate) fn fill(&mut self, corners: &[At], colour: Colour, opacity: f64) {
        let area = Polygon::new().set("points", listed(corners)).set("fill", css(colour));
        self.put(area.set("fill-opacity", opacity));
    }

    pub(crate) fn dot(&mut self, at: At, radius: f64, colour: Colour) {
        let dot = Circle::new().set("cx", tidy(at.0)).set("cy", tidy(at.1)).set("r", radius);
        self.put(dot.set("fill", css(colour)));
    }

    pub(crate) fn word(&mut self, text: &str, (x, y): At, size: f64, anchor: Anchor) {
        let (side, below) = match anchor {
            Anchor::Left => ("start", MIDDLE),
            Anchor::Right => ("end", MIDDLE),
            Anchor::Top => ("middle", ASCENT),
            Anchor::Turned => ("middle", MIDDLE),
        };
        let word = Text::new(text)
            .set("x", tidy(x))
            .set("y", tidy(y + below * size))
            .set("text-anchor", side);
        let word =
            word.set("font-family", FAMILY).set("font-size", tidy(size)).set("fill", css(INK));
        self.put(match anchor {
            Anchor::Turned => word.set("transform", format!("rotate(-90 {} {})", tidy(x), tidy(y))),
            _ => word,
        });
    }

    /// The size at which a word fits into some room, at most `size`.
    pub(crate) fn fitted(&self, text: &str, size: f64, room: f64) -> f64 {
        size * (room / self.width(text, size)).min(1.0)
    }

    /// A word's width in layout units.
    pub(crate) fn width(&self, text: &str, size: f64) -> f64 {
        let height = self.font.height_unscaled() / self.font.units_per_em().unwrap_or(1.0);
        let font = self.font.as_scaled(size as f32 * height);
        text.chars().map(|letter| f64::from(font.h_advance(font.glyph_id(letter)))).sum()
    }
}

fn listed(points: &[At]) -> String {
    points.iter().map(|&(x, y)| format!("{},{}", tidy(x), tidy(y))).collect::<Vec<_>>().join(" ")
}

/// A hundredth of a unit is finer than any screen.
fn tidy(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// As `#rrggbb`.
pub(crate) fn css([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
