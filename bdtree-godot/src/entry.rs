//! What Godot calls when it opens the library.
// Within the module: the macro drops attributes of the item.
#![allow(unsafe_code)]

use godot::prelude::*;

/// The library that Godot opens, by the name of its entry in `addon/bdtree.gdextension`.
struct Bdtree;

// SAFETY: the condition of `ExtensionLibrary` is that scripts and other extensions keep Godot's own rules, which the program that
// loads them all has to answer for. This library adds nothing to it: nodes are held by handles that are checked before use.
#[gdextension(entry_symbol = bdtree_godot_init)]
unsafe impl ExtensionLibrary for Bdtree {}
