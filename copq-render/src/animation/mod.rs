//! A robot in motion, as an animated GIF or as PNG frames, with a row of numbers above it.
//!
//! An animation knows nothing about robots and engines: it keeps positions, and is given a [`Draw`]
//! that turns one into a picture. [`SideView`] draws the capsules that a robot is made of, and
//! needs nothing else. Pictures are drawn while a file is written, so a long episode costs little
//! memory, and what no viewer would show is never drawn.

mod album;
mod camera;
mod caption;
pub(crate) mod gif;
mod side;
mod text;

use std::path::Path;

use copq::{Error, Result};
use tiny_skia::Pixmap;

use crate::{colour, encode_png};
pub use album::Album;
use caption::Caption;
use copq::files;
pub use side::SideView;

/// Pixels of a picture from left to right.
pub const WIDTH: u32 = 640;
/// Pixels of a picture from top to bottom.
pub const HEIGHT: u32 = 420;

/// Draws a scene's position: red, green and blue of [`WIDTH`] x [`HEIGHT`] pixels, row by row from
/// the top.
pub type Draw<'a> = dyn FnMut(&[f64]) -> Result<Vec<u8>> + 'a;

/// Shortest time that a GIF's frame is shown, in hundredths of a second: viewers slow down anything
/// shorter.
const SHORTEST: u64 = 2;

/// All points within `radius` of the line between two points, a ball if they coincide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capsule {
    /// Centres of its caps (m): x to the right, y away from the viewer, z up, the floor at z = 0.
    pub ends: [[f64; 3]; 2],
    /// Radius (m).
    pub radius: f64,
    /// Red, green and blue.
    pub colour: [u8; 3],
}

/// One moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// Where the robot is, as the [`Draw`] takes it: its qpos.
    pub position: Vec<f64>,
    /// Names with their values, shown above the robot.
    pub readings: Vec<(String, String)>,
}

/// Moments in order, each with the time at which it is shown.
///
/// ```
/// # let folder = tempfile::tempdir().expect("a temporary folder");
/// # let path = folder.path().join("ball.gif");
/// use copq_render::animation::{Animation, Capsule, Draw, Scene, SideView};
///
/// // A ball that rises, with its height above it.
/// let ball = |z| Capsule { ends: [[0.0, 0.0, z]; 2], radius: 0.1, colour: [0, 114, 178] };
/// let mut animation = Animation::default();
/// for step in 0..8 {
///     let z = 0.1 + 0.05 * f64::from(step);
///     let readings = vec![("height".to_owned(), format!("{z:.2} m"))];
///     animation.push(Scene { position: vec![z], readings }, 0.01);
/// }
/// assert_eq!(animation.frames(), 4); // of eight in 0.08 s: at most 50 a second
///
/// let mut view = SideView::new(&[ball(0.1)])?;
/// let draw: &mut Draw<'_> = &mut |position| Ok(view.draw(&[ball(position[0])], [0.0; 3]));
/// animation.write_gif(&path, draw)?;
/// # assert!(std::fs::read(&path).is_ok_and(|bytes| bytes.starts_with(b"GIF89a")));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Animation {
    frames: Vec<Frame>,
    seconds: f64,
}

/// A scene that a GIF shows, from `start` (hundredths of a second) until the next one.
#[derive(Clone, Debug)]
struct Frame {
    start: u64,
    scene: Scene,
}

/// A colour for a robot's n-th limb, from a small set that people with any colour vision can tell
/// apart.
pub fn limb_colour(n: usize) -> [u8; 3] {
    colour(n)
}

impl Animation {
    /// Shows a scene for this long (s) after all others. GIFs show at most 50 scenes a second: one
    /// that ends sooner is replaced by the next, so that the timing stays true.
    pub fn push(&mut self, scene: Scene, seconds: f64) {
        let start = hundredths(self.seconds);
        self.seconds += seconds;
        match self.frames.last_mut() {
            Some(last) if start < last.start + SHORTEST => last.scene = scene,
            _ => self.frames.push(Frame { start, scene }),
        }
    }

    /// How many frames are shown.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Writes a GIF that runs in real time, over and over.
    pub fn write_gif(&self, path: &Path, draw: &mut Draw<'_>) -> Result<()> {
        if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif")) {
            return Err(Error::invalid(
                "animation's file",
                "a name that ends in .gif",
                path.display(),
            ));
        }
        let mut picture = self.pictures(draw)?;
        let delays: Vec<u64> = self.delays().collect();
        let mut picture = |i: usize| picture(&self.frames[i].scene);
        files::replace(path, &gif::encode([WIDTH, HEIGHT], &delays, &mut picture)?)
    }

    /// Writes every frame as its own picture, `frame-00000.png` and so on; makes the folder.
    pub fn write_png(&self, folder: &Path, draw: &mut Draw<'_>) -> Result<()> {
        std::fs::create_dir_all(folder).map_err(files::failed("making", folder))?;
        let mut picture = self.pictures(draw)?;
        for (index, frame) in self.frames.iter().enumerate() {
            let bytes = encode_png(&picture(&frame.scene)?, WIDTH, HEIGHT)?;
            files::replace(&folder.join(frame_name(index)), &bytes)?;
        }
        // The rest of a longer film that was here before would continue this one.
        for index in self.frames.len().. {
            let stale = folder.join(frame_name(index));
            if !stale.exists() {
                break;
            }
            std::fs::remove_file(&stale).map_err(files::failed("removing", &stale))?;
        }
        Ok(())
    }

    /// A function that draws a scene and writes its readings; an error if there is no scene.
    fn pictures<'a>(
        &self,
        draw: &'a mut Draw<'_>,
    ) -> Result<impl FnMut(&Scene) -> Result<Vec<u8>> + 'a> {
        if self.frames.is_empty() {
            return Err(Error::invalid("animation", "at least one scene", "none"));
        }
        let mut caption = Caption::new()?;
        Ok(move |scene: &Scene| caption.write(&draw(&scene.position)?, &scene.readings))
    }

    /// How long each frame is shown, in hundredths of a second.
    fn delays(&self) -> impl Iterator<Item = u64> {
        let ends =
            self.frames.iter().skip(1).map(|frame| frame.start).chain([hundredths(self.seconds)]);
        self.frames
            .iter()
            .zip(ends)
            .map(|(frame, end)| end.saturating_sub(frame.start).max(SHORTEST))
    }
}

fn hundredths(seconds: f64) -> u64 {
    (100.0 * seconds).round() as u64
}

fn sheet() -> Result<Pixmap> {
    Pixmap::new(WIDTH, HEIGHT)
        .ok_or_else(|| Error::invalid("picture", "a width and height", "none"))
}

/// Red, green and blue of every pixel, row by row, of an opaque sheet.
fn rgb(sheet: &Pixmap) -> Vec<u8> {
    sheet
        .data()
        .as_chunks::<4>()
        .0
        .iter()
        .flat_map(|&[red, green, blue, _]| [red, green, blue])
        .collect()
}

fn frame_name(index: usize) -> String {
    format!("frame-{index:05}.png")
}
