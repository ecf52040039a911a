//! One picture: sky, floor, shadows, capsules, numbers.

use copq::{Error, Result};
use tiny_skia::{Color, FillRule, LineCap, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

use super::camera::Camera;
use super::text::Pen;
use super::{Animation, Capsule, Scene};

/// Pixels from left to right.
pub(super) const WIDTH: u32 = 640;
/// Pixels from top to bottom.
pub(super) const HEIGHT: u32 = 480;

const SKY: [u8; 3] = [244, 246, 249];
const TILES: [[u8; 3]; 2] = [[206, 213, 222], [186, 195, 207]];
const INK: [u8; 3] = [45, 45, 45];
const GREY: [u8; 3] = [120, 126, 135];
/// The floor's near and far edge, from the point that the camera follows (m).
const STRIP: [f64; 2] = [-0.6, 1.4];
/// Side of a tile (m).
const TILE: f64 = 0.5;

/// Draws the scenes of one animation, all from the same distance.
pub(super) struct Painter {
    camera: Camera,
    pen: Pen,
}

impl Painter {
    pub fn new(animation: &Animation) -> Result<Self> {
        let first = animation.frames.first().ok_or_else(|| Error::invalid("animation", "at least one scene", 0))?;
        Ok(Self { camera: Camera::new(&first.scene, WIDTH, HEIGHT), pen: Pen::new()? })
    }

    /// Red, green and blue of every pixel, row by row.
    pub fn paint(&self, scene: &Scene) -> Result<Vec<u8>> {
        let mut sheet = Pixmap::new(WIDTH, HEIGHT).ok_or_else(|| Error::invalid("picture", "a size", 0))?;
        sheet.fill(colour(SKY));
        self.floor(&mut sheet, scene);
        self.shadows(&mut sheet, scene);
        let mut capsules: Vec<_> = scene.capsules.iter().collect();
        capsules.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
        capsules.into_iter().for_each(|capsule| self.capsule(&mut sheet, scene.centre, capsule));
        self.readings(&mut sheet, scene);
        Ok(sheet.data().chunks_exact(4).flat_map(|pixel| pixel[..3].to_vec()).collect())
    }

    /// A chequered strip; its tiles stay where they are while the camera moves.
    fn floor(&self, sheet: &mut Pixmap, scene: &Scene) {
        let half = f64::from(WIDTH) / self.camera.scale;
        let ([x, y, _], [near, far]) = (scene.centre, STRIP);
        for (column, left, right) in tiles(x - half, x + half) {
            for (row, front, back) in tiles(y + near, y + far) {
                let shade = TILES[(column + row).rem_euclid(2) as usize];
                let corners = [left - x, front - y, right - x, back - y].map(|at| at as f32);
                if let Some(tile) = Rect::from_ltrb(corners[0], corners[1], corners[2], corners[3]) {
                    sheet.fill_path(
                        &PathBuilder::from_rect(tile),
                        &paint(shade, 255),
                        FillRule::Winding,
                        self.camera.floor(),
                        None,
                    );
                }
            }
        }
    }

    fn shadows(&self, sheet: &mut Pixmap, scene: &Scene) {
        for capsule in &scene.capsules {
            let [a, b] = capsule.ends.map(|[x, y, _]| ((x - scene.centre[0]) as f32, (y - scene.centre[1]) as f32));
            stroke(sheet, &line(a, b), 2.0 * capsule.radius as f32, paint(INK, 28), self.camera.floor());
        }
    }

    fn capsule(&self, sheet: &mut Pixmap, centre: [f64; 3], capsule: &Capsule) {
        let [a, b] = capsule.ends.map(|end| self.camera.pixel(centre, end));
        let radius = (self.camera.scale * capsule.radius) as f32;
        let lit = |(x, y): (f32, f32)| (x - 0.25 * radius, y - 0.3 * radius);
        let body = line(a, b);
        stroke(sheet, &body, 2.0 * radius, paint(mix(capsule.colour, INK, 0.45), 255), Transform::identity());
        stroke(sheet, &body, 2.0 * radius - 3.0, paint(capsule.colour, 255), Transform::identity());
        stroke(sheet, &line(lit(a), lit(b)), 0.5 * radius, paint([255; 3], 70), Transform::identity());
    }

    fn readings(&self, sheet: &mut Pixmap, scene: &Scene) {
        let column = (WIDTH as f32 - 48.0) / scene.readings.len().max(1) as f32;
        for (index, (name, value)) in scene.readings.iter().enumerate() {
            let left = 24.0 + column * index as f32;
            self.pen.write(sheet, name, (left, 30.0), 14.0, GREY);
            self.pen.write(sheet, value, (left, 54.0), 22.0, INK);
        }
    }
}

/// The tiles that cover a stretch, with the part of each that is inside (m).
fn tiles(from: f64, to: f64) -> impl Iterator<Item = (i64, f64, f64)> {
    let (first, last) = ((from / TILE).floor() as i64, (to / TILE).floor() as i64);
    (first..=last).map(move |tile| (tile, (tile as f64 * TILE).max(from), ((tile + 1) as f64 * TILE).min(to)))
}

fn depth(capsule: &Capsule) -> f64 {
    capsule.ends[0][1] + capsule.ends[1][1]
}

fn line(a: (f32, f32), b: (f32, f32)) -> Option<Path> {
    let mut path = PathBuilder::new();
    path.move_to(a.0, a.1);
    path.line_to(b.0, b.1);
    path.finish()
}

fn stroke(sheet: &mut Pixmap, path: &Option<Path>, width: f32, paint: Paint<'_>, transform: Transform) {
    let stroke = Stroke { width, line_cap: LineCap::Round, ..Stroke::default() };
    if let Some(path) = path {
        sheet.stroke_path(path, &paint, &stroke, transform, None);
    }
}

fn colour([red, green, blue]: [u8; 3]) -> Color {
    Color::from_rgba8(red, green, blue, 255)
}

fn paint([red, green, blue]: [u8; 3], opacity: u8) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, opacity);
    paint
}

fn mix(a: [u8; 3], b: [u8; 3], share: f32) -> [u8; 3] {
    [0, 1, 2].map(|i| (f32::from(a[i]) * (1.0 - share) + f32::from(b[i]) * share) as u8)
}
