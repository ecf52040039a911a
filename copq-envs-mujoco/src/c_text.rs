//! MuJoCo's messages.

use std::ffi::{CStr, c_char};

/// A C string from MuJoCo as a Rust string.
///
/// # Safety
/// `text` points to a string that ends in 0.
pub(crate) unsafe fn words(text: *const c_char) -> String {
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(text) }.to_string_lossy().trim_end().to_owned()
}
