//! Calls into MuJoCo that return an error where MuJoCo would end the process.

use std::ffi::{c_char, c_int, c_void};

use crate::c_text::words;

/// A MuJoCo function of a model and its data, such as `mj_step`.
pub(crate) type Function = unsafe extern "C" fn(model: *const c_void, data: *mut c_void);

unsafe extern "C" {
    fn copq_guard(
        call: Function,
        model: *const c_void,
        data: *mut c_void,
        times: c_int,
    ) -> *const c_char;
    /// What MuJoCo's `mju_user_error` must be for [`call`] to work.
    pub(crate) fn copq_error(text: *const c_char);
    /// What `mju_user_warning` must be for MuJoCo to write no MUJOCO_LOG.TXT.
    pub(crate) fn copq_warning(text: *const c_char);
}

/// Calls `function` `times` times, or until MuJoCo gives up; the error says why. Allocates nothing
/// unless it fails.
///
/// # Safety
/// `model` and `data` are what `function` takes, nothing else uses `data` meanwhile, and
/// `mju_user_error` is `copq_error`.
pub(crate) unsafe fn call(
    function: Function,
    model: *const c_void,
    data: *mut c_void,
    times: usize,
) -> Result<(), String> {
    let times = c_int::try_from(times)
        .map_err(|_| format!("{times} physics steps are too many at once"))?;
    // SAFETY: the caller's promise; the guard jumps over MuJoCo's own frames only, none of them
    // Rust's.
    let message = unsafe { copq_guard(function, model, data, times) };
    // SAFETY: the guard returns null or a string of this thread that lasts until the next call.
    if message.is_null() { Ok(()) } else { Err(unsafe { words(message) }) }
}
