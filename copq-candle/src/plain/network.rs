//! One network as a candle-nn module, with its target and its optimiser.

use std::fmt;
use std::sync::Mutex;

use candle_core::backprop::GradStore;
use candle_core::{DType, Device, Module, Result, Tensor, Var};
use candle_nn::VarBuilder;
use copq::{Error, Net, Rng, Stream};

use super::seeded::{Seeded, Variables};
use super::{failed, values};
use crate::MakeModule;
use crate::adam::{BETA1, BETA2, EPSILON, Step};
use crate::learned::Learned;
use crate::shape::Array;

/// A module twice, online and target, and Adam's moments of each variable.
pub(super) struct Network {
    online: Box<dyn Module + Send>,
    target: Box<dyn Module + Send>,
    variables: Vec<Variable>,
    /// The variables' names, and where each lies in the buffers of a [`Learned`].
    arrays: Vec<Array>,
    steps: u64,
}

struct Variable {
    online: Var,
    target: Var,
    m: Tensor,
    v: Tensor,
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Network").field("arrays", &self.arrays).finish_non_exhaustive()
    }
}

impl Network {
    /// Makes both copies with the same weights, drawn from `rng`.
    pub fn new(
        make: &MakeModule,
        input: usize,
        output: usize,
        rng: &mut Rng,
        device: &Device,
    ) -> Result<Self> {
        let seed = rng.next_u64();
        let build = || {
            let variables = Variables::default();
            let backend = Seeded {
                variables: variables.clone(),
                rng: Mutex::new(Rng::new(seed, Stream::Init)),
            };
            let backend = VarBuilder::from_backend(Box::new(backend), DType::F32, device.clone());
            Ok::<_, candle_core::Error>((make(backend, input, output)?, variables.taken()))
        };
        let (online, online_variables) = build()?;
        let (target, target_variables) = build()?;
        check_alike(&online_variables, &target_variables)?;
        let mut variables = Vec::new();
        let mut arrays = Vec::new();
        let mut start = 0;
        for ((name, online), (_, target)) in online_variables.into_iter().zip(target_variables) {
            let end = start + online.elem_count();
            arrays.push(Array { name, dims: online.dims().to_vec(), range: start..end });
            start = end;
            let zeros = online.zeros_like()?;
            variables.push(Variable { online, target, m: zeros.clone(), v: zeros });
        }
        Ok(Self { online, target, variables, arrays, steps: 0 })
    }

    /// An error for a module with a part that would never learn, because no gradient reaches it.
    pub fn check_gradients(&self, input: usize, device: &Device) -> copq::Result<()> {
        let rows = Var::ones((2, input), DType::F32, device).map_err(failed)?;
        let output = self.forward(Net::Online, &rows).map_err(failed)?;
        let grads = output.sum_all().and_then(|sum| sum.backward()).map_err(failed)?;
        let online = self.variables.iter().map(|variable| &variable.online);
        let named = self.arrays.iter().map(|array| array.name.as_str()).zip(online);
        let mut all = named.chain([("input", &rows)]);
        match all.find(|(_, variable)| grads.get(variable).is_none()) {
            None => Ok(()),
            Some((name, _)) => Err(Error::invalid(
                format!("a module's '{name}'"),
                "a gradient (what shall not learn is drawn without the VarBuilder)",
                "none; candle's fused LayerNorm with a bias, RmsNorm and softmax_last_dim pass none on",
            )),
        }
    }

    /// The variables, in the order in which the module asked for them.
    pub fn arrays(&self) -> &[Array] {
        &self.arrays
    }

    /// Maps `rows x input` to `rows x output`.
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

    /// Fetches what was learned from the device.
    pub fn learned(&self) -> copq::Result<Learned> {
        Ok(Learned {
            online: self.flat(|variable| variable.online.as_tensor())?,
            target: self.flat(|variable| variable.target.as_tensor())?,
            m: self.flat(|variable| &variable.m)?,
            v: self.flat(|variable| &variable.v)?,
            steps: self.steps,
        })
    }

    /// Replaces what was learned; it must have the same arrays.
    pub fn set_learned(&mut self, learned: &Learned) -> copq::Result<()> {
        self.steps = learned.steps;
        self.place(learned).map_err(failed)
    }

    fn flat(&self, part: impl Fn(&Variable) -> &Tensor) -> copq::Result<Vec<f32>> {
        let mut flat = Vec::new();
        for variable in &self.variables {
            flat.extend(values(part(variable)).map_err(failed)?);
        }
        Ok(flat)
    }

    fn place(&mut self, learned: &Learned) -> Result<()> {
        for (variable, array) in self.variables.iter_mut().zip(&self.arrays) {
            let Variable { online, target, m, v } = variable;
            let device = online.device().clone();
            let tensor = |numbers: &[f32]| {
                Tensor::from_slice(&numbers[array.range.clone()], array.dims.as_slice(), &device)
            };
            online.set(&tensor(&learned.online)?)?;
            target.set(&tensor(&learned.target)?)?;
            *m = tensor(&learned.m)?;
            *v = tensor(&learned.v)?;
        }
        Ok(())
    }
}

/// An error unless a module that was made twice asked for the same variables both times.
fn check_alike(online: &[(String, Var)], target: &[(String, Var)]) -> Result<()> {
    let shapes = |variables: &[(String, Var)]| -> Vec<String> {
        variables.iter().map(|(name, var)| format!("{name} {:?}", var.dims())).collect()
    };
    let [online, target] = [shapes(online), shapes(target)];
    if online == target {
        return Ok(());
    }
    candle_core::bail!("variables of a module made again: wanted {online:?}, got {target:?}")
}
