//! One network of a user's own architecture, with its target and its optimiser.

use std::sync::Mutex;

use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Module, Result, Tensor, Var};
use candle_nn::VarBuilder;
use copq::{Net, Rng, State, Stream};

use super::Make;
use super::seeded::{Seeded, Variables};
use crate::adam::{BETA1, BETA2, EPSILON, Step};
use crate::plain::{failed, values};

/// A module twice, online and target, and Adam's moments of each variable.
pub(super) struct Network {
    online: Box<dyn Module + Send>,
    target: Box<dyn Module + Send>,
    variables: Vec<Variable>,
    steps: u64,
}

struct Variable {
    path: String,
    online: Var,
    target: Var,
    m: Tensor,
    v: Tensor,
}

impl Network {
    /// Makes both copies with the same weights, drawn from `rng`.
    pub fn new(
        make: &Make,
        input: usize,
        output: usize,
        rng: &mut Rng,
        device: &Device,
    ) -> copq::Result<Self> {
        let seed = rng.next_u64();
        let build = || {
            let variables = Variables::default();
            let backend = Seeded {
                variables: variables.clone(),
                rng: Mutex::new(Rng::new(seed, Stream::Init)),
            };
            let module = make(
                VarBuilder::from_backend(Box::new(backend), DType::F32, device.clone()),
                input,
                output,
            )?;
            Ok::<_, candle_core::Error>((module, variables.taken()))
        };
        let (online, online_variables) = build().map_err(failed)?;
        let (target, target_variables) = build().map_err(failed)?;
        let mut variables = Vec::new();
        for ((path, online), (_, target)) in online_variables.into_iter().zip(target_variables) {
            let zeros = online.zeros_like().map_err(failed)?;
            variables.push(Variable { path, online, target, m: zeros.clone(), v: zeros });
        }
        Ok(Self { online, target, variables, steps: 0 })
    }

    /// `rows x input` to `rows x output`.
    pub fn forward(&self, net: Net, input: &Tensor) -> Result<Tensor> {
        match net {
            Net::Online => self.online.forward(input),
            Net::Target => self.target.forward(input),
        }
    }

    /// One Adam step (no weight decay) that lowers a loss made with the online parameters.
    pub fn step(&mut self, grads: &GradStore, lr: f64) -> Result<()> {
        self.steps += 1;
        let Step { rate, root } = Step::new(lr, self.steps);
        for Variable { online, m, v, .. } in &mut self.variables {
            let Some(grad) = grads.get(online) else { continue };
            *m = ((&*m * BETA1)? + (grad * (1.0 - BETA1))?)?.detach();
            *v = ((&*v * BETA2)? + (grad.sqr()? * (1.0 - BETA2))?)?.detach();
            let scale = ((v.sqrt()? * (1.0 / root))? + EPSILON)?;
            online.set(&(online.as_detached_tensor() - ((&*m * rate)? / scale)?)?)?;
        }
        Ok(())
    }

    /// Polyak averaging: target <- (1 - tau) target + tau online.
    pub fn update_target(&mut self, tau: f32) -> Result<()> {
        for Variable { online, target, .. } in &self.variables {
            let kept = (target.as_detached_tensor() * f64::from(1.0 - tau))?;
            target.set(&(kept + (online.as_detached_tensor() * f64::from(tau))?)?)?;
        }
        Ok(())
    }

    /// Writes subtrees `online`, `target`, `adam_m`, `adam_v` of arrays by their paths, and the
    /// count `steps`.
    pub fn save(&self, state: &mut State) -> copq::Result<()> {
        for Variable { path, online, target, m, v } in &self.variables {
            for (part, tensor) in [
                ("online", online.as_tensor()),
                ("target", target.as_tensor()),
                ("adam_m", m),
                ("adam_v", v),
            ] {
                state.child_mut(part).put_shaped(
                    path,
                    tensor.dims(),
                    values(tensor).map_err(failed)?,
                );
            }
        }
        state.put("steps", [self.steps]);
        Ok(())
    }

    /// Reads what [`Network::save`] wrote.
    pub fn load(&mut self, state: &State) -> copq::Result<()> {
        for Variable { path, online, target, m, v } in &mut self.variables {
            let read = |part: &str, like: &Tensor| -> copq::Result<Tensor> {
                let mut array = vec![0.0f32; like.elem_count()];
                state.child(part)?.read(path, &mut array)?;
                Tensor::from_vec(array, like.dims(), like.device()).map_err(failed)
            };
            let m_now = read("adam_m", m)?;
            let v_now = read("adam_v", v)?;
            online.set(&read("online", online)?).map_err(failed)?;
            target.set(&read("target", target)?).map_err(failed)?;
            (*m, *v) = (m_now, v_now);
        }
        self.steps = state.get_one("steps")?;
        Ok(())
    }

    /// Writes the online parameters alone.
    pub fn export(&self, state: &mut State) -> copq::Result<()> {
        for Variable { path, online, .. } in &self.variables {
            state.put_shaped(path, online.dims(), values(online).map_err(failed)?);
        }
        Ok(())
    }

    /// Takes what [`Network::export`] wrote; the target becomes equal to it and the optimiser
    /// begins anew.
    pub fn import(&mut self, state: &State) -> copq::Result<()> {
        for Variable { path, online, target, m, v } in &mut self.variables {
            let mut array = vec![0.0f32; online.elem_count()];
            state.read(path, &mut array)?;
            let tensor = Tensor::from_vec(array, online.dims(), online.device()).map_err(failed)?;
            online.set(&tensor).and_then(|()| target.set(&tensor)).map_err(failed)?;
            *m = tensor.zeros_like().map_err(failed)?;
            *v = m.clone();
        }
        self.steps = 0;
        Ok(())
    }
}
