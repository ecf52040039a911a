//! Lines, bands and words in layout units, on any plotters backend.

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::element::{Circle, PathElement, Polygon, Text};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, IntoFont, RGBColor, TextStyle};

use crate::font::FAMILY;

/// Nothing, or the backend's error.
pub(crate) type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// A position in layout units, from the upper left corner.
pub(crate) type At = (f64, f64);

/// Dark grey, for words and frames.
pub(crate) const INK: RGBColor = RGBColor(45, 45, 45);
/// Light grey, for grids.
pub(crate) const GRID: RGBColor = RGBColor(226, 226, 226);

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

/// Draws on a backend's area.
pub(crate) struct Pen<'a, B: DrawingBackend> {
    pub(crate) area: &'a DrawingArea<B, Shift>,
    /// Device units to a layout unit.
    pub(crate) scale: f64,
    /// How far below its position a word's middle must be put to end up there, in parts of its size.
    pub(crate) sink: f64,
}

impl<B: DrawingBackend> Pen<'_, B> {
    fn device(&self, (x, y): At) -> (i32, i32) {
        ((x * self.scale).round() as i32, (y * self.scale).round() as i32)
    }

    pub(crate) fn line(&self, points: &[At], width: f64, colour: RGBColor) -> Drawn<B> {
        let points: Vec<_> = points.iter().map(|&at| self.device(at)).collect();
        self.area.draw(&PathElement::new(points, colour.stroke_width((width * self.scale).round() as u32)))
    }

    pub(crate) fn fill(&self, corners: &[At], colour: RGBColor, opacity: f64) -> Drawn<B> {
        let corners: Vec<_> = corners.iter().map(|&at| self.device(at)).collect();
        self.area.draw(&Polygon::new(corners, colour.mix(opacity).filled()))
    }

    pub(crate) fn dot(&self, at: At, radius: f64, colour: RGBColor) -> Drawn<B> {
        self.area.draw(&Circle::new(self.device(at), radius * self.scale, colour.filled()))
    }

    pub(crate) fn word(&self, text: &str, at: At, size: f64, anchor: Anchor) -> Drawn<B> {
        let (h, v, sink) = match anchor {
            Anchor::Left => (HPos::Left, VPos::Center, self.sink),
            Anchor::Right => (HPos::Right, VPos::Center, self.sink),
            Anchor::Top => (HPos::Center, VPos::Top, 0.0),
            Anchor::Turned => (HPos::Center, VPos::Center, 0.0),
        };
        let at = (at.0, at.1 + sink * size);
        let mut style = self.style(size).pos(Pos::new(h, v));
        if let Anchor::Turned = anchor {
            style = style.transform(FontTransform::Rotate270);
        }
        self.area.draw(&Text::new(text, self.device(at), style))
    }

    /// A word's width in layout units.
    pub(crate) fn width(&self, text: &str, size: f64) -> f64 {
        // A text that cannot be measured is drawn anyway, and fails there.
        let (width, _) = self.area.estimate_text_size(text, &self.style(size)).unwrap_or_default();
        f64::from(width) / self.scale
    }

    fn style(&self, size: f64) -> TextStyle<'static> {
        TextStyle::from((FAMILY, size * self.scale).into_font()).color(&INK)
    }
}
