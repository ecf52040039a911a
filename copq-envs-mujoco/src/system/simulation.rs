//! A model and its data in the library that was opened.

use std::ffi::{c_char, c_int};
use std::ptr::NonNull;
use std::slice::{from_raw_parts, from_raw_parts_mut};
use std::sync::{Arc, Mutex, PoisonError};

use copq::{Error, Result};

use super::library::library;
use super::shim::{Data, Model, Shim};
use crate::c_text::words;
use crate::simulation::{Array, Call, Simulation};

/// Compiles a model; one at a time, because old versions keep the last one in a global.
pub(super) fn open(mjcf: &str) -> Result<Box<dyn Simulation>> {
    static COMPILER: Mutex<()> = Mutex::new(());
    let shim = library()?;
    let _alone = COMPILER.lock().unwrap_or_else(PoisonError::into_inner);
    let mut error: [c_char; 512] = [0; 512];
    let text = mjcf.as_ptr().cast();
    let length = c_int::try_from(mjcf.len());
    let length = length.map_err(|error| Error::other("the length of a robot's MJCF", error))?;
    // SAFETY: the shim reads `length` bytes and writes a string into `error`.
    let model = unsafe { (shim.load)(text, length, error.as_mut_ptr(), error.len() as c_int) };
    let Some(model) = NonNull::new(model) else {
        // SAFETY: the shim has written a string there.
        return Err(Error::other("compiling a robot's MJCF", unsafe { words(error.as_ptr()) }));
    };
    let simulation = Opened::new(shim, Arc::new(Compiled { shim, model }));
    Ok(Box::new(simulation.map_err(|what| Error::other("making MuJoCo's data", what))?))
}

/// An mjModel; nothing writes to it.
struct Compiled {
    shim: &'static Shim,
    model: NonNull<Model>,
}

// SAFETY: MuJoCo only reads a model while it simulates, from any number of threads.
unsafe impl Send for Compiled {}
// SAFETY: as above.
unsafe impl Sync for Compiled {}

impl Drop for Compiled {
    fn drop(&mut self) {
        // SAFETY: the last reference to a model that the library made.
        unsafe { (self.shim.delete_model)(self.model.as_ptr()) }
    }
}

/// An mjData with its model.
struct Opened {
    shim: &'static Shim,
    model: Arc<Compiled>,
    data: NonNull<Data>,
}

// SAFETY: the data is owned, and MuJoCo ties it to no thread.
unsafe impl Send for Opened {}

impl Opened {
    fn new(shim: &'static Shim, model: Arc<Compiled>) -> std::result::Result<Self, String> {
        // SAFETY: the model is valid.
        let data = NonNull::new(unsafe { (shim.make_data)(model.model.as_ptr()) });
        Ok(Self { shim, model, data: data.ok_or("out of memory")? })
    }

    fn model(&self) -> *const Model {
        self.model.model.as_ptr()
    }

    /// Start and length of an array.
    fn find(&self, array: Array) -> (*mut f64, usize) {
        let mut length = 0;
        // SAFETY: model and data belong together, and `Array` has the shim's numbers.
        let start = unsafe {
            (self.shim.array)(self.model(), self.data.as_ptr(), array as c_int, &mut length)
        };
        (start, length as usize)
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        // SAFETY: owned data that the library made.
        unsafe { (self.shim.delete_data)(self.data.as_ptr()) }
    }
}

impl Simulation for Opened {
    fn array(&self, array: Array) -> &[f64] {
        let (start, length) = self.find(array);
        if length == 0 {
            return &[]; // a robot without motors, whose array may be null
        }
        // SAFETY: the array lives as long as the data, and has numbers, so it is not null.
        unsafe { from_raw_parts(start, length) }
    }

    fn array_mut(&mut self, array: Array) -> &mut [f64] {
        let (start, length) = self.find(array);
        if length == 0 {
            return &mut [];
        }
        // SAFETY: as above, and `&mut self` makes it the only slice.
        unsafe { from_raw_parts_mut(start, length) }
    }

    fn call(&mut self, call: Call, times: usize) -> std::result::Result<(), String> {
        let times = c_int::try_from(times)
            .map_err(|_| format!("{times} physics steps are too many at once"))?;
        // SAFETY: model and data belong together, and `Call` has the shim's numbers.
        let message =
            unsafe { (self.shim.run)(call as c_int, self.model(), self.data.as_ptr(), times) };
        // SAFETY: null, or a string that lasts until this thread's next call.
        if message.is_null() { Ok(()) } else { Err(unsafe { words(message) }) }
    }

    fn warning(&self) -> Option<String> {
        // SAFETY: valid data; null or a string that lasts until this thread's next call.
        unsafe {
            let warning = (self.shim.warning)(self.data.as_ptr());
            (!warning.is_null()).then(|| words(warning))
        }
    }

    fn mass_matrix(&self) -> Vec<f64> {
        let nv = self.array(Array::Qvel).len();
        let mut matrix = vec![0.0; nv * nv];
        let mut unit = vec![0.0; nv];
        for (freedom, row) in matrix.chunks_mut(nv).enumerate() {
            unit[freedom] = 1.0;
            // SAFETY: both slices have nv numbers. The matrix is symmetric, so its columns are its
            // rows.
            unsafe {
                (self.shim.mul_m)(self.model(), self.data.as_ptr(), row.as_mut_ptr(), unit.as_ptr())
            };
            unit[freedom] = 0.0;
        }
        matrix
    }

    fn fork(&self) -> std::result::Result<Box<dyn Simulation>, String> {
        Ok(Box::new(Self::new(self.shim, Arc::clone(&self.model))?))
    }
}

#[cfg(test)]
mod tests {
    use super::open;
    use crate::guard_tests::{a_broken_model_is_an_error, an_internal_error_comes_back};

    #[test]
    fn internal_errors_come_back() {
        // Later versions size stack and constraints together.
        let old = "nstack=\"20000\" njmax=\"5000\" nconmax=\"1000\"";
        an_internal_error_comes_back(
            open,
            if super::library().unwrap().header < 300 { old } else { "memory=\"20K\"" },
        );
        a_broken_model_is_an_error(open);
    }
}
