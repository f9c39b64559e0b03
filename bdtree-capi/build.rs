//! The name under which programs find the shared library, and what it is linked with.

use std::env;
use std::fs;
use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("linux") {
        return;
    }
    // While the major version is 0, minor ones may change the interface.
    println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libbdtree.so.0.1");
    if env::var("CARGO_CFG_TARGET_ENV").as_deref() != Ok("gnu") {
        return;
    }
    // std asks for libgcc_s.so, which unwinds. In its place the linker finds the same code as a static library, so that
    // the shared library needs nothing but libc.
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let script = "GROUP ( libgcc_eh.a libgcc.a )\n";
    fs::write(folder.join("libgcc_s.so"), script).expect("OUT_DIR can be written");
    println!("cargo::rustc-cdylib-link-arg=-L{}", folder.display());
}
