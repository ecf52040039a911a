//! The environment: a task on an engine.

use copq::error::check_len;
use copq::{Env, EnvSpec, Error, Outcome, Result, Rng, State};

use crate::task::{Motion, Options, SignalSum, task_with};
use crate::{Physics, Readings, RobotSpec, Task};

/// The random stream of reset noise; [`copq::Stream`] reserves the small numbers for the learner.
const NOISE_STREAM: u64 = 0x0065_6e76;

/// A [`Task`] on an engine, as a [`copq::Env`].
///
/// Actions are clamped to [-1, 1]. Each is scaled to its motor's control range and held for
/// `frame_skip` physics steps. The reward vector is computed from the state after the step. An
/// episode is terminated when the robot becomes unhealthy, even on step `horizon`. It is truncated
/// if the robot reaches `horizon` healthy.
///
/// ```
/// # use copq::{Result, State};
/// # use copq_envs::{Dims, Physics};
/// # struct Frozen(Vec<f64>, Vec<f64>);
/// # impl Physics for Frozen {
/// #     fn name(&self) -> &str { "frozen" }
/// #     fn dims(&self) -> Dims { Dims { nq: 6, nv: 6, nu: 3 } }
/// #     fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
/// #         (self.0, self.1) = (qpos.to_vec(), qvel.to_vec()); Ok(())
/// #     }
/// #     fn step(&mut self, _: &[f64], _: usize) -> Result<()> { Ok(()) }
/// #     fn qpos(&self, out: &mut [f64]) { out.copy_from_slice(&self.0); }
/// #     fn qvel(&self, out: &mut [f64]) { out.copy_from_slice(&self.1); }
/// #     fn save(&self, _: &mut State) -> Result<()> { Ok(()) }
/// #     fn load(&mut self, _: &State) -> Result<()> { Ok(()) }
/// # }
/// # let engine = Frozen(vec![0.0; 6], vec![0.0; 6]);
/// use copq::{Env, Outcome};
/// use copq_envs::Locomotion;
///
/// // On an engine in which nothing moves; copq_envs_rapier::Rapier is one in which things do.
/// let mut env = Locomotion::new(copq_envs::task("a/hopper")?, engine)?;
/// let mut obs = [0.0; 11];
/// let mut reward = [0.0; 3];
/// env.reset(0, &mut obs)?;
/// let outcome = env.step(&[0.5, -2.0, 0.0], &mut obs, &mut reward)?; // -2 is clamped to -1
/// assert_eq!((outcome, reward), (Outcome::Running, [1.0, 0.0, -1.25]));
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Debug)]
pub struct Locomotion<P> {
    spec: EnvSpec,
    task: Task,
    physics: P,
    phase: Phase,
    steps: usize,
    qpos: Vec<f64>,
    qvel: Vec<f64>,
    ctrl: Vec<f64>,
    readings: Readings,
    /// The tracked point's x and y.
    place: [f64; 2],
}

impl<P: Physics> Locomotion<P> {
    /// Puts a task on an engine that holds the task's robot and reports the fields the task needs.
    pub fn new(task: Task, mut physics: P) -> Result<Self> {
        task.robot.check()?;
        task.objectives.iter().try_for_each(SignalSum::check)?;
        let dims = task.robot.dims();
        if physics.dims() != dims {
            return Err(Error::invalid(
                format!("{} on {}", task.name, physics.name()),
                format!("{dims:?}"),
                format!("{:?}", physics.dims()),
            ));
        }
        let spec = task.env_spec().versions(physics.name());
        spec.check()?;
        let mut readings = Readings::new(task.fields(), &task.robot);
        // An engine that does not provide a field says so now rather than mid-run.
        readings.read(&mut physics).map_err(|source| Error::other(needs(&task), source))?;
        let qpos = vec![0.0; dims.nq];
        let qvel = vec![0.0; dims.nv];
        let ctrl = vec![0.0; dims.nu];
        Ok(Self {
            spec,
            task,
            physics,
            phase: Phase::Fresh,
            steps: 0,
            qpos,
            qvel,
            ctrl,
            readings,
            place: [0.0; 2],
        })
    }

    /// The environment of the task with this name (see [`tasks`](crate::tasks)) and these options,
    /// on the engine that `engine` makes for its robot. The error for an unknown name lists the
    /// nearest ones.
    pub fn make(
        name: &str,
        options: &Options,
        engine: impl FnOnce(&RobotSpec) -> Result<P>,
    ) -> Result<Self> {
        let task = task_with(name, options)?;
        let physics = engine(&task.robot)?;
        Self::new(task, physics)
    }

    /// The task.
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// The engine.
    pub fn physics(&self) -> &P {
        &self.physics
    }

    /// The generalised position after the last reset or step.
    pub fn qpos(&self) -> &[f64] {
        &self.qpos
    }

    /// Sets the controls from an action; returns the sums of the squared, clamped actions and of
    /// the squared controls.
    fn act(&mut self, action: &[f32]) -> Result<[f64; 2]> {
        if let Some(index) = action.iter().position(|value| !value.is_finite()) {
            return Err(self.error(format!("action[{index}] is {}", action[index])));
        }
        let mut squares = [0.0; 2];
        for ((ctrl, actuator), unit) in
            self.ctrl.iter_mut().zip(&self.task.robot.actuators).zip(action)
        {
            let unit = f64::from(unit.clamp(-1.0, 1.0));
            let [low, high] = actuator.range;
            *ctrl = 0.5 * (low + high) + 0.5 * (high - low) * unit;
            squares[0] += unit * unit;
            squares[1] += *ctrl * *ctrl;
        }
        Ok(squares)
    }

