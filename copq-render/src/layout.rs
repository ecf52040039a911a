//! A figure's sheet of paper: title, note, legend, and a grid of panels.

use crate::panel::{self, Frame};
use crate::pen::{Anchor, Colour, Pen, css};
use crate::{Figure, Series};

const PANEL: (f64, f64) = (390.0, 270.0);
const HEADER: f64 = 66.0;
const LEGEND_ROW: f64 = 22.0;
const MARGIN: f64 = 14.0;
const LEGEND_SIZE: f64 = 13.0;
const NOTE_SIZE: f64 = 12.0;
const NOTE_ROW: f64 = 16.0;
const SAMPLE: f64 = 26.0;

/// The colours of Okabe and Ito, which people with any colour vision can tell apart; yellow is too
/// pale for a line.
const COLOURS: [Colour; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [230, 159, 0],
    [60, 60, 60],
];

/// The colour of the n-th label.
pub(crate) fn colour(n: usize) -> Colour {
    COLOURS[n % COLOURS.len()]
}

/// How many times all colours have been used up before the n-th label.
pub(crate) fn round(n: usize) -> usize {
    n / COLOURS.len()
}

/// The dashes of the n-th label's line: solid for as many labels as there are colours, then dashed.
fn dashes(n: usize) -> Option<&'static str> {
    const DASHES: [&str; 6] = ["7 3", "2 2", "9 3 2 3", "14 4", "5 2 1 2", "9 2 2 2 2 2"];
    Some(DASHES[round(n).checked_sub(1)? % DASHES.len()])
}

/// The n-th label's line as a small SVG with its colour and dashes: for a legend beside a figure.
pub fn label_sample(n: usize) -> String {
    let dashes = dashes(n).unwrap_or("none");
    let colour = css(colour(n));
    format!(
        "<svg viewBox=\"0 0 26 8\"><path d=\"M0 4H26\" stroke=\"{colour}\" stroke-width=\"3\" \
         stroke-dasharray=\"{dashes}\"/></svg>"
    )
}

/// Attributes of what belongs to the n-th label, so that it can be shown and hidden; its lines have
/// its dashes.
pub(crate) fn series_attributes(n: usize) -> [(&'static str, String); 2] {
    let dashes = dashes(n).unwrap_or("none");
    [("class", format!("series s{n}")), ("stroke-dasharray", dashes.to_owned())]
}

/// Width and height in layout units.
pub(crate) fn size(figure: &Figure) -> (u32, u32) {
    let (columns, rows) = grid(figure);
    let width = columns as f64 * PANEL.0 + 2.0 * MARGIN;
    let legend = legend_rows(figure, width).len() as f64 * LEGEND_ROW;
    (width as u32, (header(figure, width) + legend + rows as f64 * PANEL.1 + MARGIN) as u32)
}

fn grid(figure: &Figure) -> (usize, usize) {
    let panels = figure.panels.len();
    let usual = match panels {
        0..=3 => panels.max(1),
        4 => 2,
        _ => 3,
    };
    let columns = figure.columns.unwrap_or(usual).min(panels.max(1));
    (columns, panels.div_ceil(columns))
}

/// Room for the title and the note.
fn header(figure: &Figure, width: f64) -> f64 {
    HEADER + NOTE_ROW * (note_lines(&figure.note, width).len().max(1) - 1) as f64
}

/// A note in lines that fit, by their number of letters.
fn note_lines(note: &str, width: f64) -> Vec<String> {
    let room = ((width - 2.0 * MARGIN) / (0.5 * NOTE_SIZE)) as usize;
    let mut lines: Vec<String> = Vec::new();
    for word in note.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= room => {
                *line += " ";
                *line += word;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The legend's labels with their numbers, for what is drawn somewhere; a single curve needs none.
fn labels(figure: &Figure) -> Vec<(usize, &str)> {
    let series: &[Series] = figure.panels.first().map_or(&[], |panel| &panel.series);
    let is_drawn = |n: usize| {
        figure.panels.iter().filter_map(|panel| panel.series.get(n)).any(Series::is_drawn)
    };
    let labels = series.iter().map(|series| series.label.as_str()).enumerate();
    if series.len() < 2 { Vec::new() } else { labels.filter(|&(n, _)| is_drawn(n)).collect() }
}

/// Width of a label with its sample, at most the sheet's. Estimated from its number of letters,
/// because there is no font before there is a sheet.
fn item_width(label: &str, width: f64) -> f64 {
    let letters = 0.58 * LEGEND_SIZE * label.chars().count() as f64;
    (SAMPLE + 32.0 + letters).min(width - 2.0 * MARGIN)
}

/// The legend's labels with their numbers, as many in a row as there is room for.
fn legend_rows(figure: &Figure, width: f64) -> Vec<Vec<(usize, &str)>> {
    let mut rows: Vec<Vec<(usize, &str)>> = Vec::new();
    let mut room = 0.0;
    for (i, label) in labels(figure) {
        if rows.is_empty() || item_width(label, width) > room {
            rows.push(Vec::new());
            room = width - 2.0 * MARGIN;
        }
        room -= item_width(label, width);
        rows.last_mut().into_iter().for_each(|row| row.push((i, label)));
    }
    rows
}

/// Draws everything.
pub(crate) fn draw(pen: &mut Pen, figure: &Figure) {
    let (width, height) = size(figure);
    heading(pen, figure, f64::from(width));
    legend(pen, figure, f64::from(width));
    let (columns, rows) = grid(figure);
    let top = f64::from(height) - MARGIN - rows as f64 * PANEL.1;
    for (i, content) in figure.panels.iter().enumerate() {
        let column = (i % columns) as f64;
        let row = (i / columns) as f64;
        let frame = Frame::inside(MARGIN + column * PANEL.0, top + row * PANEL.1, PANEL);
        panel::draw(pen, &frame, content);
    }
}

fn heading(pen: &mut Pen, figure: &Figure, width: f64) {
    let room = width - 2.0 * MARGIN;
    pen.word(
        &figure.title,
        (width / 2.0, 14.0),
        pen.fitted(&figure.title, 18.0, room),
        Anchor::Top,
    );
    for (row, line) in note_lines(&figure.note, width).iter().enumerate() {
        let at = (width / 2.0, 41.0 + NOTE_ROW * row as f64);
        pen.word(line, at, pen.fitted(line, NOTE_SIZE, room), Anchor::Top);
    }
}

fn legend(pen: &mut Pen, figure: &Figure, width: f64) {
    for (row, items) in legend_rows(figure, width).into_iter().enumerate() {
        let y = header(figure, width) + 6.0 + row as f64 * LEGEND_ROW;
        let whole: f64 = items.iter().map(|(_, label)| item_width(label, width)).sum();
        let mut x = 0.5 * (width - whole) + 12.0;
        for (i, label) in items {
            pen.begin(series_attributes(i));
            let band = [(x, y - 6.0), (x + SAMPLE, y - 6.0), (x + SAMPLE, y + 6.0), (x, y + 6.0)];
            pen.fill(&band, colour(i), panel::BAND);
            pen.line(&[(x, y), (x + SAMPLE, y)], panel::LINE, colour(i));
            let size = pen.fitted(label, LEGEND_SIZE, width - MARGIN - SAMPLE - 8.0 - x);
            pen.word(label, (x + SAMPLE + 8.0, y), size, Anchor::Left);
            pen.end();
            x += item_width(label, width);
        }
    }
}
