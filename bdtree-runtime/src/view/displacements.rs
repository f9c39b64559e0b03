//! The displacements of one vertex, whichever layout the file has: of all modes (SPEC 7.3), or of
//! those of the vertex's mode list (SPEC 7.6).

use bdtree_format::{SectionKind, VertexModes};

use crate::contact::VertexId;
use crate::error::{Datum, FormatError, OUT_LENGTH};
use crate::view::Asset;

/// How the modes move a vertex: U_ij (stored units per unit of q).
#[derive(Debug, Clone, Copy)]
pub struct Displacements<'a> {
    fields: &'a [[f32; 3]],
    /// The mode of each field; `None`: the k-th is that of mode k.
    modes: Option<&'a [u16]>,
}

impl<'a> Displacements<'a> {
    /// Mode and displacement of each mode that is stored, ascending; the others do not move the
    /// vertex. In a file that was not verified, modes may be any.
    pub fn iter(&self) -> impl Iterator<Item = (usize, [f32; 3])> + use<'a> {
        let modes = self.modes;
        let fields = self.fields.iter().enumerate();
        fields.map(move |(k, u)| {
            let mode = modes.map_or(k, |modes| modes.get(k).map_or(usize::MAX, |j| (*j).into()));
            (mode, *u)
        })
    }

    /// U_ij of mode `mode`; zero where it is not stored.
    pub fn of(&self, mode: usize) -> [f32; 3] {
        let k = self.place(mode);
        k.and_then(|k| self.fields.get(k))
            .copied()
            .unwrap_or_default()
    }

    /// Whether the displacement of mode `mode` is stored.
    pub fn has(&self, mode: usize) -> bool {
        self.place(mode).is_some_and(|k| k < self.fields.len())
    }

    fn place(&self, mode: usize) -> Option<usize> {
        match self.modes {
            None => Some(mode),
            Some(modes) => modes.binary_search_by_key(&mode, |j| (*j).into()).ok(),
        }
    }
}

impl<'a> Asset<'a> {
    /// The displacements of a vertex.
    ///
    /// # Errors
    /// No such vertex; displacements or mode list outside their sections.
    #[inline]
    pub fn displacements(&self, vertex: VertexId) -> Result<Displacements<'a>, FormatError> {
        if self.lists_modes() {
            let (fields, modes) = self.listed_displacements(vertex)?;
            return Ok(Displacements {
                fields,
                modes: Some(modes),
            });
        }
        let (i, m) = (vertex.0 as usize, self.modes.len());
        if i >= self.positions.len() {
            return Err(self.unknown_vertex(vertex));
        }
        let start = i.saturating_mul(m);
        let end = start.saturating_add(m);
        match self.displacements.get(start..end) {
            Some(fields) => Ok(Displacements {
                fields,
                modes: None,
            }),
            None => {
                let len = self.displacements.len();
                Err(self.ends_outside(SectionKind::DISPLACEMENTS, end, len, 12))
            }
        }
    }

    /// A vertex of the source mesh in f64: its rest position (mesh units), and in `out`, one entry per mode, how far one unit
    /// of q of that mode moves it (mesh units), zeros for modes that do not. So with U being `out`, the vertex is at
    /// `p + U q` before bones and placement; of a contact at the weights w of a triangle's corners
    /// ([`Asset::triangle`]), U is `Σ_k w_k U_k`. What `out` holds behind the modes is left alone.
    ///
    /// # Errors
    /// If the id is not below [`Asset::vertex_count`]; `out` shorter than the mode count; a corrupt asset.
    pub fn rest_vertex(
        &self,
        vertex: VertexId,
        out: &mut [[f64; 3]],
    ) -> Result<[f64; 3], FormatError> {
        let Some(p) = self.positions.get(vertex.0 as usize) else {
            return Err(self.unknown_vertex(vertex));
        };
        let (m, found) = (self.modes.len(), out.len());
        let Some(out) = out.get_mut(..m) else {
            let place = self.at(SectionKind::DISPLACEMENTS, 0);
            return Err(place.rule(OUT_LENGTH).broken(Datum::at_least(m), found));
        };
        out.fill([0.0; 3]);
        for (mode, u) in self.displacements(vertex)?.iter() {
            let Some(out) = out.get_mut(mode) else {
                return Err(self.unknown_mode_of(vertex));
            };
            *out = u.map(|u| f64::from(u) * self.unit);
        }
        let origin = self.origin();
        Ok([0, 1, 2].map(|k| origin[k] + f64::from(p[k]) * self.unit))
    }

    /// Where the displacements and the mode list of each vertex begin, and a last record that ends
    /// them; empty where all modes are stored for all vertices.
    pub fn vertex_modes(&self) -> &'a [VertexModes] {
        self.vertex_modes
    }

    /// Whether vertices list their modes (layout 2 of DISP).
    #[inline(always)]
    pub(crate) fn lists_modes(&self) -> bool {
        !self.vertex_modes.is_empty()
    }

    /// Layout 2: of the vertex's modes, and these modes.
    #[inline(always)]
    pub(crate) fn listed_displacements(
        &self,
        vertex: VertexId,
    ) -> Result<(&'a [[f32; 3]], &'a [u16]), FormatError> {
        let i = vertex.0 as usize;
        let Some([own, next]) = self.vertex_modes_of(i) else {
            return Err(self.unknown_vertex(vertex));
        };
        let (start, end) = (own.first_entry as usize, next.first_entry as usize);
        let fields = self.displacements.get(start..end);
        // No more than modes: an unchecked file must not make a vertex endless.
        let Some(fields) = fields.filter(|fields| fields.len() <= self.modes.len()) else {
            return Err(self.broken_entries(i, start, end));
        };
        let list = own.mode_list_start as usize;
        match self.mode_lists.get(list..list.saturating_add(fields.len())) {
            Some(modes) => Ok((fields, modes)),
            None => {
                let len = self.mode_lists.len();
                let end = list.saturating_add(fields.len());
                Err(self.ends_outside(SectionKind::MODE_LISTS, end, len, 2))
            }
        }
    }

    /// Index in the displacement section of a vertex's first.
    pub(crate) fn first_displacement(&self, vertex: u32) -> usize {
        let i = vertex as usize;
        match self.vertex_modes.get(i) {
            Some(own) => own.first_entry as usize,
            None => i.saturating_mul(self.modes.len()),
        }
    }

    /// The records of vertex `i` and of the one behind it.
    #[inline(always)]
    pub(crate) fn vertex_modes_of(&self, i: usize) -> Option<&'a [VertexModes; 2]> {
        self.vertex_modes.get(i..)?.first_chunk()
    }

    /// The error for a vertex whose mode list names a mode that the asset lacks.
    #[cold]
    pub(crate) fn unknown_mode_of(&self, vertex: VertexId) -> FormatError {
        let records = self.vertex_modes_of(vertex.0 as usize);
        self.unknown_mode(records.map_or(0, |[own, _]| own.mode_list_start))
    }

    /// The error for entries of a vertex that are none.
    #[cold]
    pub(crate) fn broken_entries(&self, vertex: usize, start: usize, end: usize) -> FormatError {
        self.at(SectionKind::VERTEX_MODES, size_of::<VertexModes>() * vertex)
            .rule("SPEC 7.6: first entries ascend to the end of DISP, at most M at a time")
            .broken(start, end)
    }
}
