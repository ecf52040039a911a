//! MuJoCo 3.17.0 through the `mujoco-rs` crate: the engine for results to report.

use std::ffi::c_void;
use std::mem::transmute;
use std::slice::{from_mut, from_ref};
use std::sync::{Arc, Once};

use ::mujoco_rs::mujoco_c;
use ::mujoco_rs::wrappers::{MjData, MjModel};
use copq::{Env, Error, Result};
use copq_envs::{Locomotion, Options, RobotSpec};

use crate::Mujoco;
use crate::c_text::words;
use crate::guard::{self, Function, copq_error, copq_warning};
use crate::simulation::{Array, Call, Simulation};
use crate::version::check_version;

/// The environment of this name (see [`copq_envs::tasks`]). The error for an unknown name lists the
/// nearest ones.
pub fn make(name: &str) -> Result<Box<dyn Env>> {
    make_with(name, &Options::default())
}

/// The environment of this name with these options.
pub fn make_with(name: &str, options: &Options) -> Result<Box<dyn Env>> {
    Ok(Box::new(Locomotion::make(name, options, physics)?))
}

/// The engine with this robot in it.
///
/// From the first call on, MuJoCo's own warnings go to stderr and never to a file.
pub fn physics(robot: &RobotSpec) -> Result<Mujoco> {
    Mujoco::new(robot, version()?, open)
}

/// The version of the linked MuJoCo, as `mj_version` counts; an error if it is not the one
/// mujoco-rs is made for.
pub fn version() -> Result<i32> {
    // SAFETY: returns a constant.
    let linked = unsafe { mujoco_c::mj_version() };
    check_version(
        mujoco_c::mjVERSION_HEADER as i32,
        linked,
        "the libmujoco that was found at run time",
    )?;
    Ok(linked)
}

fn open(mjcf: &str) -> Result<Box<dyn Simulation>> {
    let data = MjData::try_new(Arc::new(compile(mjcf)?))
        .map_err(|error| Error::other("making MuJoCo's data", error))?;
    Ok(Box::new(Linked(data)))
}

/// A model, with our handlers for MuJoCo's errors and warnings in place.
pub(crate) fn compile(mjcf: &str) -> Result<MjModel> {
    version()?;
    static HANDLERS: Once = Once::new();
    HANDLERS.call_once(|| {
        // SAFETY: two pointers that MuJoCo reads only to report something; both functions live for
        // ever.
        unsafe {
            mujoco_c::mju_user_error = Some(copq_error);
            mujoco_c::mju_user_warning = Some(copq_warning);
        }
    });
    MjModel::from_xml_string(mjcf).map_err(|error| Error::other("compiling a robot's MJCF", error))
}

/// mujoco-rs's model and data.
struct Linked(MjData<Arc<MjModel>>);

impl Simulation for Linked {
    fn array(&self, array: Array) -> &[f64] {
        let data = &self.0;
        match array {
            Array::Time => from_ref(&data.ffi().time),
            Array::Qpos => data.qpos(),
            Array::Qvel => data.qvel(),
            Array::Warmstart => data.qacc_warmstart(),
            Array::Ctrl => data.ctrl(),
            Array::Applied => data.qfrc_applied(),
            Array::Xpos => data.xpos().as_flattened(),
            Array::Xipos => data.xipos().as_flattened(),
            Array::Cinert => data.cinert().as_flattened(),
            Array::Cvel => data.cvel().as_flattened(),
            Array::QfrcActuator => data.qfrc_actuator(),
            Array::CfrcExt => data.cfrc_ext().as_flattened(),
        }
    }

    fn array_mut(&mut self, array: Array) -> &mut [f64] {
        let data = &mut self.0;
        match array {
            // SAFETY: a number that MuJoCo itself only adds to.
            Array::Time => from_mut(unsafe { &mut data.ffi_mut().time }),
            Array::Qpos => data.qpos_mut(),
            Array::Qvel => data.qvel_mut(),
            Array::Warmstart => data.qacc_warmstart_mut(),
            Array::Ctrl => data.ctrl_mut(),
            Array::Applied => data.qfrc_applied_mut(),
            Array::Xpos => data.xpos_mut().as_flattened_mut(),
            Array::Xipos => data.xipos_mut().as_flattened_mut(),
            Array::Cinert => data.cinert_mut().as_flattened_mut(),
            Array::Cvel => data.cvel_mut().as_flattened_mut(),
            Array::QfrcActuator => data.qfrc_actuator_mut(),
            Array::CfrcExt => data.cfrc_ext_mut().as_flattened_mut(),
        }
    }

    fn call(&mut self, call: Call, times: usize) -> Result<(), String> {
        type OfData = unsafe extern "C" fn(*const mujoco_c::mjModel, *mut mujoco_c::mjData);
        let function: OfData = match call {
            Call::Reset => mujoco_c::mj_resetData,
            Call::Forward => mujoco_c::mj_forward,
            Call::Step => mujoco_c::mj_step,
            Call::ContactForce => mujoco_c::mj_rnePostConstraint,
        };
        let model = std::ptr::from_ref(self.0.model().ffi()).cast::<c_void>();
        // SAFETY: the data stays where it is.
        let data = std::ptr::from_mut(unsafe { self.0.ffi_mut() }).cast::<c_void>();
        // SAFETY: functions that differ only in the types their pointers point to are called alike;
        // model and data belong together, `&mut self` keeps others away, and `open` has set the
        // handlers.
        unsafe { guard::call(transmute::<OfData, Function>(function), model, data, times) }
    }

    fn warning(&self) -> Option<String> {
        let (index, warning) =
            self.0.warning().iter().enumerate().find(|(_, warning)| warning.number > 0)?;
        // SAFETY: returns a string of this thread.
        Some(unsafe { words(mujoco_c::mju_warningText(index as i32, warning.lastinfo as usize)) })
    }

    fn mass_matrix(&self) -> Vec<f64> {
        let nv = self.0.qvel().len();
        let mut matrix = vec![0.0; nv * nv];
        // Fails only for a different length.
        let _ = self.0.full_m(&mut matrix);
        matrix
    }

    fn fork(&self) -> Result<Box<dyn Simulation>, String> {
        let data = MjData::try_new(self.0.model_clone()).map_err(|error| error.to_string())?;
        Ok(Box::new(Self(data)))
    }
}

#[cfg(test)]
mod tests {
    use super::open;
    use crate::guard_tests::{a_broken_model_is_an_error, an_internal_error_comes_back};

    #[test]
    fn internal_errors_come_back() {
        an_internal_error_comes_back(open, "memory=\"20K\"");
        a_broken_model_is_an_error(open);
    }
}
