//! `copq bounds`: what each projection makes of critics that disagree, drawn.

use std::path::{Path, PathBuf};

use copq::files;
use copq::projection::{self, Disagreement, QView};
use copq_render::Plane;
use nalgebra::{dmatrix, dvector};

use crate::options::say;

/// Bounds that are built on the covariance; the paper's Figure B.1 compares them.
const COMPARED: [&str; 4] = ["cholesky", "eigen", "extremum", "diagonal"];
/// How far the paper's pictures extend to each side, for both objectives.
const FAR: f64 = 3.5;
const AXES: [&str; 2] = ["Q of safety", "Q of speed"];
/// Pictures of the animation, and how long each is shown (hundredths of a second).
const PICTURES: usize = 61;
const SHOWN_FOR: u16 = 8;

/// Draws what each bound makes of critics that disagree.
///
/// Without --std, draws the paper's Figures 1, 2 and B.1, and an animation of the clip over the
/// correlation. All points are computed by the projections that training uses, from critics with
/// the covariance that is drawn.
#[derive(clap::Args)]
pub struct Bounds {
    /// Folder for the pictures.
    #[arg(long, value_name = "DIR", default_value = "bounds")]
    out: PathBuf,

    /// Standard deviations of the critics' safety and speed, such as 1,2; draws one picture of all
    /// bounds.
    #[arg(
        long,
        value_name = "A,B",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true
    )]
    std: Option<Vec<f64>>,

    /// Correlation of the critics' safety and speed, from -1 to 1. [default: 0]
    #[arg(long, value_name = "R", requires = "std", allow_negative_numbers = true)]
    correlation: Option<f64>,

    /// Weights of the objectives.
    #[arg(
        long,
        value_name = "A,B",
        value_delimiter = ',',
        num_args = 1,
        default_value = "1,1",
        allow_hyphen_values = true
    )]
    weights: Vec<f32>,
}

impl Bounds {
    pub fn run(self) -> anyhow::Result<()> {
        let folder = &self.out;
        std::fs::create_dir_all(folder).map_err(files::failed("making", folder))?;
        let weights = pair("weights", &self.weights)?;
        if let Some(std) = &self.std {
            let correlation = self.correlation.unwrap_or(0.0);
            let critics = Critics::new(pair("std", std)?, correlation)?;
            let title = format!("Bounds at a correlation of {correlation}");
            let ranges = critics.ranges();
            write(folder, "bounds", &critics.all_bounds(&title, weights)?.ranges(ranges))?;
        } else {
            paper(folder, weights)?;
        }
        Ok(say(&format!("pictures in {}\n", folder.display()))?)
    }
}

fn pair<T: Copy>(name: &str, values: &[T]) -> copq::Result<[T; 2]> {
    values.try_into().map_err(|_| {
        let got = format!("{} numbers", values.len());
        copq::Error::invalid(format!("--{name}"), "two numbers, as 1,2", got)
    })
}

/// The paper's pictures.
fn paper(folder: &Path, weights: [f32; 2]) -> anyhow::Result<()> {
    let usual = Critics::new([1.0, 1.3], 0.5)?;
    write(folder, "figure-1a", &scalarised(weights)?)?;
    write(folder, "figure-1b", &independent()?)?;
    write(folder, "figure-1c", &usual.bounds_of_cholesky(weights)?)?;
    write(folder, "figure-2a", &usual.clip(None, weights)?)?;
    let against = Critics::new([1.0, 2.4], -0.95)?;
    write(folder, "figure-2b", &against.clip(None, weights)?)?;
    for (name, correlation) in [("figure-b1a", 0.6), ("figure-b1b", -0.6)] {
        let title = format!("Lower bounds, correlation {correlation}");
        let critics = Critics::new([1.0, 1.6], correlation)?;
        write(folder, name, &critics.all_bounds(&title, weights)?)?;
    }
    let films: Vec<Plane> = (0..PICTURES)
        .map(|i| {
            // There and back again.
            let share = i as f64 / (PICTURES - 1) as f64;
            let correlation = 0.98 * (std::f64::consts::TAU * share).cos();
            let title = format!("Correlation {correlation:+.2}");
            Critics::new([1.0, 2.0], correlation)?.clip(Some(title), weights)
        })
        .collect::<copq::Result<_>>()?;
    Ok(Plane::write_gif(&films, SHOWN_FOR, folder.join("clip.gif"))?)
}

fn write(folder: &Path, name: &str, plane: &Plane) -> copq::Result<()> {
    ["svg", "png"]
        .iter()
        .try_for_each(|ending| plane.write(folder.join(format!("{name}.{ending}"))))
}

/// Three critics around zero with a covariance.
struct Critics(Disagreement);

impl Critics {
    fn new([safety, speed]: [f64; 2], correlation: f64) -> copq::Result<Self> {
        // Critics' values are f32.
        if ![safety, speed].iter().all(|std| *std > 0.0 && *std <= 1e30) {
            let got = format!("{safety},{speed}");
            return Err(copq::Error::invalid("--std", "two numbers above 0, up to 1e30", got));
        }
        if !(-1.0..=1.0).contains(&correlation) {
            return Err(copq::Error::invalid("--correlation", "-1 to 1", correlation));
        }
        let rest = (1.0 - correlation * correlation).sqrt();
        let factor = dmatrix![safety, 0.0; speed * correlation, speed * rest];
        Disagreement::with_factor(&dvector![0.0, 0.0], &factor).map(Self)
    }

