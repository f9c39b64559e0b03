//! Tests of one program: linking one is quicker than linking each.

mod devices;
mod limits;
mod normals;
mod positions;
mod vertex_shader;
