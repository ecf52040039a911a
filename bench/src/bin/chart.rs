//! Draws medians of updates as bars: `chart OUT.SVG CSV...`, one block of bars for each workload
//! and thread count. `bench/run.py` writes these files.

use anyhow::{Context, Result, bail};
use copq_bench::spread;
use plotters::coord::Shift;
use plotters::drawing::DrawingArea;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

const WIDTH: i32 = 720;
const LEFT: i32 = 200;
const RIGHT: i32 = 110;
const ROW: i32 = 24;
const TITLE: i32 = 34;
const MARGIN: i32 = 12;
const INK: RGBColor = RGBColor(45, 45, 45);
const OURS: RGBColor = RGBColor(0, 114, 178);
const FLOOR: RGBColor = RGBColor(150, 150, 150);
const PEER: RGBColor = RGBColor(230, 159, 0);

/// One workload on a number of threads: its programs' smallest, median and largest times.
struct Block {
    title: String,
    bars: Vec<(String, [f64; 3])>,
}

/// Programs with the times of their rounds.
type Programs = Vec<(String, Vec<f64>)>;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [out, files @ ..] = &words[..] else { bail!("wanted OUT.SVG CSV...") };
    let mut blocks = Vec::new();
    for file in files {
        blocks.extend(read(&std::fs::read_to_string(file)?).with_context(|| file.clone())?);
    }
    let rows: usize = blocks.iter().map(|block| block.bars.len()).sum();
    let height = rows as i32 * ROW + blocks.len() as i32 * TITLE + 2 * MARGIN;
    let area = SVGBackend::new(out, (WIDTH as u32, height as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut y = MARGIN;
    for block in &blocks {
        draw(&area, block, y)?;
        y += TITLE + block.bars.len() as i32 * ROW;
    }
    Ok(area.present()?)
}

/// The wall times of a file in which each program's rounds follow one another.
fn read(text: &str) -> Result<Vec<Block>> {
    let mut rounds: Vec<(String, Programs)> = Vec::new();
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [workload, threads, program, _, wall, _] = cells[..] else {
            bail!("wanted six cells: {line}")
        };
        let title =
            format!("{workload}, {threads} thread{}", if threads == "1" { "" } else { "s" });
        if rounds.last().is_none_or(|last| last.0 != title) {
            rounds.push((title, Vec::new()));
        }
        let (_, programs) = rounds.last_mut().context("a block")?;
        if programs.last().is_none_or(|last| last.0 != program) {
            programs.push((program.to_owned(), Vec::new()));
        }
        programs.last_mut().context("a program")?.1.push(wall.parse()?);
    }
    let bar = |(name, mut times): (String, Vec<f64>)| (name, spread(&mut times));
    let bars = |programs: Programs| programs.into_iter().map(bar).collect();
    Ok(rounds.into_iter().map(|(title, programs)| Block { title, bars: bars(programs) }).collect())
}

fn draw(area: &Area<'_>, block: &Block, top: i32) -> Result<()> {
    let longest = block.bars.iter().map(|(_, [_, _, high])| *high).fold(0.0, f64::max);
    let x = |time: f64| LEFT + (f64::from(WIDTH - LEFT - RIGHT) * time / longest).round() as i32;
    word(
        area,
        &format!("{}: ms an update, median", block.title),
        (MARGIN, top + TITLE / 2),
        15,
        HPos::Left,
    )?;
    for (i, (name, [low, median, high])) in block.bars.iter().enumerate() {
        let middle = top + TITLE + i as i32 * ROW + ROW / 2;
        let colour = match name.as_str() {
            "copq" | "plain" | "backward" | "careful" => OURS,
            name if name.starts_with("learner") => OURS,
            "products" => FLOOR,
            _ => PEER,
        };
        area.draw(&Rectangle::new(
            [(LEFT, middle - 8), (x(*median), middle + 8)],
            colour.filled(),
        ))?;
        area.draw(&PathElement::new([(x(*low), middle), (x(*high), middle)], INK.stroke_width(1)))?;
        word(area, label(name), (LEFT - 8, middle), 13, HPos::Right)?;
        word(
            area,
            &format!("{median:.2}"),
            (x(*median).max(x(*high)) + 6, middle),
            13,
            HPos::Left,
        )?;
    }
    Ok(())
}

fn label(name: &str) -> &str {
    match name {
        "products" => "matrix products alone",
        "backward" => "copq, backward in bf16",
        "careful" => "copq, careful in bf16",
        "learner" => "copq, whole learner",
        "learner-backward" => "whole learner, backward",
        "learner-careful" => "whole learner, careful",
        "scan" => "JAX, scan over updates",
        "step" => "JAX, one update a call",
        "compiled" => "PyTorch, compiled",
        "eager" => "PyTorch, eager",
        "autograd" => "candle autograd",
        "plain" => "copq's plain networks",
        name => name,
    }
}

fn word(area: &Area<'_>, text: &str, at: (i32, i32), size: i32, side: HPos) -> Result<()> {
    let style = TextStyle::from(("sans-serif", size).into_font())
        .color(&INK)
        .pos(Pos::new(side, VPos::Center));
    Ok(area.draw(&Text::new(text.to_owned(), at, style))?)
}
