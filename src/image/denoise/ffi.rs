//! Open Image Denoise's C interface, loaded at run time: beside the bridge to OpenVDB the only place
//! with unsafe code.
//!
//! Lengths are checked before a pointer is handed on, handles are released where they go out of scope,
//! and a library that was opened stays in memory to the end: its threads may outlive any use of it.

#![allow(unsafe_code)]

use std::error::Error as _;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;
use std::ptr;

use libloading::Library;

/// `OIDN_DEVICE_TYPE_CPU`.
const CPU: c_int = 1;

/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

type Handle = *mut c_void;

/// Declares the functions that are used, and looks them up by their names.
macro_rules! functions {
    ($($field:ident = $name:literal: fn($($argument:ty),*) $(-> $result:ty)?;)*) => {
        /// The functions of a library that is open.
        #[derive(Debug, Clone, Copy)]
        pub(super) struct Functions {
            $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            fn from_library(library: &Library) -> Result<Self, String> {
                Ok(Self {
                    $(
                        // SAFETY: the type is that of the function in oidn.h of version 2.
                        $field: *unsafe { library.get($name) }
                            .map_err(|_| format!("has no function {}", $name))?,
                    )*
                })
            }
        }
    };
}

functions! {
    new_device = "oidnNewDevice": fn(c_int) -> Handle;
    commit_device = "oidnCommitDevice": fn(Handle);
    device_int = "oidnGetDeviceInt": fn(Handle, *const c_char) -> c_int;
    device_error = "oidnGetDeviceError": fn(Handle, *mut *const c_char) -> c_int;
    release_device = "oidnReleaseDevice": fn(Handle);
    new_filter = "oidnNewFilter": fn(Handle, *const c_char) -> Handle;
    set_image = "oidnSetSharedFilterImage":
        fn(Handle, *const c_char, Handle, c_int, usize, usize, usize, usize, usize);
    set_bool = "oidnSetFilterBool": fn(Handle, *const c_char, bool);
    commit_filter = "oidnCommitFilter": fn(Handle);
    execute_filter = "oidnExecuteFilter": fn(Handle);
    release_filter = "oidnReleaseFilter": fn(Handle);
}

impl Functions {
    /// Those of the library at `path`; a name without a folder is looked for by the loader. What it is
    /// linked with is taken from its own folder where it is there.
    ///
    /// # Errors
    /// What the loader says, or which function is missing.
    pub(super) fn open(path: &Path) -> Result<Self, String> {
        for dependency in super::search::dependencies(path) {
            // One that cannot be loaded is told of by the library itself.
            let _ = load(&dependency);
        }
        Self::from_library(load(path)?)
    }

    /// A processor as a device.
    ///
    /// # Errors
    /// The library's message, where it has no module for this processor.
    pub(super) fn device(&self) -> Result<Device<'_>, String> {
        // SAFETY: takes no pointer; a null handle is told apart by `check`.
        let handle = unsafe { (self.new_device)(CPU) };
        let device = Device { functions: self, handle };
        device.check()?;
        if handle.is_null() {
            return Err("has no device for this processor".into());
        }
        // SAFETY: the handle is a device's.
        unsafe { (self.commit_device)(handle) };
        device.check()?;
        Ok(device)
    }
}

/// Loads a library for as long as the program runs.
fn load(path: &Path) -> Result<&'static Library, String> {
    // SAFETY: what runs when it is loaded are the initialisers of Open Image Denoise and of what it is
    // linked with, which ask for nothing of the program.
    let library = unsafe { Library::new(path) };
    // The error itself says no more than that it failed; its source is what the loader says.
    let told = |e: libloading::Error| e.source().map_or(e.to_string(), ToString::to_string);
    let library = library.map_err(told)?;
    Ok(Box::leak(Box::new(library)))
}

/// A device that filters run on.
#[derive(Debug)]
pub(super) struct Device<'a> {
    functions: &'a Functions,
    handle: Handle,
}