    /// Reads the state back from the engine.
    fn read(&mut self) -> Result<()> {
        self.physics.qpos(&mut self.qpos);
        self.physics.qvel(&mut self.qvel);
        self.readings.read(&mut self.physics)?;
        if self.qpos.iter().chain(&self.qvel).all(|value| value.is_finite())
            && self.readings.is_finite()
        {
            return Ok(());
        }
        Err(self.error(format!(
            "{}'s state is not finite after step {}",
            self.physics.name(),
            self.steps
        )))
    }

    /// The x and y of the robot's velocity point.
    fn place(&self) -> [f64; 2] {
        self.task.robot.velocity_point.place(&self.task.robot, &self.qpos, &self.readings)
    }

    fn observe(&self, obs: &mut [f32]) {
        self.task.robot.observation.write(
            &self.task.robot,
            &self.qpos,
            &self.qvel,
            &self.readings,
            obs,
        );
    }

    fn outcome(&self, healthy: bool) -> Outcome {
        if !healthy {
            Outcome::Terminated
        } else if self.steps >= self.task.horizon {
            Outcome::Truncated
        } else {
            Outcome::Running
        }
    }

    /// An error if there is no episode to step.
    fn check_running(&self) -> Result<()> {
        match self.phase {
            Phase::Running => Ok(()),
            Phase::Fresh => Err(self.error("step before the first reset".into())),
            Phase::Over => Err(self.error(format!(
                "step after the episode ended at step {}; reset first",
                self.steps
            ))),
        }
    }

    fn error(&self, what: String) -> Error {
        Error::Env { env: self.spec.name.clone(), what }
    }
}

impl<P: Physics> Env for Locomotion<P> {
    fn spec(&self) -> &EnvSpec {
        &self.spec
    }

    fn reset(&mut self, seed: u64, obs: &mut [f32]) -> Result<()> {
        check_len("observation", obs.len(), self.spec.obs_len)?;
        self.phase = Phase::Over;
        self.steps = 0;
        let mut rng = Rng::with_stream(seed, NOISE_STREAM);
        let [position, velocity] = self.task.robot.reset_noise;
        for (value, start) in self.qpos.iter_mut().zip(&self.task.robot.initial_qpos) {
            *value = start + position.draw(&mut rng);
        }
        self.qvel.iter_mut().for_each(|value| *value = velocity.draw(&mut rng));
        self.task.robot.normalise(&mut self.qpos);
        self.physics.reset_to(&self.qpos, &self.qvel)?;
        self.read()?;
        self.place = self.place();
        self.phase = Phase::Running;
        self.observe(obs);
        Ok(())
    }

    fn step(&mut self, action: &[f32], obs: &mut [f32], reward: &mut [f32]) -> Result<Outcome> {
        self.check_running()?;
        check_len("action", action.len(), self.spec.action_len())?;
        check_len("observation", obs.len(), self.spec.obs_len)?;
        check_len("reward", reward.len(), self.spec.objectives.len())?;
        let [control, motor_control] = self.act(action)?;
        self.steps += 1;
        // Over until the step has succeeded: a failed engine must be reset.
        self.phase = Phase::Over;
        self.physics.step(&self.ctrl, self.task.robot.frame_skip)?;
        self.read()?;
        let healthy = self.task.robot.health.test(&self.qpos, &self.qvel);
        let before = self.place;
        self.place = self.place();
        let velocity = [0, 1].map(|axis| (self.place[axis] - before[axis]) / self.task.robot.dt());
        let motion = Motion { healthy, velocity, control, motor_control, readings: &self.readings };
        for (reward, objective) in reward.iter_mut().zip(&self.task.objectives) {
            *reward = objective.reward(&motion) as f32;
        }
        self.observe(obs);
        let outcome = self.outcome(healthy);
        if outcome == Outcome::Running {
            self.phase = Phase::Running;
        }
        Ok(outcome)
    }

    fn save(&self, state: &mut State) -> Result<()> {
        state.put("phase", [self.phase as u64]);
        state.put("steps", [self.steps as u64]);
        state.put("place", self.place);
        self.physics.save(state.child_mut("physics"))
    }

    fn load(&mut self, state: &State) -> Result<()> {
        let phase = Phase::from_number(state.get_one("phase")?)?;
        let steps = state.get_one::<u64>("steps")? as usize;
        self.phase = Phase::Over;
        self.physics.load(state.child("physics")?)?;
        self.steps = steps;
        self.read()?;
        state.read("place", &mut self.place)?;
        self.phase = phase;
        Ok(())
    }
}

fn needs(task: &Task) -> String {
    format!(
        "{} reads {:?} from its engine (the options `senses` and `preset` choose what it reads)",
        task.name,
        task.fields()
    )
}

/// Whether there is an episode to step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
enum Phase {
    Fresh = 0,
    Running = 1,
    Over = 2,
}

impl Phase {
    /// The inverse of `self as u64`.
    fn from_number(number: u64) -> Result<Self> {
        match number {
            0 => Ok(Self::Fresh),
            1 => Ok(Self::Running),
            2 => Ok(Self::Over),
            other => Err(Error::invalid("saved phase of an episode", "0, 1 or 2", other)),
        }
    }
}
