//! Networks of your own architecture: any candle-nn module as critic or policy, by autograd.

use std::fmt;
use std::sync::Arc;

use candle_core::{Device, Module};
use candle_nn::VarBuilder;
use copq::{Actor, ActorKind, Backend, Critic, EnvSpec, Networks, Result, Rng};

use crate::{Candle, plain};

/// Builds a module that maps an f32 tensor of `rows x input` to one of `rows x output`, given a
/// `VarBuilder` for its variables and the numbers of inputs and outputs. It is called twice for
/// each network, for the one that learns and for its target, and must ask for the same variables in
/// the same order.
///
/// ```
/// use candle_nn::{VarBuilder, linear};
/// use copq::{Critic, EnvSpec, Net, Networks, Rng, Stream};
/// use copq_candle::{Device, MakeModule, plain};
///
/// let make: &MakeModule =
///     &|vars: VarBuilder<'_>, input, output| Ok(Box::new(linear(input, output, vars)?));
/// let spec = EnvSpec::new("example", 2, 1).reward("safety", 1.0);
/// let (networks, mut rng) = (Networks::default(), Rng::new(0, Stream::Init));
/// let mut critics =
///     plain::Critics::of_modules(make, &spec, 2, &networks, &mut rng, &Device::Cpu)?;
/// let mut q = [0.0; 2]; // of two linear critics
/// critics.values(Net::Online, &[0.1, 0.2], &[0.5], &mut q)?;
/// assert!(q[0] != q[1]);
/// # Ok::<(), copq::Error>(())
/// ```
pub type MakeModule = dyn Fn(VarBuilder<'_>, usize, usize) -> candle_core::Result<Box<dyn Module + Send>>
    + Send
    + Sync;

/// A backend whose critics, and optionally whose policy, are your modules. The rest is
/// [`Candle`]'s. It is for off-policy methods; on-policy ones report that they need other networks.
///
/// Variables are drawn by candle's rules from copq's random numbers, saved under their paths, and
/// stepped by the same Adam as all other networks. Only [`Networks`]' step sizes are used;
/// following its layers and activation is up to you. Everything that a module draws, and its input,
/// must have a gradient. candle's fused `LayerNorm` with a bias, `RmsNorm` and `softmax_last_dim`
/// pass none on; `layer_norm_no_bias` does.
///
/// ```
/// use candle_core::Module;
/// use candle_nn::{VarBuilder, layer_norm_no_bias, linear};
/// use copq::{Agent, EnvSpec, Learner, Method};
/// use copq_candle::Modules;
///
/// let backend = Modules::with_critics(|vars: VarBuilder<'_>, input, output| {
///     let hidden = linear(input, 64, vars.pp("hidden"))?;
///     let norm = layer_norm_no_bias(64, 1e-5, vars.pp("norm"))?;
///     let last = linear(64, output, vars.pp("last"))?;
///     Ok(Box::new(move |x: &_| last.forward(&norm.forward(&hidden.forward(x)?)?.relu()?)))
/// });
/// let spec = EnvSpec::new("example", 11, 3).reward("safety", 1.0).reward("velocity", 1.0);
/// let mut learner = Learner::new(Method::cop_td3(), &spec, &backend, 0)?;
///
/// let mut q = [0.0; 2]; // the mean critic's values of safety and velocity
/// learner.value(&[0.1; 11], &[0.5; 3], &mut q)?;
/// assert!(q[0] != q[1] && q.iter().all(|q| q.is_finite()));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone)]
pub struct Modules {
    critic: Arc<MakeModule>,
    actor: Option<Arc<MakeModule>>,
    device: Device,
}

impl fmt::Debug for Modules {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Modules").field("device", &self.device).finish_non_exhaustive()
    }
}

impl Modules {
    /// Critics that map observation and action, side by side, to one value per objective.
    pub fn with_critics<F>(make: F) -> Self
    where
        F: Fn(VarBuilder<'_>, usize, usize) -> candle_core::Result<Box<dyn Module + Send>>
            + Send
            + Sync
            + 'static,
    {
        Self { critic: Arc::new(make), actor: None, device: Device::Cpu }
    }

    /// A policy that maps an observation to one number per action component, which tanh maps to
    /// [-1, 1]. A stochastic one (SAC) is asked for twice as many: means, then log stds.
    pub fn with_actor<F>(self, make: F) -> Self
    where
        F: Fn(VarBuilder<'_>, usize, usize) -> candle_core::Result<Box<dyn Module + Send>>
            + Send
            + Sync
            + 'static,
    {
        Self { actor: Some(Arc::new(make)), ..self }
    }

    /// The modules' device; a policy that is not yours stays on the CPU.
    pub fn device(self, device: Device) -> Self {
        Self { device, ..self }
    }
}

impl Backend for Modules {
    fn critics(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        count: usize,
        rng: &mut Rng,
    ) -> Result<Box<dyn Critic>> {
        let make = self.critic.as_ref();
        let critics = plain::Critics::of_modules(make, spec, count, networks, rng, &self.device)?;
        Ok(Box::new(critics))
    }

    fn actor(
        &self,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        rng: &mut Rng,
    ) -> Result<Box<dyn Actor>> {
        let Some(make) = self.actor.as_deref() else {
            return Candle::default().actor(spec, networks, kind, rng);
        };
        let device = &self.device;
        Ok(match kind {
            ActorKind::Deterministic => {
                Box::new(plain::Deterministic::of_module(make, spec, networks, rng, device)?)
            }
            ActorKind::Gaussian => {
                Box::new(plain::Gaussian::of_module(make, spec, networks, rng, device)?)
            }
            ActorKind::Normal => return Candle::default().actor(spec, networks, kind, rng),
        })
    }
}
