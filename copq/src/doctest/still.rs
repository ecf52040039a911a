// Hidden in this crate's examples, which have no tensor crate: a backend whose critics say 0 and
// whose policy stands still, and an agent that also stands still and expects 1.25.

use copq::*;

pub struct Still;

impl Critic for Still {
    fn critics(&self) -> usize {
        3
    }

    fn objectives(&self) -> usize {
        2
    }

    fn values(&mut self, _: Net, _: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
        q.fill(0.0);
        Ok(())
    }

    fn fit(&mut self, _: &[f32], _: &[f32], _: QGrad<'_>, _: f32) -> Result<()> {
        Ok(())
    }

    fn action_grad(&mut self, _: &[f32], _: &[f32], _: QGrad<'_>, out: &mut [f32]) -> Result<()> {
        out.fill(0.0);
        Ok(())
    }
}

impl Actor for Still {
    fn action_len(&self) -> usize {
        1
    }

    fn mode(&mut self, _: Net, _: &[f32], action: &mut [f32]) -> Result<()> {
        action.fill(0.0);
        Ok(())
    }

    fn improve(&mut self, _: &[f32], _: &[f32], _: ActionGrad<'_>) -> Result<()> {
        Ok(())
    }

    fn update_target(&mut self, _: f32) -> Result<()> {
        Ok(())
    }
}

impl Backend for Still {
    fn critics(&self, _: &EnvSpec, _: &Networks, _: usize, _: &mut Rng) -> Result<Box<dyn Critic>> {
        Ok(Box::new(Still))
    }

    fn actor(
        &self,
        _: &EnvSpec,
        _: &Networks,
        _: ActorKind,
        _: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        Ok(Box::new(Still))
    }

    fn policy(
        &self,
        _: &EnvSpec,
        _: &Networks,
        _: &mut Rng,
    ) -> Result<Box<dyn on_policy::GaussianPolicy>> {
        Ok(Box::new(Still))
    }

    fn value(&self, _: &EnvSpec, _: &Networks, _: &mut Rng) -> Result<Box<dyn on_policy::StateValue>> {
        Ok(Box::new(Still))
    }
}

impl on_policy::GaussianPolicy for Still {
    fn log_std(&self) -> &[f32] {
        &[0.0]
    }

    fn means(&mut self, _: &[f32], mean: &mut [f32]) -> Result<()> {
        mean.fill(0.0);
        Ok(())
    }

    fn descend(
        &mut self,
        _: &[f32],
        _: on_policy::Descent,
        _: on_policy::NormalGrad<'_>,
    ) -> Result<()> {
        Ok(())
    }
}

impl on_policy::StateValue for Still {
    fn values(&mut self, _: &[f32], value: &mut [f32]) -> Result<()> {
        value.fill(0.0);
        Ok(())
    }

    fn descend(
        &mut self,
        _: &[f32],
        _: on_policy::Descent,
        _: on_policy::ValueGrad<'_>,
    ) -> Result<()> {
        Ok(())
    }
}

impl Agent for Still {
    fn seed(&self) -> u64 {
        0
    }

    fn discount(&self) -> f64 {
        0.9
    }

    fn act(&mut self, _: &[f32], _: Mode, action: &mut [f32]) -> Result<()> {
        action.fill(0.0);
        Ok(())
    }

    fn value(&mut self, _: &[f32], _: &[f32], q: &mut [f32]) -> Result<()> {
        q.fill(1.25);
        Ok(())
    }
}
