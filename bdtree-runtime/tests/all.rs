//! Tests of one program: linking one is quicker than linking each.

mod narrow_distance;
mod narrow_intersect;
mod narrow_oracle;
mod narrow_ray;
mod narrow_shapes;
