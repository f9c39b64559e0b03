//! Tests of one program: linking one is quicker than linking each.

mod bones;
mod devices;
mod limits;
mod normals;
mod positions;
mod skins;
mod vertex_shader;
