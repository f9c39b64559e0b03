fn bdtree_block_rows() -> u32 { return 12u + bdtree_params.mode_count; }

fn bdtree_blend(vertex: u32, instance: u32) {}

fn bdtree_carried(p: vec3<f32>) -> vec3<f32> { return p; }