/// What the filter is shown, row by row from the top.
#[derive(Debug, Clone, Copy)]
pub(super) struct Input<'a> {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// Radiance, in any unit.
    pub color: &'a [[f32; 3]],
    /// Albedo, in [0, 1], and normal, in [-1, 1], without noise.
    pub features: Option<[&'a [[f32; 3]]; 2]>,
}

impl Device<'_> {
    /// The library's version: major, minor, patch.
    ///
    /// # Errors
    /// The library's message.
    pub(super) fn version(&self) -> Result<[i32; 3], String> {
        // SAFETY: the handle is a device's, the name ends in a null.
        let version = unsafe { (self.functions.device_int)(self.handle, c"version".as_ptr()) };
        self.check()?;
        Ok([version / 10_000, version / 100 % 100, version % 100])
    }

    /// What the filter for ray tracing in high dynamic range makes of `input`.
    ///
    /// # Errors
    /// The library's message, or that an image has not as many pixels as `size` says.
    pub(super) fn filter(&self, input: &Input<'_>) -> Result<Vec<[f32; 3]>, String> {
        let [width, height] = input.size;
        let named = [(c"albedo", 0), (c"normal", 1)];
        let features = input.features.iter();
        let features = features.flat_map(|images| named.map(|(name, index)| (name, images[index])));
        let images: Vec<(&CStr, &[[f32; 3]])> =
            std::iter::once((c"color", input.color)).chain(features).collect();
        for (name, pixels) in &images {
            if Some(pixels.len()) != width.checked_mul(height) {
                return Err(format!("{name:?} has {} pixels, not {width}x{height}", pixels.len()));
            }
        }
        let mut output = vec![[0.0_f32; 3]; input.color.len()];
        // SAFETY: the handle is a device's, the name ends in a null.
        let handle = unsafe { (self.functions.new_filter)(self.handle, c"RT".as_ptr()) };
        let filter = Filter { functions: self.functions, handle };
        self.check()?;
        if handle.is_null() {
            return Err("has no filter for ray tracing".into());
        }
        for (name, pixels) in images {
            // The filter does not write to what it is shown.
            filter.set_image(name, pixels.as_ptr().cast_mut().cast(), input.size);
        }
        filter.set_image(c"output", output.as_mut_ptr().cast(), input.size);
        filter.set_bool(c"hdr", true);
        filter.set_bool(c"cleanAux", input.features.is_some());
        // SAFETY: the handle is a filter's; all its images have as many pixels as it was told and live
        // until it is released, and it is done when this returns.
        unsafe {
            (self.functions.commit_filter)(filter.handle);
            (self.functions.execute_filter)(filter.handle);
        }
        self.check()?;
        drop(filter);
        Ok(output)
    }

    /// The library's last message, if something went wrong.
    fn check(&self) -> Result<(), String> {
        let mut message = ptr::null();
        // SAFETY: a null handle asks for the thread's own error; the message is copied before the
        // library is called again, and ends in a null where it is there.
        let text = unsafe {
            let code = (self.functions.device_error)(self.handle, &raw mut message);
            match (code, message.is_null()) {
                (0, _) => return Ok(()),
                (code, true) => format!("error {code}"),
                (_, false) => CStr::from_ptr(message).to_string_lossy().into_owned(),
            }
        };
        Err(text)
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the handle is a device's and not used again.
            unsafe { (self.functions.release_device)(self.handle) };
        }
    }
}

/// A filter that is released in the end.
struct Filter<'a> {
    functions: &'a Functions,
    handle: Handle,
}

impl Filter<'_> {
    /// Names the image whose pixels begin at `pixels`, three f32 each, row after row without gaps.
    fn set_image(&self, name: &CStr, pixels: Handle, [width, height]: [usize; 2]) {
        let set = self.functions.set_image;
        // SAFETY: the handle is a filter's; the callers' images have `width` times `height` pixels.
        unsafe { set(self.handle, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0) };
    }

    fn set_bool(&self, name: &CStr, value: bool) {
        // SAFETY: the handle is a filter's, the name ends in a null.
        unsafe { (self.functions.set_bool)(self.handle, name.as_ptr(), value) };
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the handle is a filter's and not used again.
            unsafe { (self.functions.release_filter)(self.handle) };
        }
    }
}
