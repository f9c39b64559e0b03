"""What the tables of SPEC.md say stands in a file: the numbers of every section, in order.

The structs of bdtree-format are held against the same tables (format-spec/tests/spec_tables.rs), so a reader that agrees
with these numbers agrees with those structs.
"""
import re
import struct

CODES = {"u8": "B", "i8": "b", "u16": "H", "i16": "h", "u32": "I", "i32": "i", "u64": "Q", "f32": "f", "f64": "d"}
RECORDS = {"NODE": "NodeRecord", "TRIS": "TriangleRecord", "VMOD": "VertexModes", "SKIN": "SkinRecord",
           "INFL": "InfluenceRecord", "BONE": "BoneRecord", "SKEL": "SkeletonNode", "CLIP": "ClipRecord",
           "CHAN": "ChannelRecord", "MASS": "MassRecord", "MMOM": "ModeMomentum", "FRMS": "FrameRecord",
           "GRPS": "GroupRecord"}
# Sections without a record of their own: 4.2 says what their elements are.
PLAIN = {"LIST": "H", "SLOT": "I", "VERT": "3f", "DISP": "3f", "INFS": "I", "BFLD": "f", "BLSS": "I", "BLST": "8H",
         "BROW": "8f", "JNTS": "I", "KEYS": "f", "FRMQ": "f"}


def code(text):
    """The struct code of a type, `[[f32; 4]; 3]` as `12f`."""
    count = 1
    while text.startswith("["):
        text, length = text[1:-1].rsplit("; ", 1)
        count *= int(length)
    return f"{count}{CODES[text]}"


def tables(spec):
    """Per record its fields as (name, struct code)."""
    found = {}
    for name, size, table in re.findall(r"Record `(\w+)`, (\d+) bytes[^\n]*:\n(?:[^\n|]+\n)*\n((?:\|.*\n)+)", spec):
        rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
        found[name] = [(row[2], code(row[1])) for row in rows]
        packed = struct.calcsize("<" + "".join(field for _, field in found[name]))
        assert packed == int(size), f"{name}: {packed} bytes, not {size}"
    assert len(found) == 17, sorted(found)
    return found


def numbers(codes, data):
    """The numbers of an array, one after the other; bytes as numbers."""
    return [x for element in struct.iter_unpack("<" + codes, data) for x in element]


class File:
    """The numbers of a file's header, tables and sections."""

    def __init__(self, spec, data):
        self.fields = tables(spec)
        codes = {name: "".join(field for _, field in fields) for name, fields in self.fields.items()}
        self.header = numbers(codes["Header"], data[:128])
        modes, sections = self.value("Header", self.header, "mode_count"), self.value("Header", self.header, "section_count")
        end = 128 + 32 * modes
        self.modes = numbers(codes["ModeRecord"], data[128:end])
        self.table = list(struct.iter_unpack("<4s" + codes["SectionRecord"][2:], data[end:end + 32 * sections]))
        self.bytes = {kind.decode(): data[offset:offset + length] for kind, _, offset, length, *_ in self.table}
        self.sections = {}
        for kind, body in self.bytes.items():
            if kind == "ROWS":
                self.sections[kind] = self.rows(codes, body)
            elif kind in RECORDS or kind in PLAIN:
                self.sections[kind] = numbers(PLAIN.get(kind) or codes[RECORDS[kind]], body)

    def value(self, record, values, name):
        """The first number of a field in the numbers of a record."""
        at = 0
        for field, own in self.fields[record]:
            if field == name:
                return values[at]
            at += len(struct.unpack("<" + own, bytes(struct.calcsize("<" + own))))
        raise KeyError(name)

    def rows(self, codes, body):
        """6.5: four rows, a record per pair of the node's modes, two rows."""
        found, at = [], 0
        size = struct.calcsize("<" + codes["NodeRecord"])
        nodes = self.bytes["NODE"]
        for start in range(0, len(nodes), size):
            node = numbers(codes["NodeRecord"], nodes[start:start + size])
            pairs = (self.value("NodeRecord", node, "mode_count") + 1) // 2
            pattern = "<32f" + pairs * codes["ModePair"] + "16f"
            found += struct.unpack_from(pattern, body, at)
            at += struct.calcsize(pattern)
        assert at == len(body), "length of ROWS"
        return found
