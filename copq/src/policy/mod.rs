//! A trained policy on its own, for acting when learning is over.

mod about;

use std::path::Path;

pub(crate) use about::About;

use crate::error::check_len;
use crate::made_by::{check_task, method_of};
use crate::{
    Actor, ActorKind, Backend, EnvSpec, Error, Net, Networks, Normaliser, Result, Rng, State,
    Stream,
};

/// An actor with its action bounds and, if it learned with one, the normaliser of its observations.
/// All are frozen.
///
/// ```
/// # use copq::*;
/// # fn show(backend: &dyn Backend, obs: &[f32]) -> Result<()> {
/// // A file that `Learner::save_policy` or the program `copq export` has written.
/// let mut policy = Policy::read("hopper.safetensors", backend)?;
/// let mut action = vec![0.0; policy.action_len()];
/// policy.act(obs, &mut action)?; // in [-1, 1]
/// policy.scale(&mut action)?; // in the robot's own units
/// # Ok(())
/// # }
/// ```
///
/// The file is safetensors, for any reader. Layers are `actor/layer.0.weight` (output x input),
/// `actor/layer.0.bias` and so on. After each hidden layer comes `policy/activation`. What comes
/// after the output depends on `policy/kind`: tanh (`deterministic`), tanh of its first half, the
/// means (`gaussian`), or only a clamp to [-1, 1] (`normal`, which also has `actor/log_std`). The
/// bounds of the actions are `policy/action_low` and `policy/action_high`.
///
/// If there is a normaliser, `normaliser/mean`, `normaliser/squares` and `normaliser/count` turn x
/// into (x - mean) / max(sqrt(squares / (count - 1)), 0.01), clipped at 5. The last
/// `normaliser/raw` components stay as they are.
///
/// Texts (`policy/task`, `policy/kind`, `policy/activation`, `policy/method`, and
/// `policy/objectives`, one name per line) are UTF-8 bytes. `policy/hidden` and `policy/obs_len`
/// are the layers' widths. A policy made of modules ([`Backend`]) has its own paths instead, and is
/// read back by the same backend.
pub struct Policy {
    actor: Box<dyn Actor>,
    normaliser: Option<Normaliser>,
    about: About,
    /// The observations as the actor sees them.
    obs: Vec<f32>,
}

impl std::fmt::Debug for Policy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Policy")
            .field("kind", &self.about.kind)
            .field("normaliser", &self.normaliser)
            .finish_non_exhaustive()
    }
}

impl Policy {
    /// The policy in the saved state of an agent (the child `agent` of a trainer's state) that
    /// learned this kind of policy with such networks. A policy of a different task is refused.
    pub fn load(
        agent: &State,
        spec: &EnvSpec,
        networks: &Networks,
        kind: ActorKind,
        backend: &dyn Backend,
    ) -> Result<Self> {
        check_task(agent, &spec.name)?;
        let about = About::new(spec, networks, kind, Some(method_of(agent)?));
        let mut actor = fresh(&about, backend)?;
        actor.load(agent.child("actor")?)?;
        let normaliser = Normaliser::of(agent, spec.obs_len)?;
        Ok(Self { actor, normaliser, about, obs: Vec::new() })
    }

    /// Reads a policy's file.
    pub fn read(path: impl AsRef<Path>, backend: &dyn Backend) -> Result<Self> {
        Self::from_state(&State::read_file(path)?, backend)
    }

    /// Writes the policy to a small file.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        self.to_state()?.write_file(path)
    }

    /// The policy that a file's content describes, with networks of this backend. An error names
    /// what is missing or does not fit.
    ///
    /// ```
    /// # use copq::*;
    /// # fn show(backend: &dyn Backend, policy: &Policy) -> Result<()> {
    /// let same = Policy::from_state(&policy.to_state()?, backend)?;
    /// assert_eq!(same.to_state()?, policy.to_state()?);
    /// # Ok(())
    /// # }
    /// ```
    pub fn from_state(state: &State, backend: &dyn Backend) -> Result<Self> {
        let about = About::read(state.child("policy")?)?;
        let mut actor = fresh(&about, backend)?;
        actor.import(state.child("actor")?)?;
        let normaliser = Normaliser::of(state, about.spec.obs_len)?;
        Ok(Self { actor, normaliser, about, obs: Vec::new() })
    }

    /// The content of its file, as above, from which other formats are made. An error if its actor
    /// has no [`Actor::export`].
    pub fn to_state(&self) -> Result<State> {
        exported(self.actor.as_ref(), self.normaliser.as_ref(), &self.about)
    }

    /// Length of an observation.
    pub fn obs_len(&self) -> usize {
        self.about.spec.obs_len
    }

    /// Length of an action.
    pub fn action_len(&self) -> usize {
        self.actor.action_len()
    }

    /// The task that it learned.
    pub fn task(&self) -> &str {
        &self.about.spec.name
    }

    /// The objectives' names, highest priority first; empty for a file of an older version.
    pub fn objectives(&self) -> &[String] {
        &self.about.objectives
    }

    /// The method that it learned with; none for a file of an older version.
    pub fn method(&self) -> Option<&str> {
        self.about.method.as_deref()
    }

    /// Writes the policy's best guess for one observation, or for each of a batch, in [-1, 1]. An
    /// error if it is not a finite number, which happens with the weights of a run that diverged.
    pub fn act(&mut self, obs: &[f32], action: &mut [f32]) -> Result<()> {
        self.obs.clear();
        self.obs.extend_from_slice(obs);
        if let Some(normaliser) = &self.normaliser {
            normaliser.normalise(&mut self.obs)?;
        }
        self.actor.mode(Net::Online, &self.obs, action)?;
        match action.iter().find(|a| !a.is_finite()) {
            None => Ok(()),
            Some(a) => Err(Error::invalid("the policy's action", "finite numbers", a)),
        }
    }

    /// Maps one action from [-1, 1] to the environment's bounds.
    pub fn scale(&self, action: &mut [f32]) -> Result<()> {
        check_len("action", action.len(), self.action_len())?;
        let unit = action.to_vec();
        self.about.spec.scale_action(&unit, action);
        Ok(())
    }
}

/// An actor whose weights will be replaced.
fn fresh(about: &About, backend: &dyn Backend) -> Result<Box<dyn Actor>> {
    backend.actor(&about.spec, &about.networks, about.kind, &mut Rng::new(0, Stream::Init))
}

/// A policy as its file holds it.
pub(crate) fn exported(
    actor: &dyn Actor,
    normaliser: Option<&Normaliser>,
    about: &About,
) -> Result<State> {
    let mut state = State::default();
    *state.child_mut("policy") = about.to_state();
    actor.export(state.child_mut("actor"))?;
    if let Some(normaliser) = normaliser {
        normaliser.save(state.child_mut("normaliser"));
    }
    Ok(state)
}

/// Starts with the weights and the normaliser of a policy of this or another task of the same
/// robot. A different kind of policy is an error, and so is one for a different environment.
pub(crate) fn begin_with(
    policy: &State,
    own: &About,
    actor: &mut dyn Actor,
    normaliser: &mut Option<Normaliser>,
) -> Result<()> {
    own.check_fits(policy.child("policy")?)?;
    let has = policy.child("normaliser").is_ok();
    if has != normaliser.is_some() {
        let [own, other] = if has { ["without", "with"] } else { ["with", "without"] };
        let wanted = format!("one {own} a normaliser (or normalise = {has})");
        return Err(Error::invalid("policy to begin with", wanted, format!("one {other}")));
    }
    actor.import(policy.child("actor")?)?;
    Normaliser::restore(normaliser, policy)
}
