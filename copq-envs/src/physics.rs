//! The interface between robots and engines: what an engine must be able to do.

use copq::{Error, Result, State};

use crate::Field;

/// The sizes of a model.
///
/// ```
/// use copq_envs::Dims;
///
/// // Two slides and four hinges, three of them with a motor.
/// let hopper = copq_envs::task("a/hopper")?.robot;
/// assert_eq!(hopper.dims(), Dims { nq: 6, nv: 6, nu: 3 });
/// # Ok::<(), copq::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dims {
    /// Length of the generalised position qpos.
    pub nq: usize,
    /// Length of the generalised velocity qvel (one less than `nq` for each free joint).
    pub nv: usize,
    /// Number of actuators.
    pub nu: usize,
}

/// A world with one robot in it, in the generalised coordinates of [`RobotSpec`](crate::RobotSpec).
///
/// The same state and controls give the same bits with the same build on the same machine. The
/// caller must get lengths right (an engine may panic if they are wrong). The engine must check
/// numbers (it returns an error).
///
/// ```
/// use copq::{Result, State, check_env};
/// use copq_envs::{Dims, Locomotion, Physics};
///
/// /// Keeps a robot where it was put.
/// struct Frozen {
///     dims: Dims,
///     qpos: Vec<f64>,
///     qvel: Vec<f64>,
/// }
///
/// impl Physics for Frozen {
///     fn name(&self) -> &str {
///         "frozen"
///     }
///     fn dims(&self) -> Dims {
///         self.dims
///     }
///     fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
///         (self.qpos, self.qvel) = (qpos.to_vec(), qvel.to_vec());
///         Ok(())
///     }
///     fn step(&mut self, _ctrl: &[f64], _substeps: usize) -> Result<()> {
///         Ok(())
///     }
///     fn qpos(&self, out: &mut [f64]) {
///         out.copy_from_slice(&self.qpos);
///     }
///     fn qvel(&self, out: &mut [f64]) {
///         out.copy_from_slice(&self.qvel);
///     }
///     fn save(&self, state: &mut State) -> Result<()> {
///         state.put("qpos", self.qpos.as_slice());
///         state.put("qvel", self.qvel.as_slice());
///         Ok(())
///     }
///     fn load(&mut self, state: &State) -> Result<()> {
///         state.read("qpos", &mut self.qpos)?;
///         state.read("qvel", &mut self.qvel)
///     }
/// }
///
/// let task = copq_envs::task("a/hopper")?;
/// let dims = task.robot.dims();
/// let engine = Frozen { dims, qpos: vec![0.0; dims.nq], qvel: vec![0.0; dims.nv] };
/// let report = check_env(&mut Locomotion::new(task, engine)?)?;
/// assert_eq!(report.lengths, [1_000; 5]); // it never falls
/// # Ok::<(), copq::Error>(())
/// ```
pub trait Physics: Send {
    /// The engine's name and version, as printed in reports.
    fn name(&self) -> &str;

    /// The sizes of the model.
    fn dims(&self) -> Dims;

    /// Forgets everything, including contact memory, and takes on this position and velocity (SI
    /// units, radians).
    fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()>;

    /// Advances `substeps` physics timesteps with the controls held. A state that stops being
    /// finite is an [`Error::Env`](copq::Error::Env), never a silent reset.
    fn step(&mut self, ctrl: &[f64], substeps: usize) -> Result<()>;

    /// Writes the generalised position.
    fn qpos(&self, out: &mut [f64]);

    /// Writes the generalised velocity.
    fn qvel(&self, out: &mut [f64]);

    /// Writes all that [`Physics::load`] needs to continue bit for bit, even in another process.
    fn save(&self, state: &mut State) -> Result<()>;

    /// Restores what [`Physics::save`] wrote, which must come from the same model and engine.
    fn load(&mut self, state: &State) -> Result<()>;

    /// Writes a quantity ([`Field::len`] numbers) from the engine's last evaluation of its model.
    /// Some engines evaluate after a step; MuJoCo does so before it, so its fields are up to one
    /// physics step older than qpos.
    ///
    /// What an engine computes only here costs nothing to callers who do not ask for it.
    fn read(&mut self, field: Field, out: &mut [f64]) -> Result<()> {
        let _ = out;
        Err(Error::Env {
            env: self.name().into(),
            what: format!("this engine does not provide {field:?}"),
        })
    }

    /// The whole robot's centre of mass in world axes (m), if the engine reports it.
    fn centre_of_mass(&self) -> Option<[f64; 3]> {
        None
    }

    /// The joint-space mass matrix with armature (nv x nv, row-major) at the current position, if
    /// the engine reports it.
    fn mass_matrix(&self) -> Option<Vec<f64>> {
        None
    }
}

/// A boxed engine is an engine, so that a program can choose one at run time.
impl<P: Physics + ?Sized> Physics for Box<P> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn dims(&self) -> Dims {
        (**self).dims()
    }

    fn reset_to(&mut self, qpos: &[f64], qvel: &[f64]) -> Result<()> {
        (**self).reset_to(qpos, qvel)
    }

    fn step(&mut self, ctrl: &[f64], substeps: usize) -> Result<()> {
        (**self).step(ctrl, substeps)
    }

    fn qpos(&self, out: &mut [f64]) {
        (**self).qpos(out);
    }

    fn qvel(&self, out: &mut [f64]) {
        (**self).qvel(out);
    }

    fn save(&self, state: &mut State) -> Result<()> {
        (**self).save(state)
    }

    fn load(&mut self, state: &State) -> Result<()> {
        (**self).load(state)
    }

    fn read(&mut self, field: Field, out: &mut [f64]) -> Result<()> {
        (**self).read(field, out)
    }

    fn centre_of_mass(&self) -> Option<[f64; 3]> {
        (**self).centre_of_mass()
    }

    fn mass_matrix(&self) -> Option<Vec<f64>> {
        (**self).mass_matrix()
    }
}