    fn points(&self) -> Vec<[f64; 2]> {
        self.0.critics().map(|q| [f64::from(q[0]), f64::from(q[1])]).collect()
    }

    fn mean(&self) -> [f64; 2] {
        [self.0.mean()[0], self.0.mean()[1]]
    }

    /// Ranges in which all critics are visible, on axes of the same scale.
    fn ranges(&self) -> [[f64; 2]; 2] {
        let largest = self.points().into_iter().flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
        [[-1.15 * largest, 1.15 * largest]; 2]
    }

    /// The ellipse of one deviation, with the critics.
    fn plane(&self, title: &str) -> copq::Result<Plane> {
        Ok(Plane::new(title, AXES)
            .ranges([[-FAR, FAR]; 2])
            .points("critics", self.points())
            .closed("one deviation", self.0.ellipse([0, 1], 1.0, 120)?))
    }

    fn bound(&self, name: &str, weights: [f32; 2], step: f32) -> copq::Result<[f64; 2]> {
        let bound = self.0.bound(projection::by_name(name)?.as_ref(), &weights, step)?;
        Ok([bound[0], bound[1]])
    }

    /// Figure B.1.
    fn all_bounds(&self, title: &str, weights: [f32; 2]) -> copq::Result<Plane> {
        let mut plane = self.plane(title)?;
        for name in COMPARED {
            plane = plane.arrow(name, [self.mean(), self.bound(name, weights, -1.0)?]);
        }
        Ok(plane)
    }

    /// Figure 1 (c).
    fn bounds_of_cholesky(&self, weights: [f32; 2]) -> copq::Result<Plane> {
        let [lower, upper] = [-1.0, 1.0].map(|step| self.bound("cholesky", weights, step));
        Ok(self
            .plane("One bound for the vector")?
            .arrow("lower", [self.mean(), lower?])
            .arrow("upper", [self.mean(), upper?]))
    }

    /// Figure 2: L u, and what the clip makes of it.
    fn clip(&self, title: Option<String>, weights: [f32; 2]) -> copq::Result<Plane> {
        let length = f64::from(weights[0]).hypot(f64::from(weights[1]));
        let u = weights.map(|weight| f64::from(weight) / length);
        let l = self.0.factor();
        let mean = self.mean();
        let free = [0, 1].map(|i| mean[i] - l[(i, 0)] * u[0] - l[(i, 1)] * u[1]);
        let bound = self.bound("cholesky", weights, -1.0)?;
        // Except for rounding to f32, the type of bounds.
        let is_free = (0..2).all(|i| (bound[i] - free[i]).abs() < 1e-5 * (1.0 + free[i].abs()));
        let what =
            if is_free { "No clip: the bound lies below" } else { "Clipped: turned onto the line" };
        Ok(self
            .plane(&title.unwrap_or_else(|| what.to_owned()))?
            .line("same total", same_total(mean, weights))
            .arrow("without clip", [mean, free])
            .arrow("cholesky", [mean, bound]))
    }
}

/// The line on which the total is a point's, as far as it is visible.
fn same_total(at: [f64; 2], weights: [f32; 2]) -> [[f64; 2]; 2] {
    let length = f64::from(weights[0]).hypot(f64::from(weights[1]));
    let [u, v] = weights.map(|weight| f64::from(weight) / length);
    [-4.0 * FAR, 4.0 * FAR].map(|way| [at[0] - way * v, at[1] + way * u])
}

/// Figure 1 (a): which of two critics has the smaller total is a matter of chance.
fn scalarised(weights: [f32; 2]) -> copq::Result<Plane> {
    let critics = [[1.1, -0.9], [-1.0, 0.8]];
    let chosen = smallest("scalarised-min", &critics, weights)?;
    Ok(Plane::new("The critic with the smaller total", AXES)
        .ranges([[-FAR, FAR]; 2])
        .points("two critics", critics.to_vec())
        .line("same total as the chosen", same_total(chosen, weights))
        .points("chosen", vec![chosen]))
}

/// Figure 1 (b): the smallest of each objective is a point that no critic is near.
fn independent() -> copq::Result<Plane> {
    let critics = Critics::new([1.0, 1.3], -0.8)?;
    let chosen = smallest("independent-min", &critics.points(), [1.0; 2])?;
    Ok(critics.plane("The smallest value of each objective")?.points("chosen", vec![chosen]))
}

/// What a minimum over critics chooses.
fn smallest(name: &str, critics: &[[f64; 2]], weights: [f32; 2]) -> copq::Result<[f64; 2]> {
    let q: Vec<f32> = critics.concat().iter().map(|&x| x as f32).collect();
    let row = Disagreement::of(QView::new(&q, critics.len(), 2)?, 0)?;
    let bound = row.bound(projection::by_name(name)?.as_ref(), &weights, -1.0)?;
    Ok([bound[0], bound[1]])
}
