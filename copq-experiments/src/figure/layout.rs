//! A figure's sheet of paper: title, note, legend, and a grid of panels.

use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::prelude::DrawingBackend;
use plotters::style::{RGBColor, WHITE};

use super::panel::{self, Frame};
use super::pen::{Anchor, Drawn, Pen};
use super::{Figure, Series};

const PANEL: (f64, f64) = (390.0, 270.0);
const HEADER: f64 = 66.0;
const LEGEND_ROW: f64 = 22.0;
const MARGIN: f64 = 14.0;
const LEGEND_SIZE: f64 = 13.0;
const SAMPLE: f64 = 26.0;

/// The colours of Okabe and Ito, which people with any colour vision can tell apart; yellow is too pale for a line.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
];

/// The colour of the n-th label.
pub(crate) fn colour(n: usize) -> RGBColor {
    COLOURS[n % COLOURS.len()]
}

/// Width and height in layout units.
pub(crate) fn size(figure: &Figure) -> (u32, u32) {
    let (columns, rows) = grid(figure.panels.len());
    let width = columns as f64 * PANEL.0 + 2.0 * MARGIN;
    let legend = labels(figure).len().div_ceil(legend_columns(figure, width)) as f64 * LEGEND_ROW;
    (width as u32, (HEADER + legend + rows as f64 * PANEL.1 + MARGIN) as u32)
}

fn grid(panels: usize) -> (usize, usize) {
    let columns = match panels {
        0..=3 => panels.max(1),
        4 => 2,
        _ => 3,
    };
    (columns, panels.div_ceil(columns))
}

/// The legend's labels; a single curve needs none.
fn labels(figure: &Figure) -> Vec<&str> {
    let series: &[Series] = figure.panels.first().map_or(&[], |panel| &panel.series);
    if series.len() < 2 { Vec::new() } else { series.iter().map(|series| series.label.as_str()).collect() }
}

/// Columns of equal width, for which the longest label is measured by its number of letters.
fn legend_columns(figure: &Figure, width: f64) -> usize {
    ((width - 2.0 * MARGIN) / legend_step(figure)).floor().max(1.0) as usize
}

fn legend_step(figure: &Figure) -> f64 {
    let letters = labels(figure).iter().map(|label| label.chars().count()).max().unwrap_or(0);
    SAMPLE + 30.0 + 0.62 * LEGEND_SIZE * letters as f64
}

/// Draws everything; `scale` is the number of device units to a layout unit.
pub(crate) fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, scale: f64, figure: &Figure) -> Drawn<B> {
    area.fill(&WHITE)?;
    let pen = Pen { area, scale };
    let (width, height) = size(figure);
    heading(&pen, figure, f64::from(width))?;
    legend(&pen, figure, f64::from(width))?;
    let (columns, rows) = grid(figure.panels.len());
    let top = f64::from(height) - MARGIN - rows as f64 * PANEL.1;
    for (i, content) in figure.panels.iter().enumerate() {
        let (column, row) = ((i % columns) as f64, (i / columns) as f64);
        let frame = Frame::inside(MARGIN + column * PANEL.0, top + row * PANEL.1, PANEL);
        panel::draw(&pen, &frame, content)?;
    }
    area.present()
}

fn heading<B: DrawingBackend>(pen: &Pen<'_, B>, figure: &Figure, width: f64) -> Drawn<B> {
    let room = width - 2.0 * MARGIN;
    let fitted = |text: &str, size: f64| size * (room / pen.width(text, size)).min(1.0);
    pen.word(&figure.title, (width / 2.0, 14.0), fitted(&figure.title, 18.0), Anchor::Top)?;
    pen.word(&figure.note, (width / 2.0, 41.0), fitted(&figure.note, 12.0), Anchor::Top)
}

fn legend<B: DrawingBackend>(pen: &Pen<'_, B>, figure: &Figure, width: f64) -> Drawn<B> {
    let labels = labels(figure);
    let (columns, step) = (legend_columns(figure, width).min(labels.len().max(1)), legend_step(figure));
    let left = 0.5 * (width - columns as f64 * step) + 10.0;
    for (i, label) in labels.into_iter().enumerate() {
        let (x, y) = (left + (i % columns) as f64 * step, HEADER + 6.0 + (i / columns) as f64 * LEGEND_ROW);
        let band = [(x, y - 6.0), (x + SAMPLE, y - 6.0), (x + SAMPLE, y + 6.0), (x, y + 6.0)];
        pen.fill(&band, colour(i), panel::BAND)?;
        pen.line(&[(x, y), (x + SAMPLE, y)], panel::LINE, colour(i))?;
        pen.word(label, (x + SAMPLE + 8.0, y), LEGEND_SIZE, Anchor::Left)?;
    }
    Ok(())
}
