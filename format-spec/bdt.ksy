# Every section, record and field of SPEC.md, with the rules that one pass over the bytes can check. Fields whose names
# begin with `check_` take no bytes: they hold a rule on what was read before them.
meta:
  id: bdt
  title: Reduced deformable mesh with a tree of bounding spheres (.bdt), version 0.5
  file-extension: bdt
  license: MIT OR Apache-2.0
  ks-version: 0.11
  endian: le
doc: |
  One triangle mesh whose vertices move as p' = p + U q, and a tree of spheres that bounds the moved mesh for every q. With
  a skin, bones then carry the moved vertices. Numbers in `doc` strings are sections of SPEC.md. Lengths are stored units
  (2^unit_exponent mesh units, relative to the origin) unless a field says otherwise. Whoever reads a file reads it
  whole. What is not checked: checksums (2.4, 4.1), whether text is UTF-8, whether every mode list is used, and whether
  bounds hold for the vertices that they bound.
doc-ref: SPEC.md
seq:
  - id: header
    type: header
  - id: modes
    type: mode_record(_index)
    repeat: expr
    repeat-expr: header.mode_count
    doc: What a reader needs to know of each mode (2.2).
  - id: check_range
    size: 0
    valid:
      expr: 'range_of_lengths >= 9.5367431640625e-07 and range_of_lengths <= 1152921504606846976.0'
    doc: P + sum of W q_limit lies within 2^-20 to 2^60 (5.4).
  - id: table
    type: section_record(_index)
    repeat: expr
    repeat-expr: header.section_count
    doc: The section table (4.1), in the order of the sections.
  - id: header_padding
    type: u1
    repeat: expr
    repeat-expr: header.header_bytes - 128 - 32 * (header.mode_count + header.section_count)
    valid: 0
    doc: Zeros up to header_bytes (2.3).
  - id: places
    type: place(_index)
    repeat: expr
    repeat-expr: 29
    doc: Where each known kind stands in the table; takes no bytes.
  - id: check_presence
    size: 0
    valid:
      expr: >-
        places[0].is_present and places[1].is_present and places[2].is_present and places[3].is_present
        and places[4].is_present and places[5].is_present and places[6].is_present
    doc: NODE, ROWS, LIST, TRIS, SLOT, VERT and DISP are always there (4.2).
  - id: check_vertex_modes
    size: 0
    valid:
      expr: 'places[7].is_present == (places[6].layout == 2)'
    doc: VMOD is there exactly when DISP has layout 2 (4.2).
  - id: check_skin
    size: 0
    repeat: expr
    repeat-expr: 11
    valid:
      expr: 'places[8 + _index].is_present == has_skin'
    doc: The kinds from SKIN to SNAM are all there or all absent (4.2).
  - id: check_clips
    size: 0
    valid:
      expr: >-
        (places[20].is_present == places[19].is_present) and (places[21].is_present == places[19].is_present)
        and (has_skin or not places[19].is_present)
    doc: CLIP, CHAN and KEYS are all there or all absent, and absent without a skin (4.2).
  - id: check_momenta
    size: 0
    valid:
      expr: 'places[22].is_present or not places[23].is_present'
    doc: MMOM is absent without MASS (4.2).
  - id: check_frames
    size: 0
    valid:
      expr: '(places[24].is_present == places[25].is_present) and not (has_skin and places[24].is_present)'
    doc: FRMS and FRMQ are both there or both absent, and absent with a skin (4.2).
  - id: check_groups
    size: 0
    valid:
      expr: 'places[26].is_present == places[27].is_present'
    doc: GRPS and GNAM are both there or both absent (4.2).
  - id: check_skin_counts
    size: 0
    if: has_skin
    valid:
      expr: >-
        places[11].count >= 1 and places[11].count <= 4096 and places[17].count >= 1 and places[17].count <= 4096
        and places[16].count >= 1 and places[16].count <= 16384
    doc: A skin has 1 to 4096 bones, 1 to 4096 joints, 1 to 16384 nodes of the skeleton (4.2).
  - id: sections
    type: section(_index)
    repeat: expr
    repeat-expr: header.section_count
  - id: check_end
    size: 0
    valid:
      expr: _io.eof
    doc: The file ends with its last section (3.4).
instances:
  kinds:
    value: >-
      ["NODE", "ROWS", "LIST", "TRIS", "SLOT", "VERT", "DISP", "VMOD", "SKIN", "INFS", "INFL", "BONE", "BFLD", "BLSS",
      "BLST", "BROW", "SKEL", "JNTS", "SNAM", "CLIP", "CHAN", "KEYS", "MASS", "MMOM", "FRMS", "FRMQ", "GRPS", "GNAM",
      "META"]
    doc: The known kinds in the order in which they stand (4.2).
  element_bytes:
    value: '[32, 32, 2, 16, 4, 12, 12, 8, 32, 4, 8, 200, 4, 4, 16, 32, 64, 4, 1, 24, 28, 4, 128, 48, 64, 4, 20, 1, 1]'
    doc: Bytes of an element of each known kind (4.2).
  range_of_lengths:
    value: 'header.mode_count == 0 ? 1.0 * header.position_norm_max : modes[header.mode_count - 1].reach.as<f8>'
    doc: P + sum of W_j q_limit_j in stored units (5.4).
  has_skin:
    value: places[8].is_present
  nodes:
    value: sections[places[0].index].body.as<nodes>
  rows:
    value: sections[places[1].index].body.as<rows>
  mode_lists:
    value: sections[places[2].index].body.as<mode_lists>
  triangles:
    value: sections[places[3].index].body.as<triangles>
  triangle_slots:
    value: sections[places[4].index].body.as<triangle_slots>
  positions:
    value: sections[places[5].index].body.as<vectors>
  displacements:
    value: sections[places[6].index].body.as<vectors>
  vertex_modes:
    value: sections[places[7].index].body.as<vertex_modes>
    if: places[7].is_present
  skin:
    value: sections[places[8].index].body.as<skin_record>
    if: has_skin
  influence_starts:
    value: sections[places[9].index].body.as<influence_starts>
    if: has_skin
  influences:
    value: sections[places[10].index].body.as<influences>
    if: has_skin
  bones:
    value: sections[places[11].index].body.as<bones>
    if: has_skin
  bone_fields:
    value: sections[places[12].index].body.as<numbers>
    if: has_skin
  bone_list_starts:
    value: sections[places[13].index].body.as<bone_list_starts>
    if: has_skin
  bone_lists:
    value: sections[places[14].index].body.as<bone_lists>
    if: has_skin
  bone_rows:
    value: sections[places[15].index].body.as<bone_rows>
    if: has_skin
  skeleton:
    value: sections[places[16].index].body.as<skeleton>
    if: has_skin
  joints:
    value: sections[places[17].index].body.as<joints>
    if: has_skin
  skeleton_names:
    value: sections[places[18].index].body.as<names>
    if: has_skin
  clips:
    value: sections[places[19].index].body.as<clips>
    if: places[19].is_present
  channels:
    value: sections[places[20].index].body.as<channels>
    if: places[20].is_present
  keys:
    value: sections[places[21].index].body.as<keys>
    if: places[21].is_present
  mass:
    value: sections[places[22].index].body.as<mass_record>
    if: places[22].is_present
  momenta:
    value: sections[places[23].index].body.as<momenta>
    if: places[23].is_present
  frames:
    value: sections[places[24].index].body.as<frames>
    if: places[24].is_present
  frame_q:
    value: sections[places[25].index].body.as<frame_q>
    if: places[25].is_present
  groups:
    value: sections[places[26].index].body.as<groups>
    if: places[26].is_present
  group_names:
    value: sections[places[27].index].body.as<names>
    if: places[27].is_present
  metadata:
    value: sections[places[28].index].body.as<metadata>
    if: places[28].is_present
