//! Animations, as other programs read them.

use std::fs::File;

use copq::Result;
use copq_render::animation::{Animation, Capsule, Draw, Scene, SideView, limb_colour};
use gif::{ColorOutput, DecodeOptions};

const STEP: f64 = 0.008;

/// A ball at a height (m), seen from where it is.
fn scene(x: f64, z: f64) -> Scene {
    Scene { position: vec![x, z], readings: vec![("height".into(), format!("{z:.2}"))] }
}

/// Draws a scene's ball.
fn draw() -> Box<Draw<'static>> {
    let ball = |x, z| Capsule { ends: [[x, 0.0, z]; 2], radius: 0.5, colour: limb_colour(1) };
    let mut view = SideView::new(&[ball(0.0, 0.5)]).unwrap();
    Box::new(move |at| Ok(view.draw(&[ball(at[0], at[1])], [at[0], 0.0, at[1]])))
}

/// A hundred scenes of 8 ms and a last one of a second: a ball rolls, then leaps.
fn film() -> Animation {
    let mut film = Animation::default();
    (0..100_i32).for_each(|step| {
        film.push(scene(0.02 * f64::from(step), 0.5 + 0.01 * f64::from((step - 50).max(0))), STEP)
    });
    film.push(scene(2.0, 1.0), 1.0);
    film
}

/// Delay (hundredths of a second) and pixels (RGBA) of every frame of a GIF.
fn decode(path: &std::path::Path) -> Vec<(u64, Vec<u8>)> {
    let mut options = DecodeOptions::new();
    options.set_color_output(ColorOutput::RGBA);
    let mut decoder = options.read_info(File::open(path).unwrap()).unwrap();
    let size = usize::from(decoder.width()) * usize::from(decoder.height()) * 4;
    let mut frames = Vec::new();
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert_eq!(frame.buffer.len(), size);
        frames.push((u64::from(frame.delay), frame.buffer.to_vec()));
    }
    frames
}

#[test]
fn a_gif_runs_in_real_time_and_shows_the_motion() {
    let folder = tempfile::tempdir().unwrap();
    let film = film();
    let path = folder.path().join("ball.gif");
    film.write_gif(&path, &mut *draw()).unwrap();
    let frames = decode(&path);
    assert_eq!(frames.len(), film.frames());
    // 0.8 s at 50 frames a second at most, then one frame for the last second.
    assert!((35..=41).contains(&frames.len()), "{}", frames.len());
    assert!(frames.iter().all(|(delay, _)| *delay >= 2));
    assert_eq!(frames.iter().map(|(delay, _)| delay).sum::<u64>(), 180);
    assert!(frames.last().unwrap().0 >= 99);
    assert!(frames.windows(2).all(|pair| pair[0].1 != pair[1].1), "two frames are the same");
}

/// The palette must not spoil what was drawn.
#[test]
fn png_frames_are_those_of_the_gif() {
    let folder = tempfile::tempdir().unwrap();
    let film = film();
    film.write_gif(&folder.path().join("ball.gif"), &mut *draw()).unwrap();
    film.write_png(&folder.path().join("frames"), &mut *draw()).unwrap();
    let frames = decode(&folder.path().join("ball.gif"));
    assert_eq!(std::fs::read_dir(folder.path().join("frames")).unwrap().count(), frames.len());
    for (index, (_, gif)) in frames.iter().enumerate() {
        let file = File::open(folder.path().join(format!("frames/frame-{index:05}.png"))).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let mut png = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut png).unwrap();
        let pairs =
            gif.chunks(4).zip(png.chunks(3)).flat_map(|(gif, png)| gif[..3].iter().zip(png));
        let off: usize = pairs.map(|(gif, png)| usize::from(gif.abs_diff(*png))).sum();
        let mean = off as f64 / png.len() as f64;
        assert!(mean < 0.5, "frame {index}: {mean} of 255 off");
    }
}

/// Where the ball's colour is in a picture: its lowest and highest row, and its leftmost and
/// rightmost column.
fn extent(pixels: &[u8], width: usize) -> [usize; 4] {
    let near = |pixel: &[u8]| {
        pixel[..3].iter().zip(limb_colour(1)).all(|(got, wanted)| got.abs_diff(wanted) < 30)
    };
    let found = || {
        pixels
            .chunks(4)
            .enumerate()
            .filter(|(_, pixel)| near(pixel))
            .map(|(at, _)| (at % width, at / width))
    };
    let columns = found().map(|at| at.0);
    let rows = found().map(|at| at.1);
    [rows.clone().max(), rows.min(), columns.clone().min(), columns.max()].map(Option::unwrap)
}

#[test]
fn the_ball_is_round_stays_in_the_middle_and_rises_with_its_height() {
    let folder = tempfile::tempdir().unwrap();
    let film = film();
    let path = folder.path().join("ball.gif");
    film.write_gif(&path, &mut *draw()).unwrap();
    let frames = decode(&path);
    let [first, last] = [&frames[0], &frames[frames.len() - 1]].map(|frame| extent(&frame.1, 640));
    for [low, high, left, right] in [first, last] {
        assert!((low - high).abs_diff(right - left) <= 2, "not round");
        assert!((left + right).abs_diff(640) <= 2, "not in the middle");
    }
    // The ball is 1 m across, with a dark outline of a pixel or two, and has risen by half of that.
    let rise = first[0] - last[0];
    let across = first[0] - first[1] + 3;
    assert!(rise.abs_diff(across / 2) <= 2, "{rise} of {across}");
}

#[test]
fn an_animation_of_nothing_is_an_error() {
    assert_eq!(
        refused(&Animation::default(), &mut *draw()),
        "animation: wanted at least one scene, got none"
    );
}

fn refused(film: &Animation, draw: &mut Draw<'_>) -> String {
    film.write_gif(std::path::Path::new("never.gif"), draw).unwrap_err().to_string()
}

#[test]
fn a_picture_of_another_size_is_an_error() {
    let mut small = |_: &[f64]| -> Result<Vec<u8>> { Ok(vec![0; 3]) };
    assert!(
        refused(&film(), &mut small).starts_with("picture: wanted"),
        "{}",
        refused(&film(), &mut small)
    );
}
