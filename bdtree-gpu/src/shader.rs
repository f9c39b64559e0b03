//! The passes of compute shaders, put together from their parts.

/// What a pass computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Points from fields of positions.
    Points,
    /// Unit normals from fields of normals.
    Normals,
    /// Unit normals from the points that were written.
    Exact,
}

/// One compute pipeline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Variant {
    pub(crate) pass: Pass,
    /// Whether bones carry the vertices; exact normals do not ask.
    pub(crate) skinned: bool,
    /// Whether vertices list their modes; of exact normals, whether there is a list of vertices.
    pub(crate) listed: bool,
    /// Whether a thread does eight instances, or one.
    pub(crate) wide: bool,
}

impl Variant {
    /// Number of variants; [`Variant::index`] is below it.
    pub(crate) const COUNT: usize = 24;

    pub(crate) fn index(self) -> usize {
        let pass = match self.pass {
            Pass::Points => 0,
            Pass::Normals => 1,
            Pass::Exact => 2,
        };
        8 * pass
            + 4 * usize::from(self.skinned)
            + 2 * usize::from(self.listed)
            + usize::from(self.wide)
    }

    /// Instances of one thread.
    pub(crate) fn lanes(self) -> u32 {
        if self.wide { 8 } else { 1 }
    }

    pub(crate) fn source(self) -> String {
        let lanes = match self.wide {
            true => include_str!("shaders/lanes_8.wgsl"),
            false => include_str!("shaders/lanes_1.wgsl"),
        };
        let fields = match self.listed {
            true => include_str!("shaders/fields_listed.wgsl"),
            false => include_str!("shaders/fields_all.wgsl"),
        };
        let bones = match (self.skinned, self.listed) {
            (false, _) => include_str!("shaders/no_bones.wgsl"),
            (true, true) => include_str!("shaders/bones.wgsl"),
            (true, false) => concat!(
                include_str!("shaders/bones.wgsl"),
                // `fields_all.wgsl` has none.
                "@group(0) @binding(3) var<storage, read> lists: array<u32>;"
            ),
        };
        let own = match self.pass {
            Pass::Points => [
                fields,
                include_str!("shaders/skin.wgsl"),
                include_str!("shaders/finish_points.wgsl"),
            ],
            Pass::Normals => [
                fields,
                include_str!("shaders/skin.wgsl"),
                include_str!("shaders/finish_normals.wgsl"),
            ],
            Pass::Exact => [
                include_str!("shaders/exact.wgsl"),
                match self.wide {
                    true => include_str!("shaders/gather_8.wgsl"),
                    false => include_str!("shaders/gather_1.wgsl"),
                },
                match self.listed {
                    true => include_str!("shaders/exact_listed.wgsl"),
                    false => include_str!("shaders/exact_all.wgsl"),
                },
            ],
        };
        let mut text = String::new();
        for part in [include_str!("shaders/common.wgsl"), lanes, bones]
            .into_iter()
            .chain(own)
        {
            text.push_str(part);
            text.push('\n');
        }
        text
    }
}