types:
  header:
    doc: The fixed header, 128 bytes (2.1).
    seq:
      - id: magic
        contents: [0x89, BDT, 0x0d, 0x0a, 0x1a, 0x0a]
      - id: version_major
        type: u2
        valid: 0
        doc: Readers know one major version (9.1).
      - id: version_minor
        type: u2
        doc: No reason to refuse a file (9.2).
      - id: header_bytes
        type: u4
        doc: Length of the header block in bytes (2.3).
      - id: file_bytes
        type: u8
        valid:
          expr: '_ == _root._io.size'
        doc: Length of the file in bytes (3.4).
      - id: header_crc
        type: u4
        doc: CRC-32 of the header block with these four bytes as zero (2.4); not checked here.
      - id: features_required
        type: u4
        valid: 0
        doc: Feature bits that a reader must know; none is defined (9.3).
      - id: features_optional
        type: u4
        doc: Feature bits that a reader may ignore; none is defined (9.3).
      - id: unit_exponent
        type: s4
        valid:
          min: -100
          max: 100
        doc: e; a stored length r means 2^e r mesh units (5.2).
      - id: origin
        type: f8
        repeat: expr
        repeat-expr: 3
        valid: &far
          expr: '_ >= -1208925819614629174706176.0 and _ <= 1208925819614629174706176.0'
        doc: x, y, z in mesh units, each at most 2^80 in magnitude; stored positions are relative to it (5.2).
      - id: vertex_count
        type: u4
        valid:
          min: 1
        doc: N.
      - id: triangle_count
        type: u4
        valid:
          min: 1
        doc: F.
      - id: mode_count
        type: u4
        valid:
          max: 512
        doc: M.
      - id: node_count
        type: u4
        valid:
          min: 1
        doc: Number of nodes of the tree.
      - id: depth
        type: u4
        valid:
          min: 1
          max: 32
        doc: Number of node levels (6.4).
      - id: section_count
        type: u4
        valid:
          min: 7
          max: 64
        doc: Number of section records; seven kinds are always there (2.1, 4.2).
      - id: position_norm_max
        type: f4
        valid: &not_negative
          expr: '_ == 0 or (_ >= 1.1754943508222875e-38 and _ <= 3.4028234663852886e+38)'
        doc: P, in stored units; at least the norm of every stored position and center (5.3).
      - id: leaf_triangles_max
        type: u4
        valid:
          min: 1
          max: 255
        doc: Upper bound of the triangles of a leaf lane (6.2).
      - id: reserved
        type: u1
        repeat: expr
        repeat-expr: 32
        valid: 0
      - id: check_header_bytes
        size: 0
        valid:
          expr: 'header_bytes == (128 + 32 * (mode_count + section_count) + 63) / 64 * 64'
        doc: header_bytes is 128 + 32 M + 32 section_count, rounded up to a multiple of 64 (2.3).
  mode_record:
    doc: A mode, 32 bytes (2.2).
    params:
      - id: index
        type: u4
    seq:
      - id: q_limit
        type: f4
        valid:
          expr: '(q_limit_bits & 0x7fffff) == 0 and q_limit_bits >= 0x00800000 and q_limit_bits <= 0x7e800000'
        doc: Hard limit of abs(q_j); a power of two from 2^-126 to 2^126 (5.4).
      - id: q_range
        type: f4
        valid:
          expr: '_ >= 1.1754943508222875e-38 and _ <= q_limit'
        doc: Typical largest abs(q_j), advisory.
      - id: step_scale
        type: f4
        valid:
          expr: '_ >= 1.1754943508222875e-38 and _ <= 3.4028234663852886e+38'
        doc: S_j, scale of the second row of step bounds (6.6).
      - id: field_norm_max
        type: f4
        valid: *not_negative
        doc: W_j, in stored units per unit of q; at least the norm of every displacement of the mode (5.3).
      - id: omega_rad_s
        type: f8
        valid:
          expr: '_ == -1 or (_ >= 0 and _ <= 1.7976931348623157e+308)'
        doc: Angular frequency in rad/s, or -1 when unknown.
      - id: modal_mass_kg
        type: f8
        valid:
          expr: '_ == -1 or (_ > 0 and _ <= 1.7976931348623157e+308)'
        doc: Modal mass in kg, or -1 when unknown.
      - id: check_reach
        size: 0
        valid:
          expr: 'reach >= 0'
        doc: Computed mode by mode, so that no language has to recurse over all modes.
    instances:
      q_limit_bits:
        io: _root._io
        pos: 128 + 32 * index
        type: u4
        doc: The bits of q_limit.
      reach:
        value: '(index == 0 ? 1.0 * _root.header.position_norm_max : _root.modes[index - 1].reach.as<f8>) + 1.0 * field_norm_max * q_limit'
        doc: P + sum of W q_limit over the modes up to this one, in stored units (5.4).
  section_record:
    doc: A section's place, 32 bytes (4.1).
    params:
      - id: index
        type: u4
    seq:
      - id: kind
        type: str
        size: 4
        encoding: ASCII
        doc: Four letters (4.2).
      - id: layout
        type: u4
        doc: Layout id of the kind (4.2).
      - id: offset
        type: u8
        doc: First byte of the section from the start of the file, a multiple of 64.
      - id: length
        type: u8
        valid:
          expr: '_ <= _root.header.file_bytes and offset <= _root.header.file_bytes - _'
        doc: Length in bytes without padding; the section lies inside the file.
      - id: crc
        type: u4
        doc: CRC-32 of the section's bytes without padding (2.4); not checked here.
      - id: required
        type: u4
        valid:
          any-of: [0, 1]
        doc: 1 where the file is to be refused when the kind is unknown, 0 where it is to be skipped.
      - id: check_known
        type: step(_index)
        repeat: until
        repeat-until: '_.index == 28 or _root.kinds[_.index] == kind'
        doc: Has rank + 1 entries when the kind is known.
      - id: check_unknown
        size: 0
        valid:
          expr: 'is_known or required == 0'
        doc: An unknown kind that is required is refused (4.4).
      - id: check_once
        size: 0
        repeat: expr
        repeat-expr: index
        valid:
          expr: '_root.table[_index].kind != kind'
        doc: No kind stands twice (4.4).
    instances:
      rank:
        value: check_known.size - 1
        doc: Place among the known kinds, if it is one of them.
      is_known:
        value: '_root.kinds[rank] == kind'
  step:
    doc: A turn of a search; no bytes. The generated languages count `_index` differently in `repeat-until`.
    params:
      - id: index
        type: u4
  place:
    doc: A known kind in the section table; no bytes.
    params:
      - id: rank
        type: u4
    seq:
      - id: check_before
        type: step(_index)
        repeat: until
        repeat-until: '_.index == _root.header.section_count - 1 or _root.table[_.index].kind == _root.kinds[rank]'
        doc: Has index + 1 entries.
      - id: check_order
        size: 0
        if: is_present and rank > 0
        valid:
          expr: 'index > _root.places[rank - 1].last_index'
        doc: Known kinds stand in this order (4.2).
      - id: check_layout
        size: 0
        if: is_present
        valid:
          expr: >-
            rank == 1 ? layout == 3 : rank == 6 ? (layout == 1 or layout == 2)
            : rank == 0 or rank == 14 or rank == 15 or rank == 28 ? layout == 2 : layout == 1
        doc: Unknown layouts are refused (4.4).
      - id: check_required
        size: 0
        if: is_present
        valid:
          expr: '(record.required == 1) == (rank <= 18)'
        doc: What queries need is required, the rest is not (4.2).
      - id: check_whole
        size: 0
        if: is_present
        valid:
          expr: 'record.length % _root.element_bytes[rank] == 0'
        doc: A section holds whole elements (4.3).
      - id: check_count
        size: 0
        if: is_present and expected_count >= 0
        valid:
          expr: 'count == expected_count'
        doc: A section's length is its count times its element size (4.3).
    instances:
      index:
        value: check_before.size - 1
        doc: Index in the table, where the kind is present.
      is_present:
        value: '_root.table[index].kind == _root.kinds[rank]'
      last_index:
        value: 'is_present ? index : rank == 0 ? -1 : _root.places[rank - 1].last_index.as<s4>'
        doc: Index of the last known kind up to this one.
      record:
        value: _root.table[index]
      layout:
        value: 'is_present ? record.layout : 0'
        doc: 0 where the kind is absent.
      count:
        value: 'is_present ? record.length / _root.element_bytes[rank] : 0'
        doc: Number of elements; 0 where the kind is absent.
      expected_count:
        value: >-
          rank == 0 ? _root.header.node_count
          : rank == 3 or rank == 4 ? _root.header.triangle_count
          : rank == 5 ? _root.header.vertex_count
          : rank == 6 and layout == 1 ? _root.header.vertex_count * _root.header.mode_count
          : rank == 7 or rank == 9 ? _root.header.vertex_count + 1
          : rank == 8 or rank == 22 ? 1
          : rank == 12 ? _root.places[11].count * _root.header.mode_count
          : rank == 13 ? _root.header.node_count + 1
          : rank == 15 ? 2 * _root.header.node_count + 2 * _root.places[14].count
          : rank == 23 ? _root.header.mode_count
          : rank == 25 ? _root.places[24].count * _root.header.mode_count
          : -1
        doc: Number of elements that the header and earlier sections ask for, or -1 where any will do.
  section:
    doc: A section with the padding before it (3.3).
    params:
      - id: index
        type: u4
    seq:
      - id: check_offset
        size: 0
        valid:
          expr: '_root.table[index].offset == (end_before + 63) / 64 * 64'
        doc: A section starts at the next multiple of 64 behind its predecessor (3.3).
      - id: padding
        type: u1
        repeat: expr
        repeat-expr: _root.table[index].offset - end_before
        valid: 0
      - id: body
        size: _root.table[index].length
        type:
          switch-on: _root.table[index].kind
          cases:
            '"NODE"': nodes
            '"ROWS"': rows
            '"LIST"': mode_lists
            '"TRIS"': triangles
            '"SLOT"': triangle_slots
            '"VERT"': vectors
            '"DISP"': vectors
            '"VMOD"': vertex_modes
            '"SKIN"': skin_record
            '"INFS"': influence_starts
            '"INFL"': influences
            '"BONE"': bones
            '"BFLD"': numbers
            '"BLSS"': bone_list_starts
            '"BLST"': bone_lists
            '"BROW"': bone_rows
            '"SKEL"': skeleton
            '"JNTS"': joints
            '"SNAM"': names
            '"CLIP"': clips
            '"CHAN"': channels
            '"KEYS"': keys
            '"MASS"': mass_record
            '"MMOM"': momenta
            '"FRMS"': frames
            '"FRMQ"': frame_q
            '"GRPS"': groups
            '"GNAM"': names
            '"META"': metadata
        doc: Of a kind that is unknown, the bytes.
    instances:
      end_before:
        value: >-
          index == 0 ? _root.header.header_bytes : _root.table[index - 1].offset + _root.table[index - 1].length
        doc: Where the section before it ends, or the header block, in bytes from the start of the file.
  nodes:
    doc: NODE, the nodes of the tree, breadth first (6.1, 6.3).
    seq:
      - id: records
        type: node_record(_index)
        repeat: expr
        repeat-expr: _root.header.node_count
      - id: check_children
        size: 0
        valid:
          expr: 'records.last.next_child == _root.header.node_count'
        doc: Every node but the root is a child (6.3).
      - id: check_slots
        size: 0
        valid:
          expr: 'records.last.next_slot == _root.header.triangle_count'
        doc: Every triangle is in one leaf lane (6.3).
      - id: check_rows
        size: 0
        valid:
          expr: 'records.last.next_row == _root.places[1].count'
        doc: Every row is a node's (6.3, 4.3).
      - id: check_depth
        size: 0
        valid:
          expr: 'records.last.level + 1 == _root.header.depth'
        doc: The header's depth is the number of node levels (6.4).
  node_record:
    doc: A node, eight child spheres side by side in lanes, 32 bytes (6.1).
    params:
      - id: index
        type: u4
    seq:
      - id: first_child
        type: u4
        valid:
          expr: '_ == (index == 0 ? 1 : _parent.records[index - 1].next_child) and _ > index'
        doc: Node index of the first inner lane's child (6.3).
      - id: first_slot
        type: u4
        valid:
          expr: '_ == (index == 0 ? 0 : _parent.records[index - 1].next_slot)'
        doc: Slot of the first leaf lane's first triangle (6.3).
      - id: row_start
        type: u4
        valid:
          expr: '_ == (index == 0 ? 0 : _parent.records[index - 1].next_row)'
        doc: Index of the node's first row (6.3).
      - id: mode_list_start
        type: u4
        doc: Index of the node's first entry in LIST (6.7).
      - id: mode_count
        type: u2
        valid:
          expr: '_ <= _root.header.mode_count'
        doc: Number m of active modes (6.1).
      - id: inner_mask
        type: u1
        doc: Bit k says that lane k leads to a child node (6.2).
      - id: leaf_mask
        type: u1
        valid:
          expr: '(_ & inner_mask) == 0 and (_ | inner_mask) != 0'
        doc: Bit k says that lane k holds triangles (6.2).
      - id: leaf_counts
        type: u1
        repeat: expr
        repeat-expr: 8
        valid:
          expr: '((leaf_mask >> _index) & 1) == 1 ? (_ >= 1 and _ <= _root.header.leaf_triangles_max) : _ == 0'
        doc: Triangles of each lane (6.2).
      - id: level
        type: u1
        valid:
          expr: '_ == (index == 0 ? 0 : _parent.records[index - 1].level + (begins_level ? 1 : 0)) and _ < _root.header.depth'
        doc: Distance from the root (6.4).
      - id: scale_exponents
        type: s1
        repeat: expr
        repeat-expr: 3
        valid:
          min: -126
        doc: a, g, h; the units of the mode rows are 2^a for centers, 2^g for growth, 2^h for cross terms (6.1, 6.5).
    instances:
      used:
        value: inner_mask | leaf_mask
        doc: Bit k says that lane k is not empty.
      child_count:
        value: >-
          (inner_mask & 1) + (inner_mask >> 1 & 1) + (inner_mask >> 2 & 1) + (inner_mask >> 3 & 1)
          + (inner_mask >> 4 & 1) + (inner_mask >> 5 & 1) + (inner_mask >> 6 & 1) + (inner_mask >> 7 & 1)
      triangle_count:
        value: >-
          leaf_counts[0] + leaf_counts[1] + leaf_counts[2] + leaf_counts[3] + leaf_counts[4] + leaf_counts[5]
          + leaf_counts[6] + leaf_counts[7]
      pair_count:
        value: (mode_count + 1) / 2
        doc: Number of pairs of active modes (6.5).
      next_child:
        value: first_child + child_count
      next_slot:
        value: first_slot + triangle_count
      next_row:
        value: row_start + 6 + 6 * pair_count
      begins_level:
        value: 'index == 0 or index == _parent.records[_parent.records[index - 1].level_start.as<u4>].first_child'
        doc: Is the first node of its level.
      level_start:
        value: 'begins_level ? index : _parent.records[index - 1].level_start.as<u4>'
        doc: Index of the first node of its level.
  rows:
    doc: ROWS, the rows of all nodes, in node order (6.5).
    seq:
      - id: nodes
        type: node_rows(_index)
        repeat: expr
        repeat-expr: _root.header.node_count
  node_rows:
    doc: The rows of a node; of each row lane k is at place k, and empty lanes hold zero (6.5).
    params:
      - id: index
        type: u4
    seq:
      - id: center_x
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: &lane
          expr: >-
            _ == 0 or (((node.used >> _index) & 1) == 1 and ((_ >= 1.1754943508222875e-38 and _ <= 3.4028234663852886e+38)
            or (_ <= -1.1754943508222875e-38 and _ >= -3.4028234663852886e+38)))
        doc: c_x of each lane's sphere at rest, in stored units.
      - id: center_y
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: *lane
        doc: c_y, in stored units.
      - id: center_z
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: *lane
        doc: c_z, in stored units.
      - id: radius
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: &bound_of_lane
          expr: >-
            _ == 0 or (((node.used >> _index) & 1) == 1 and _ >= 1.1754943508222875e-38 and _ <= 3.4028234663852886e+38)
        doc: R, in stored units.
      - id: pairs
        type: mode_pair(_index)
        repeat: expr
        repeat-expr: node.pair_count
        doc: What the node's active modes 2 k and 2 k + 1 do to the spheres.
      - id: delta_r
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: *bound_of_lane
        doc: Bound of what a step of q moves, in stored units per unit of q (6.6).
      - id: scaled_delta_r
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: *bound_of_lane
        doc: The same for steps measured as norm(S^-1 dq), in stored units (6.6).
    instances:
      node:
        value: _root.nodes.records[index]
  mode_pair:
    doc: |
      Two modes of a node, 192 bytes (6.5); of each lane the numbers of the two side by side. A number n of mode j stands
      for n 2^e / q_limit_j, where e is the node's exponent of the quantity. Where the active modes are odd in number, the
      second numbers of the last pair are zero.
    params:
      - id: index
        type: u4
    seq:
      - id: center_x
        type: s2
        repeat: expr
        repeat-expr: 16
        valid: &number_of_pair
          expr: '_ == 0 or (((_parent.node.used >> (_index / 2)) & 1) == 1 and 2 * index + _index % 2 < _parent.node.mode_count)'
        doc: x of the center's displacement, in units of 2^a.
      - id: center_y
        type: s2
        repeat: expr
        repeat-expr: 16
        valid: *number_of_pair
        doc: y of it.
      - id: center_z
        type: s2
        repeat: expr
        repeat-expr: 16
        valid: *number_of_pair
        doc: z of it.
      - id: growth
        type: s2
        repeat: expr
        repeat-expr: 16
        valid:
          expr: '_ == 0 or (_ > 0 and ((_parent.node.used >> (_index / 2)) & 1) == 1 and 2 * index + _index % 2 < _parent.node.mode_count)'
        doc: Delta R, not negative, in units of 2^g.
      - id: cross_plus
        type: s2
        repeat: expr
        repeat-expr: 16
        valid: *number_of_pair
        doc: b+, in units of 2^h.
      - id: cross_minus
        type: s2
        repeat: expr
        repeat-expr: 16
        valid: *number_of_pair
        doc: b-, in units of 2^h.
  mode_lists:
    doc: LIST, the mode lists that nodes and vertices share, in descending order (6.7).
    seq:
      - id: entries
        type: list_entry(_index)
        repeat: expr
        repeat-expr: _root.places[2].count
      - id: check_last
        size: 0
        if: entries.size > 0
        valid:
          expr: 'not entries.last.repeats'
        doc: The last list is no copy of the one before it (6.7).
      - id: check_nodes
        size: 0
        repeat: expr
        repeat-expr: _root.header.node_count
        valid:
          expr: >-
            _root.nodes.records[_index].mode_count == 0 ? _root.nodes.records[_index].mode_list_start == 0
            : (_root.nodes.records[_index].mode_list_start + _root.nodes.records[_index].mode_count <= entries.size
            and entries[_root.nodes.records[_index].mode_list_start].begins
            and entries[_root.nodes.records[_index].mode_list_start + _root.nodes.records[_index].mode_count - 1].start
            == _root.nodes.records[_index].mode_list_start
            and (_root.nodes.records[_index].mode_list_start + _root.nodes.records[_index].mode_count == entries.size
            or entries[_root.nodes.records[_index].mode_list_start + _root.nodes.records[_index].mode_count].begins))
        doc: A node's modes are one whole list, or none that starts at 0 (6.7).
  list_entry:
    doc: An entry of a mode list (6.7).
    params:
      - id: index
        type: u4
    seq:
      - id: mode
        type: u2
        valid:
          expr: '_ < _root.header.mode_count'
        doc: Index of a mode.
      - id: check_order
        size: 0
        valid:
          expr: >-
            before < 0 or not follows
            or (index - start < start - before and mode <= _parent.entries[before + index - start].mode)
        doc: A list is not above the one before it (6.7).
      - id: check_once
        size: 0
        if: begins and index > 0
        valid:
          expr: 'not _parent.entries[index - 1].repeats'
        doc: Each list stands once (6.7).
    instances:
      begins:
        value: 'index == 0 or mode <= _parent.entries[index - 1].mode'
        doc: Is the first entry of a list.
      start:
        value: 'begins ? index : _parent.entries[index - 1].start.as<u4>'
        doc: Index of the first entry of its list.
      before:
        value: 'begins ? (index == 0 ? -1 : _parent.entries[index - 1].start.as<s4>) : _parent.entries[index - 1].before.as<s4>'
        doc: Index of the first entry of the list before its own; -1 without one.
      follows:
        value: 'begins or _parent.entries[index - 1].equals.as<bool>'
        doc: Up to the entry before it, its list has what the list before has.
      equals:
        value: >-
          before >= 0 and follows and index - start < start - before
          and mode == _parent.entries[before + index - start].mode
        doc: The same up to this entry.
      repeats:
        value: 'equals and index - start == start - before - 1'
        doc: Up to this entry its list is the whole list before it.
  triangles:
    doc: TRIS, triangles in leaf order (7.1).
    seq:
      - id: records
        type: triangle_record
        repeat: expr
        repeat-expr: _root.header.triangle_count
  triangle_record:
    doc: A triangle, 16 bytes (7.1).
    seq:
      - id: corners
        type: u4
        repeat: expr
        repeat-expr: 3
        valid:
          expr: '_ < _root.header.vertex_count'
        doc: Vertex indices, in the source's order.
      - id: id
        type: u4
        valid:
          expr: '_ < _root.header.triangle_count'
        doc: Number of the triangle in the source.
  triangle_slots:
    doc: SLOT, the slot of each triangle id (7.2).
    seq:
      - id: slots
        type: u4
        repeat: expr
        repeat-expr: _root.header.triangle_count
        valid:
          expr: '_ < _root.header.triangle_count and _root.triangles.records[_].id == _index'
        doc: Index in TRIS of the triangle whose id is this place.
  vectors:
    doc: |
      VERT, the rest positions of the vertices in stored units (7.3); or DISP, displacements in stored units per unit of q,
      vertex by vertex, in layout 1 of all modes, in layout 2 of those that VMOD lists (7.3, 7.6).
    seq:
      - id: records
        type: vector
        repeat: eos
  vector:
    doc: x, y, z, 12 bytes.
    seq:
      - id: x
        type: f4
        valid: &real
          expr: >-
            _ == 0 or (_ >= 1.1754943508222875e-38 and _ <= 3.4028234663852886e+38)
            or (_ <= -1.1754943508222875e-38 and _ >= -3.4028234663852886e+38)
        doc: Finite, not subnormal (5.1).
      - id: y
        type: f4
        valid: *real
        doc: The same.
      - id: z
        type: f4
        valid: *real
        doc: The same.
  vertex_modes:
    doc: VMOD, which modes each vertex has (7.6); the last record ends the last vertex's.
    seq:
      - id: records
        type: vertex_modes_record(_index)
        repeat: expr
        repeat-expr: _root.header.vertex_count + 1
      - id: check_last
        size: 0
        valid:
          expr: 'records.last.first_entry == _root.places[6].count and records.last.mode_list_start == 0'
        doc: The last record ends DISP with list 0 (7.6).
      - id: check_vertices
        size: 0
        repeat: expr
        repeat-expr: _root.header.vertex_count
        valid:
          expr: >-
            records[_index + 1].first_entry == records[_index].first_entry ? records[_index].mode_list_start == 0
            : (records[_index].mode_list_start + records[_index + 1].first_entry - records[_index].first_entry
            <= _root.mode_lists.entries.size
            and _root.mode_lists.entries[records[_index].mode_list_start].begins
            and _root.mode_lists.entries[records[_index].mode_list_start + records[_index + 1].first_entry
            - records[_index].first_entry - 1].start == records[_index].mode_list_start
            and (records[_index].mode_list_start + records[_index + 1].first_entry - records[_index].first_entry
            == _root.mode_lists.entries.size or _root.mode_lists.entries[records[_index].mode_list_start
            + records[_index + 1].first_entry - records[_index].first_entry].begins))
        doc: A vertex's modes are one whole list, or none that starts at 0 (6.7, 7.6).
  vertex_modes_record:
    doc: Where the displacements of a vertex and its mode list begin, 8 bytes (7.6).
    params:
      - id: index
        type: u4
    seq:
      - id: first_entry
        type: u4
        valid:
          expr: >-
            index == 0 ? _ == 0 : (_ >= _parent.records[index - 1].first_entry
            and _ - _parent.records[index - 1].first_entry <= _root.header.mode_count)
        doc: Index in DISP of the vertex's first displacement.
      - id: mode_list_start
        type: u4
        doc: Index in LIST of the vertex's first mode.
  skin_record:
    doc: SKIN, what holds for the whole skin, 32 bytes (7.7).
    seq:
      - id: influences_max
        type: u4
        valid:
          max: 255
        doc: Largest number of influences of a vertex.
      - id: node_bones_max
        type: u4
        valid:
          max: 4096
        doc: Largest number of entries in a node's list of bones.
      - id: weight_defect
        type: f4
        valid: &share
          expr: '_ == 0 or (_ >= 1.1754943508222875e-38 and _ <= 1)'
        doc: At least every abs(sum of a vertex's weights - 1).
      - id: minor_share
        type: f4
        valid: *share
        doc: Most weight of a vertex that core boxes leave out (7.8).
      - id: reserved
        type: u4
        repeat: expr
        repeat-expr: 4
        valid: 0
  influence_starts:
    doc: INFS, the first influence of each vertex; the last entry ends the last vertex's (7.7).
    seq:
      - id: starts
        type: u4
        repeat: expr
        repeat-expr: _root.header.vertex_count + 1
        valid:
          expr: '_index == 0 ? _ == 0 : _ >= starts[_index - 1]'
      - id: check_last
        size: 0
        valid:
          expr: 'starts.last == _root.places[10].count'
        doc: The last entry is the length of INFL.
  influences:
    doc: INFL, the influences vertex by vertex (7.7).
    seq:
      - id: vertices
        type: vertex_influences(_index)
        repeat: expr
        repeat-expr: _root.header.vertex_count
      - id: check_most
        size: 0
        valid:
          expr: 'vertices.last.most == _root.skin.influences_max'
        doc: influences_max is the largest number of influences of a vertex.
  vertex_influences:
    doc: The bones of a vertex with their weights (7.7).
    params:
      - id: index
        type: u4
    seq:
      - id: records
        type: influence_record(_index)
        repeat: expr
        repeat-expr: _root.influence_starts.starts[index + 1] - _root.influence_starts.starts[index]
      - id: check_sum
        size: 0
        valid:
          expr: >-
            sum <= 2 and sum - 1 <= _root.skin.weight_defect + 9.094947017729282e-13 * sum
            and 1 - sum <= _root.skin.weight_defect + 9.094947017729282e-13 * sum
        doc: Weights sum to 2 at most, and weight_defect reaches the distance of the sum from 1.
      - id: check_most
        size: 0
        valid:
          expr: 'most <= _root.skin.influences_max'
        doc: Computed vertex by vertex, like the reach of modes.
    instances:
      sum:
        value: 'records.size == 0 ? 0.0 : records.last.sum'
      most:
        value: >-
          index == 0 ? records.size : (records.size > _parent.vertices[index - 1].most.as<s4> ? records.size
          : _parent.vertices[index - 1].most.as<s4>)
        doc: Largest number of influences of the vertices up to this one.
  influence_record:
    doc: A bone of a vertex, 8 bytes (7.7).
    params:
      - id: index
        type: u4
    seq:
      - id: weight
        type: f4
        valid:
          expr: '_ >= 2.3283064365386963e-10 and _ <= 2'
        doc: 2^-32 to 2.
      - id: bone
        type: u2
        valid:
          expr: '_ < _root.places[11].count and (index == 0 or _ > _parent.records[index - 1].bone)'
        doc: Index of the bone; ascending.
      - id: reserved
        type: u2
        valid: 0
    instances:
      sum:
        value: '(index == 0 ? 0.0 : _parent.records[index - 1].sum.as<f8>) + 1.0 * weight'
        doc: Of the vertex's weights up to this one.
  bones:
    doc: BONE (7.8).
    seq:
      - id: records
        type: bone_record
        repeat: expr
        repeat-expr: _root.places[11].count
  bone_record:
    doc: A bone, 200 bytes (7.8). A box that holds nothing is from 1 to -1.
    seq:
      - id: joint
        type: u4
        valid:
          expr: '_ < _root.places[17].count'
        doc: Index of the joint.
      - id: reserved
        type: u4
        valid: 0
      - id: inverse_bind
        type: f8
        repeat: expr
        repeat-expr: 12
        valid: *far
        doc: Three rows of four, from mesh coordinates to the joint's space, in mesh units.
      - id: rest
        type: f4
        repeat: expr
        repeat-expr: 12
        valid: *real
        doc: The bone's map at rest, three rows of four, in stored units.
      - id: low
        type: vector
        doc: Least coordinates of the rest positions of the vertices that the bone moves, in stored units.
      - id: high
        type: vector
        doc: Largest coordinates of them.
      - id: core_low
        type: vector
        doc: Least coordinates of the core box, which leaves out vertices with little weight.
      - id: core_high
        type: vector
        doc: Largest coordinates of it.
      - id: check_core
        size: 0
        valid:
          expr: >-
            (low.x <= core_low.x and core_low.x <= core_high.x and core_high.x <= high.x
            and low.y <= core_low.y and core_low.y <= core_high.y and core_high.y <= high.y
            and low.z <= core_low.z and core_low.z <= core_high.z and core_high.z <= high.z)
            or (core_low.x == 1 and core_low.y == 1 and core_low.z == 1
            and core_high.x == -1 and core_high.y == -1 and core_high.z == -1)
        doc: The core box lies inside low and high, or holds nothing.
  numbers:
    doc: BFLD, per bone and mode, bone-major, a bound of the displacements, in stored units per unit of q (7.8).
    seq:
      - id: values
        type: f4
        repeat: eos
        valid: *real
  bone_list_starts:
    doc: BLSS, the first entry in BLST of each node; the last entry ends the last node's (6.10).
    seq:
      - id: starts
        type: bone_list_start(_index)
        repeat: expr
        repeat-expr: _root.header.node_count + 1
      - id: check_last
        size: 0
        valid:
          expr: 'starts.last.value == _root.places[14].count'
        doc: The last entry is the length of BLST.
      - id: check_most
        size: 0
        valid:
          expr: 'starts.last.most == _root.skin.node_bones_max'
        doc: node_bones_max is the largest number of entries of a node (7.7).
  bone_list_start:
    params:
      - id: index
        type: u4
    seq:
      - id: value
        type: u4
        valid:
          expr: 'index == 0 ? _ == 0 : _ >= _parent.starts[index - 1].value'
        doc: Index in BLST.
      - id: check_most
        size: 0
        valid:
          expr: 'most <= _root.skin.node_bones_max'
        doc: Computed node by node.
    instances:
      most:
        value: >-
          index == 0 ? 0 : (value - _parent.starts[index - 1].value > _parent.starts[index - 1].most.as<u4>
          ? value - _parent.starts[index - 1].value : _parent.starts[index - 1].most.as<u4>)
        doc: Largest number of entries of the nodes before.
  bone_lists:
    doc: BLST, the bones of the nodes' lanes (6.10).
    seq:
      - id: entries
        type: bone_entry
        repeat: expr
        repeat-expr: _root.places[14].count
  bone_entry:
    doc: One bone for each lane, 16 bytes (6.10).
    seq:
      - id: bones
        type: u2
        repeat: expr
        repeat-expr: 8
        valid:
          expr: '_ < _root.places[11].count'
        doc: Index of the bone; without a meaning where the lane's middle is zero.
  bone_rows:
    doc: BROW, the bone rows of the nodes (6.10).
    seq:
      - id: nodes
        type: node_bone_rows(_index)
        repeat: expr
        repeat-expr: _root.header.node_count
  node_bone_rows:
    doc: The bone rows of a node; empty lanes hold zero (6.10).
    params:
      - id: index
        type: u4
    seq:
      - id: spread
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: *bound_of_lane
        doc: S, bound of the sum of a vertex's distances from the middles.
      - id: defect
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: *bound_of_lane
        doc: Epsilon, bound of abs(sum of a vertex's weights - 1).
      - id: entries
        type: bone_row_pair(_index)
        repeat: expr
        repeat-expr: _root.bone_list_starts.starts[index + 1].value - first
      - id: check_lanes
        type: lane_middles(_index)
        repeat: expr
        repeat-expr: 8
    instances:
      node:
        value: _root.nodes.records[index]
      first:
        value: _root.bone_list_starts.starts[index].value
        doc: Index in BLST of the node's first entry.
  bone_row_pair:
    doc: The two rows of an entry of BLST (6.10).
    params:
      - id: index
        type: u4
    seq:
      - id: middle
        type: f4
        repeat: expr
        repeat-expr: 8
        valid: &bound_of_pair
          expr: >-
            _ == 0 or (((_parent.node.used >> _index) & 1) == 1 and _ >= 1.1754943508222875e-38
            and _ <= 3.4028234663852886e+38)
        doc: Beta, the middle of the weights of the lane's bone.
      - id: gap
        type: f4
        repeat: expr
        repeat-expr: 8
        valid:
          expr: >-
            _ == 0 or (middle[_index] > 0 and _ >= 1.1754943508222875e-38 and _ <= 3.4028234663852886e+38)
        doc: g, how far the weights are from the middle; zero where that is.
      - id: check_once
        size: 0
        repeat: expr
        repeat-expr: 8 * index
        valid:
          expr: >-
            middle[_index % 8] == 0 or _parent.entries[_index / 8].middle[_index % 8] == 0
            or _root.bone_lists.entries[_parent.first + index].bones[_index % 8]
            != _root.bone_lists.entries[_parent.first + _index / 8].bones[_index % 8]
        doc: No bone has weights in two entries of a lane.
  lane_middles:
    doc: The middles of a lane sum to 1 within (m + 4) u; no bytes (6.10).
    params:
      - id: lane
        type: u4
    seq:
      - id: check_terms
        type: middle_term(_index, lane)
        repeat: expr
        repeat-expr: _parent.entries.size
      - id: check_sum
        size: 0
        valid:
          expr: >-
            sum == 0 or (sum - 1 <= (_parent.entries.size + 4) * 5.9604644775390625e-08
            and 1 - sum <= (_parent.entries.size + 4) * 5.9604644775390625e-08)
    instances:
      sum:
        value: '_parent.entries.size == 0 ? 0.0 : check_terms.last.sum'
  middle_term:
    params:
      - id: index
        type: u4
      - id: lane
        type: u4
    seq:
      - id: check_sum
        size: 0
        valid:
          expr: 'sum >= 0'
        doc: Computed term by term.
    instances:
      sum:
        value: '(index == 0 ? 0.0 : _parent.check_terms[index - 1].sum.as<f8>) + 1.0 * _parent._parent.entries[index].middle[lane]'
  skeleton:
    doc: SKEL, the nodes of the skeleton (7.8).
    seq:
      - id: nodes
        type: skeleton_node(_index)
        repeat: expr
        repeat-expr: _root.places[16].count
  skeleton_node:
    doc: A node of the skeleton, 64 bytes (7.8).
    params:
      - id: index
        type: u4
    seq:
      - id: parent
        type: u4
        valid:
          expr: '_ < index or _ == 0xffffffff'
        doc: Index of the parent, or 2^32 - 1 without one.
      - id: name_start
        type: u4
        doc: First byte of the name in SNAM.
      - id: name_bytes
        type: u4
        valid: &in_skeleton_names
          expr: '_ <= _root.places[18].count and name_start <= _root.places[18].count - _'
        doc: Length of the name in bytes.
      - id: kind
        type: u4
        enum: local_kind
        valid:
          in-enum: true
        doc: What local holds.
      - id: local
        type: f4
        repeat: expr
        repeat-expr: 12
        valid: *real
        doc: |
          From the node's space to the parent's at rest, in mesh units; parts are translation (3), rotation (a quaternion
          x, y, z, w), scale (3) and two zeros, a matrix is three rows of four.
      - id: check_parts
        size: 0
        if: kind == local_kind::parts
        valid:
          expr: 'length_squared >= 0.998047828674316406 and length_squared <= 1.001954078674316406 and local[10] == 0 and local[11] == 0'
        doc: The rotation's length is within 2^-10 of 1, and parts end with two zeros.
    instances:
      length_squared:
        value: 1.0 * local[3] * local[3] + 1.0 * local[4] * local[4] + 1.0 * local[5] * local[5] + 1.0 * local[6] * local[6]
        doc: Of the quaternion, if the node has one.
      name:
        io: _root.skeleton_names._io
        pos: name_start
        size: name_bytes
        type: str
        encoding: UTF-8
  joints:
    doc: JNTS, the node of each joint (7.8).
    seq:
      - id: records
        type: joint(_index)
        repeat: expr
        repeat-expr: _root.places[17].count
  joint:
    params:
      - id: index
        type: u4
    seq:
      - id: node
        type: u4
        valid:
          expr: '_ < _root.places[16].count'
        doc: Index in SKEL.
      - id: check_once
        size: 0
        repeat: expr
        repeat-expr: index
        valid:
          expr: '_parent.records[_index].node != node'
        doc: No node is a joint twice.
  names:
    doc: SNAM or GNAM, UTF-8 names one after the other (7.4, 7.8).
    seq:
      - id: text
        size-eos: true
  clips:
    doc: CLIP (7.9).
    seq:
      - id: records
        type: clip_record
        repeat: expr
        repeat-expr: _root.places[19].count
  clip_record:
    doc: A clip, 24 bytes (7.9).
    seq:
      - id: duration_s
        type: f8
        valid:
          expr: '_ >= 0 and _ <= 1.7976931348623157e+308'
        doc: Largest time of its keys in seconds.
      - id: name_start
        type: u4
        doc: First byte of the name in SNAM.
      - id: name_bytes
        type: u4
        valid: *in_skeleton_names
        doc: Length of the name in bytes.
      - id: first_channel
        type: u4
        doc: Index of its first channel in CHAN.
      - id: channel_count
        type: u4
        valid:
          expr: '_ <= _root.places[20].count and first_channel <= _root.places[20].count - _'
        doc: Number of its channels.
    instances:
      name:
        io: _root.skeleton_names._io
        pos: name_start
        size: name_bytes
        type: str
        encoding: UTF-8
  channels:
    doc: CHAN, the channels of all clips (7.9).
    seq:
      - id: records
        type: channel_record
        repeat: expr
        repeat-expr: _root.places[20].count
  channel_record:
    doc: A channel, 28 bytes (7.9).
    seq:
      - id: target
        type: u4
        doc: Index of the node of the skeleton, or of the first mode.
      - id: target_count
        type: u4
        valid:
          min: 1
        doc: 1, or the number of modes.
      - id: path
        type: u4
        enum: channel_path
        valid:
          in-enum: true
        doc: What is animated.
      - id: interpolation
        type: u4
        enum: interpolation
        valid:
          in-enum: true
        doc: What happens between keys.
      - id: key_count
        type: u4
        valid:
          min: 1
        doc: Number of keys.
      - id: first_number
        type: u4
        doc: Index in KEYS of the first time; values follow the times key by key.
      - id: reserved
        type: u4
        valid: 0
      - id: check_target
        size: 0
        valid:
          expr: >-
            path == channel_path::modes
            ? (target_count <= _root.header.mode_count and target <= _root.header.mode_count - target_count)
            : (target_count == 1 and target < _root.places[16].count
            and _root.skeleton.nodes[target].kind == local_kind::parts)
        doc: A channel animates one node of parts, or modes of the file.
      - id: check_keys
        size: 0
        valid:
          expr: >-
            key_count <= _root.places[21].count and key_count * (1 + numbers_per_key) <= _root.places[21].count
            and first_number <= _root.places[21].count - key_count * (1 + numbers_per_key)
        doc: The numbers lie inside KEYS.
    instances:
      numbers_per_key:
        value: >-
          (path == channel_path::modes ? target_count : path == channel_path::rotation ? 4 : 3)
          * (interpolation == interpolation::cubic ? 3 : 1)
        doc: With cubic splines an in-tangent, a value and an out-tangent each.
  keys:
    doc: KEYS, times in seconds and values of the channels' keys (7.9).
    seq:
      - id: numbers
        type: f4
        repeat: expr
        repeat-expr: _root.places[21].count
        valid: *real
      - id: check_channels
        type: channel_times(_index)
        repeat: expr
        repeat-expr: _root.places[20].count
      - id: check_clips
        type: clip_times(_index)
        repeat: expr
        repeat-expr: _root.places[19].count
  channel_times:
    doc: The times of a channel are not negative and ascend strictly; no bytes (7.9).
    params:
      - id: index
        type: u4
    seq:
      - id: check_times
        size: 0
        repeat: expr
        repeat-expr: channel.key_count
        valid:
          expr: >-
            _index == 0 ? _parent.numbers[channel.first_number] >= 0
            : _parent.numbers[channel.first_number + _index] > _parent.numbers[channel.first_number + _index - 1]
    instances:
      channel:
        value: _root.channels.records[index]
      last:
        value: _parent.numbers[channel.first_number + channel.key_count - 1]
        doc: Its largest time in seconds.
  clip_times:
    doc: duration_s is the largest time of the clip's keys; no bytes (7.9).
    params:
      - id: index
        type: u4
    seq:
      - id: check_channels
        type: clip_time(_index)
        repeat: expr
        repeat-expr: clip.channel_count
      - id: check_duration
        size: 0
        valid:
          expr: 'clip.duration_s == (clip.channel_count == 0 ? 0.0 : check_channels.last.latest)'
    instances:
      clip:
        value: _root.clips.records[index]
  clip_time:
    params:
      - id: index
        type: u4
    seq:
      - id: check_latest
        size: 0
        valid:
          expr: 'latest >= 0'
        doc: Computed channel by channel.
    instances:
      own:
        value: _parent._parent.check_channels[_parent.clip.first_channel + index].last
      latest:
        value: 'index == 0 ? own : (own > _parent.check_channels[index - 1].latest.as<f4> ? own : _parent.check_channels[index - 1].latest.as<f4>)'
        doc: Largest time of the clip's channels up to this one, in seconds.
  mass_record:
    doc: MASS, mass, center and inertia of the body at rest, 128 bytes (7.10).
    seq:
      - id: mass_kg
        type: f8
        valid: &positive
          expr: '_ > 0 and _ <= 1.7976931348623157e+308'
        doc: In kg.
      - id: center_of_mass
        type: f8
        repeat: expr
        repeat-expr: 3
        valid: &finite
          expr: '_ >= -1.7976931348623157e+308 and _ <= 1.7976931348623157e+308'
        doc: c in mesh units, in the source's coordinates.
      - id: inertia
        type: f8
        repeat: expr
        repeat-expr: 6
        valid:
          expr: '(_ > 0 or _index > 2) and _ >= -1.7976931348623157e+308 and _ <= 1.7976931348623157e+308'
        doc: About c, xx, yy, zz, xy, xz, yz, in kg (mesh unit)^2; xx = integral of (y^2 + z^2), xy = -integral of x y.
      - id: density_kg_m3
        type: f8
        valid: *positive
        doc: Mean density in kg/m^3.
      - id: scale_m
        type: f8
        valid: *positive
        doc: Meters per mesh unit.
      - id: volume
        type: f8
        valid: *positive
        doc: In (mesh unit)^3.
      - id: source
        type: u4
        enum: mass_source
        valid:
          in-enum: true
        doc: What has the mass.
      - id: reserved
        type: u1
        repeat: expr
        repeat-expr: 20
        valid: 0
      - id: check_mass
        size: 0
        valid:
          expr: >-
            mass_kg - density_kg_m3 * volume * (scale_m * scale_m * scale_m) <= 1e-9 * mass_kg
            and density_kg_m3 * volume * (scale_m * scale_m * scale_m) - mass_kg <= 1e-9 * mass_kg
        doc: Mass is density x volume x scale^3 within 1e-9.
      - id: check_inertia
        size: 0
        valid:
          expr: 'pivot_x > 0 and pivot_y > 0 and pivot_z > 0'
        doc: No principal moment is above the sum of the other two, but for 2e-9 of the trace.
    instances:
      trace:
        value: inertia[0] + inertia[1] + inertia[2]
        doc: In kg (mesh unit)^2.
      pivot_x:
        value: trace / 2 - inertia[0] + 1e-9 * trace
        doc: First pivot of the second moments t/2 - J + 1e-9 t, in kg (mesh unit)^2.
      pivot_y:
        value: trace / 2 - inertia[1] + 1e-9 * trace - inertia[3] * inertia[3] / pivot_x
        doc: Second pivot.
      below:
        value: 0 - inertia[5] - inertia[3] * inertia[4] / pivot_x
        doc: What the second pivot eliminates.
      pivot_z:
        value: trace / 2 - inertia[2] + 1e-9 * trace - inertia[4] * inertia[4] / pivot_x - below * below / pivot_y
        doc: Third pivot.
  momenta:
    doc: MMOM, the momentum of the body in each mode (7.10).
    seq:
      - id: records
        type: mode_momentum(_index)
        repeat: expr
        repeat-expr: _root.header.mode_count
  mode_momentum:
    doc: Momentum of the body per unit of dq_j/dt, 48 bytes (7.10).
    params:
      - id: index
        type: u4
    seq:
      - id: linear
        type: f8
        repeat: expr
        repeat-expr: 3
        valid: *finite
        doc: Integral of u_j, in kg mesh unit per unit of q.
      - id: angular
        type: f8
        repeat: expr
        repeat-expr: 3
        valid: *finite
        doc: Integral of (x - c) x u_j about the center of mass c, in kg (mesh unit)^2 per unit of q.
      - id: check_modal_mass
        size: 0
        valid:
          expr: '_root.modes[index].modal_mass_kg != -1'
        doc: Modes with momenta have modal masses.
  frames:
    doc: FRMS, when frames are shown and their rigid motions (7.5).
    seq:
      - id: check_some
        size: 0
        valid:
          expr: '_root.places[24].count >= 1'
        doc: An animation has at least one frame.
      - id: records
        type: frame_record(_index)
        repeat: expr
        repeat-expr: _root.places[24].count
  frame_record:
    doc: A frame, 64 bytes (7.5).
    params:
      - id: index
        type: u4
    seq:
      - id: time_s
        type: f8
        valid:
          expr: >-
            (_ == -1 and (index == 0 or _parent.records[index - 1].time_s == -1))
            or (_ >= (index == 0 ? 0.0 : _parent.records[index - 1].time_s) and _ <= 1.7976931348623157e+308
            and (index == 0 or _parent.records[index - 1].time_s >= 0))
        doc: In seconds, not descending; or -1 in every frame when unknown.
      - id: rotation
        type: f8
        repeat: expr
        repeat-expr: 4
        doc: R as a unit quaternion x, y, z, w.
      - id: check_rotation
        size: 0
        valid:
          expr: 'length_squared >= 0.999999046325683594 and length_squared <= 1.000000953674316406'
        doc: The squared length is within 2^-20 of 1.
      - id: translation
        type: f8
        repeat: expr
        repeat-expr: 3
        valid: *far
        doc: t in mesh units, each component at most 2^80 in magnitude.
    instances:
      length_squared:
        value: rotation[0] * rotation[0] + rotation[1] * rotation[1] + rotation[2] * rotation[2] + rotation[3] * rotation[3]
        doc: Of the quaternion.
  frame_q:
    doc: FRMQ, q of the frames, frame-major (7.5).
    seq:
      - id: q
        type: f4
        repeat: expr
        repeat-expr: _root.places[25].count
        valid:
          expr: >-
            _ == 0 or (_ >= 1.1754943508222875e-38 and _ <= _root.modes[_index % _root.header.mode_count].q_limit)
            or (_ <= -1.1754943508222875e-38 and 0 - _ <= _root.modes[_index % _root.header.mode_count].q_limit)
        doc: q_j of frame k at k M + j.
  groups:
    doc: GRPS, the groups of the source (7.4).
    seq:
      - id: records
        type: group_record(_index)
        repeat: expr
        repeat-expr: _root.places[26].count
  group_record:
    doc: A run of triangle ids under one name, 20 bytes (7.4).
    params:
      - id: index
        type: u4
    seq:
      - id: first_triangle
        type: u4
        valid:
          expr: 'index == 0 or _ >= _parent.records[index - 1].first_triangle'
        doc: First triangle id; not descending.
      - id: triangle_count
        type: u4
        valid:
          expr: '_ <= _root.header.triangle_count and first_triangle <= _root.header.triangle_count - _'
        doc: Number of triangles, may be 0.
      - id: kind
        type: u4
        enum: group_kind
        doc: A group of unknown kind is ignored.
      - id: name_start
        type: u4
        doc: First byte of the name in GNAM.
      - id: name_bytes
        type: u4
        valid:
          expr: '_ <= _root.places[27].count and name_start <= _root.places[27].count - _'
        doc: Length of the name in bytes.
    instances:
      name:
        io: _root.group_names._io
        pos: name_start
        size: name_bytes
        type: str
        encoding: UTF-8
  metadata:
    doc: META, what people want to know of the asset; no query needs it (8).
    seq:
      - id: builder
        type: text
        doc: Name and version of the writer.
      - id: source_name
        type: text
        doc: File name of the source without its folder.
      - id: source_hash
        size: 32
        doc: SHA-256 of the source file's bytes.
      - id: basis
        type: text
        doc: Where the basis came from.
      - id: setting_count
        type: u8
        valid: &length
          max: 4194304
      - id: settings
        type: setting(_index)
        repeat: expr
        repeat-expr: setting_count
        doc: Options of the bake.
      - id: mode_count
        type: u8
        valid:
          expr: '_ == _root.header.mode_count'
        doc: M.
      - id: modes
        type: mode_metadata
        repeat: expr
        repeat-expr: mode_count
      - id: has_basis_error_rel
        type: u1
        valid: &tag
          any-of: [0, 1]
      - id: basis_error_rel
        type: error_metadata
        if: has_basis_error_rel == 1
        doc: Error of the basis against its source.
      - id: warning_count
        type: u8
        valid: *length
      - id: warnings
        type: text
        repeat: expr
        repeat-expr: warning_count
        doc: What was odd about the source but kept.
      - id: check_end
        size: 0
        valid:
          expr: _io.eof
        doc: No bytes follow.
  text:
    seq:
      - id: length
        type: u8
        valid: *length
        doc: In bytes.
      - id: bytes
        size: length
    instances:
      value:
        value: bytes.to_s("UTF-8")
  setting:
    doc: Name and value of an option; names ascend strictly by bytes.
    params:
      - id: index
        type: u4
    seq:
      - id: name
        type: text
      - id: check_order
        size: 0
        if: index > 0
        valid:
          expr: 'name.bytes > _parent.settings[index - 1].name.bytes'
      - id: value
        type: text
  mode_metadata:
    doc: What people want to know of a mode.
    seq:
      - id: has_name
        type: u1
        valid: *tag
      - id: name
        type: text
        if: has_name == 1
        doc: Name of the mode, if the source has one.
      - id: has_default_q
        type: u1
        valid: *tag
      - id: default_q
        type: f8
        if: has_default_q == 1
        valid: *finite
        doc: The source's default weight, if it has one, in units of q.
  error_metadata:
    doc: Distances of vertices over the diagonal of the box around the rest positions.
    seq:
      - id: max
        type: f8
        valid: &error
          expr: '_ >= 0 and _ <= 1.7976931348623157e+308'
        doc: Largest over all vertices and frames.
      - id: rms
        type: f8
        valid: *error
        doc: Root mean square.
      - id: has_frame
        type: u1
        valid: *tag
      - id: frame
        type: u8
        if: has_frame == 1
        doc: The source's frame that has the largest, from 0.
      - id: has_vertex
        type: u1
        valid: *tag
      - id: vertex
        type: u8
        if: has_vertex == 1
        valid:
          expr: '_ < _root.header.vertex_count'
        doc: The vertex that has the largest.
enums:
  local_kind:
    0: parts
    1: matrix
  channel_path:
    0: translation
    1: rotation
    2: scale
    3: modes
  interpolation:
    0: linear
    1: step
    2: cubic
  mass_source:
    1: surface
    2: lattice
    3: elements
  group_kind:
    0: object
    1: group
    2: material
