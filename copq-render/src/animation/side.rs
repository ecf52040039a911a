//! Capsules from the side: sky, floor, shadows, bodies.

use std::fmt;

use copq::Result;
use tiny_skia::{Color, FillRule, LineCap, Paint, PathBuilder, Pixmap, Rect, Stroke, Transform};

use super::camera::Camera;
use super::text::Pen;
use super::{Capsule, HEIGHT, WIDTH, rgb, sheet};

const SKY: [u8; 3] = [246, 248, 251];
const TILES: [[u8; 3]; 2] = [[211, 218, 227], [197, 206, 217]];
const INK: [u8; 3] = [45, 45, 45];
const GREY: [u8; 3] = [112, 118, 128];
/// Side of a tile (m).
const TILE: f64 = 0.5;
/// Where the distances are written, as a share of the way from below the robot to the picture's
/// lower edge.
const MARKS: f64 = 0.45;

/// Draws capsules above a floor, always from the same distance: in plain Rust, without a window or
/// a graphics card.
///
/// ```
/// use copq_render::animation::{Capsule, HEIGHT, SideView, WIDTH, limb_colour};
///
/// let ends = [[0.0, 0.0, 0.1], [0.0, 0.0, 1.0]];
/// let post = Capsule { ends, radius: 0.1, colour: limb_colour(0) };
/// let mut view = SideView::new(&[post])?;
/// let picture = view.draw(&[post], [0.0; 3]);
/// assert_eq!(picture.len(), (3 * WIDTH * HEIGHT) as usize);
/// assert!(picture.as_chunks().0.contains(&limb_colour(0)));
/// # Ok::<(), copq::Error>(())
/// ```
pub struct SideView {
    camera: Camera,
    pen: Pen,
    sheet: Pixmap,
}

impl SideView {
    /// A view from as far away as these capsules need.
    pub fn new(capsules: &[Capsule]) -> Result<Self> {
        Ok(Self { camera: Camera::new(capsules, WIDTH, HEIGHT), pen: Pen::new()?, sheet: sheet()? })
    }

    /// A picture of [`WIDTH`] by [`HEIGHT`] pixels, red, green and blue, row by row. The camera
    /// follows `centre` (m) sideways and in depth.
    pub fn draw(&mut self, capsules: &[Capsule], centre: [f64; 3]) -> Vec<u8> {
        self.sheet.fill(Color::from_rgba8(SKY[0], SKY[1], SKY[2], 255));
        self.floor(centre);
        self.shadows(capsules, centre);
        let mut capsules: Vec<_> = capsules.iter().collect();
        capsules.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
        capsules.into_iter().for_each(|capsule| self.capsule(centre, capsule));
        rgb(&self.sheet)
    }

    /// A chequered floor with distances; both stay where they are while the camera moves.
    fn floor(&mut self, [x, y, _]: [f64; 3]) {
        let [[left, right], [near, far]] = self.camera.floor();
        for (column, left, right) in tiles(x + left, x + right) {
            for (row, near, far) in tiles(y + near, y + far) {
                let shade = TILES[(column + row).rem_euclid(2) as usize];
                let [left, near, right, far] =
                    [left - x, near - y, right - x, far - y].map(|at| at as f32);
                if let Some(tile) = Rect::from_ltrb(left, near, right, far) {
                    let tile = PathBuilder::from_rect(tile);
                    let shade = paint(shade, 255);
                    self.sheet.fill_path(
                        &tile,
                        &shade,
                        FillRule::Winding,
                        self.camera.on_floor(),
                        None,
                    );
                }
            }
        }
        for metre in (x + left).ceil() as i64..=(x + right) as i64 {
            let at = self.camera.pixel([x, y, 0.0], [metre as f64, y + MARKS * near, 0.0]);
            self.pen.write(&mut self.sheet, &format!("{metre} m"), at, 13.0, GREY);
        }
    }

    fn shadows(&mut self, capsules: &[Capsule], centre: [f64; 3]) {
        for capsule in capsules {
            let [a, b] =
                capsule.ends.map(|[x, y, _]| ((x - centre[0]) as f32, (y - centre[1]) as f32));
            self.stroke(
                [a, b],
                2.0 * capsule.radius as f32,
                paint(INK, 36),
                self.camera.on_floor(),
            );
        }
    }

    /// An outline, the body, and light from the upper left.
    fn capsule(&mut self, centre: [f64; 3], capsule: &Capsule) {
        let body = capsule.ends.map(|end| self.camera.pixel(centre, end));
        let width = (2.0 * self.camera.scale * capsule.radius) as f32;
        let lit = body.map(|(x, y)| (x - 0.12 * width, y - 0.15 * width));
        self.stroke(body, width, paint(darker(capsule.colour), 255), Transform::identity());
        self.stroke(body, width - 3.0, paint(capsule.colour, 255), Transform::identity());
        self.stroke(lit, 0.25 * width, paint([255; 3], 70), Transform::identity());
    }

    /// A line with round ends; one without a positive width is not drawn.
    fn stroke(
        &mut self,
        [a, b]: [(f32, f32); 2],
        width: f32,
        paint: Paint<'_>,
        transform: Transform,
    ) {
        let mut path = PathBuilder::new();
        path.move_to(a.0, a.1);
        path.line_to(b.0, b.1);
        let stroke = Stroke { width, line_cap: LineCap::Round, ..Stroke::default() };
        if let (Some(path), true) = (path.finish(), width > 0.0) {
            self.sheet.stroke_path(&path, &paint, &stroke, transform, None);
        }
    }
}

impl fmt::Debug for SideView {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("SideView").field("camera", &self.camera).finish_non_exhaustive()
    }
}

/// The tiles that cover a range, with the part of each that is inside (m).
fn tiles(from: f64, to: f64) -> impl Iterator<Item = (i64, f64, f64)> {
    let first = (from / TILE).floor() as i64;
    let last = (to / TILE).floor() as i64;
    (first..=last)
        .map(move |tile| (tile, (tile as f64 * TILE).max(from), ((tile + 1) as f64 * TILE).min(to)))
}

fn depth(capsule: &Capsule) -> f64 {
    capsule.ends[0][1] + capsule.ends[1][1]
}

fn paint([red, green, blue]: [u8; 3], opacity: u8) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, opacity);
    paint
}

fn darker(colour: [u8; 3]) -> [u8; 3] {
    colour.map(|part| part / 2)
}
