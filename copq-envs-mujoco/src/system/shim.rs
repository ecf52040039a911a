//! `shim.c`, through which a MuJoCo opened at run time is called.

use std::ffi::{c_char, c_int, c_void};

/// An mjModel.
pub(super) type Model = c_void;
/// An mjData.
pub(super) type Data = c_void;

/// The same fields in the same order as in C.
#[repr(C)]
pub(super) struct Shim {
    /// The version of the headers it was compiled with, as `mj_version` counts.
    pub header: c_int,
    /// Opens a library, writes its version, and finds what it needs if that is the version of the
    /// headers. Returns null, or what went wrong.
    pub open: unsafe extern "C" fn(path: *const c_char, version: *mut c_int) -> *const c_char,
    pub load: unsafe extern "C" fn(
        mjcf: *const c_char,
        length: c_int,
        error: *mut c_char,
        size: c_int,
    ) -> *mut Model,
    pub delete_model: unsafe extern "C" fn(model: *mut Model),
    pub make_data: unsafe extern "C" fn(model: *const Model) -> *mut Data,
    pub delete_data: unsafe extern "C" fn(data: *mut Data),
    pub run: unsafe extern "C" fn(
        call: c_int,
        model: *const Model,
        data: *mut Data,
        times: c_int,
    ) -> *const c_char,
    pub array: unsafe extern "C" fn(
        model: *const Model,
        data: *mut Data,
        which: c_int,
        length: *mut c_int,
    ) -> *mut f64,
    pub warning: unsafe extern "C" fn(data: *const Data) -> *const c_char,
    pub mul_m: unsafe extern "C" fn(
        model: *const Model,
        data: *const Data,
        result: *mut f64,
        vector: *const f64,
    ),
}

unsafe extern "C" {
    /// Null if there were no headers at build time, otherwise valid for ever.
    pub(super) safe fn copq_mujoco() -> *const Shim;
}
