//! glTF files: what is read, what is refused and where, and what morph targets become.

mod buffers;
mod clips;
mod corpus;
mod document;
mod frames;
mod hostile;
mod mistakes;
mod morph;
mod read;
mod skin_mistakes;
mod skin_rows;
mod skins;
mod spaces;
mod support;
mod twin;
