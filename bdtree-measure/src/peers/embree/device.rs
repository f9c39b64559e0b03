//! A library of Embree and the device that everything in it belongs to.

use std::ffi::OsString;
use std::path::Path;
use std::rc::Rc;

use super::api::{Api, DevicePointer, VERSION};

/// Names Embree's shared library.
pub const VARIABLE: &str = "BDTREE_EMBREE";

/// Embree 4 on one thread.
pub struct Device {
    pub(super) api: Api,
    pub(super) pointer: DevicePointer,
    version: [isize; 3],
}

impl Device {
    /// The library that the environment variable [`VARIABLE`] names, if it is set.
    ///
    /// # Errors
    /// A library that cannot be used.
    pub fn find() -> Result<Option<Rc<Self>>, String> {
        let path: Option<OsString> = std::env::var_os(VARIABLE);
        path.map(|path| Self::open(path.as_ref())).transpose()
    }

    /// A library by its path.
    ///
    /// # Errors
    /// What is no library, lacks a function, is another major version or refuses this machine.
    pub fn open(path: &Path) -> Result<Rc<Self>, String> {
        let told = |problem| format!("{VARIABLE}: {}: {problem}", path.display());
        let api = Api::load(path).map_err(told)?;
        // SAFETY: a string that ends in zero.
        let pointer = unsafe { (api.new_device)(c"threads=1".as_ptr()) };
        if pointer.is_null() {
            // SAFETY: asks for the error of the thread, as documented for a device that was not made.
            let code = unsafe { (api.device_error)(pointer) };
            return Err(told(format!("no device, error {code}")));
        }
        // SAFETY: a device, and a property that all versions have.
        let number = unsafe { (api.device_property)(pointer, VERSION) };
        let device = Self {
            api,
            pointer,
            version: [number / 10_000, number / 100 % 100, number % 100],
        };
        if device.version[0] != 4 {
            return Err(told(format!("Embree {}, not 4", device.version())));
        }
        Ok(Rc::new(device))
    }

    /// The library's version: major, minor, patch.
    pub fn version(&self) -> String {
        self.version.map(|n| n.to_string()).join(".")
    }

    /// What went wrong since it was last asked, if anything.
    pub(super) fn check(&self) -> Result<(), String> {
        // SAFETY: the device lives as long as `self`.
        match unsafe { (self.api.device_error)(self.pointer) } {
            0 => Ok(()),
            code => Err(format!("Embree: error {code}")),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the one reference that `open` was given; Embree's own objects hold their own.
        unsafe { (self.api.release_device)(self.pointer) };
    }
}
