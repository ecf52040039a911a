//! What an ensemble says about one action: covariance, factor in priority order, and a drawing of
//! the confidence ellipse and bounds.
//!
//! `cargo run --release -p copq-examples --example inspect_bound` leaves bound.svg here.

use copq::projection::{Disagreement, QView, by_name};
use copq::{Critic, Env, Net, Networks, Result, Rng, Stream};
use copq_candle::fused;
use copq_render::Plane;

fn main() -> Result<()> {
    // Four untrained critics of three values each: they disagree about everything.
    let mut env = copq_envs_rapier::make("a/hopper")?;
    let mut rng = Rng::new(0, Stream::Init);
    let mut critic = fused::Critics::new(env.spec(), 4, &Networks::default(), &mut rng)?;
    let mut obs = vec![0.0; env.spec().obs_len];
    env.reset(0, &mut obs)?;
    let mut q = [0.0; 4 * 3];
    critic.values(Net::Online, &obs, &[0.5, -0.2, 0.1], &mut q)?;

    let q = QView::new(&q, 4, 3)?;
    let row = Disagreement::of(q, 0)?;
    println!("covariance{:.4}factor, safety first{:.4}", row.covariance(), row.factor());
    let mean = [row.mean()[0], row.mean()[1]];
    let critics = (0..4).map(|k| [f64::from(q.get(k, 0)[0]), f64::from(q.get(k, 0)[1])]).collect();
    let mut plane = Plane::new("Four critics and their lower bounds", ["safety", "velocity"])
        .points("critics", critics)
        .closed("one deviation", row.ellipse([0, 1], 1.0, 90)?);
    for name in ["cholesky", "extremum", "diagonal"] {
        let bound = row.bound(by_name(name)?.as_ref(), &[1.0; 3], -1.0)?;
        plane = plane.arrow(name, [mean, [bound[0], bound[1]]]);
    }
    plane.write("bound.svg")
}
