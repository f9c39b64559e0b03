#!/usr/bin/env python3
"""Holds the readers that format-spec/bdt.ksy gives in Python and JavaScript against each other, against SPEC.md's tables,
and against `bdtree info --json`; has them refuse the files of fixtures/rules; and runs the example of
format-spec/README.md.

Usage: check.py FOLDER BDTREE, where FOLDER holds bdt.py and Bdt.js. ci/kaitai.sh makes them.
"""
import json
import math
import pathlib
import re
import struct
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER, BDTREE = sys.argv[1:3]
sys.path[:0] = [FOLDER, str(ROOT / "tests/kaitai"), str(ROOT / "tests/python")]

import bdt_reader  # noqa: E402
import dump  # noqa: E402
import records  # noqa: E402
from bdt import Bdt  # noqa: E402
from kaitaistruct import KaitaiStruct  # noqa: E402

# What `info` computes by posing the mesh: no field of the file.
POSED = {"bounds_at_rest", "growth_mean"}


def same(what, found, expected):
    if found != expected:
        sys.exit(f"{what}: {str(found)[:300]} is not {str(expected)[:300]}")


def in_javascript(files):
    command = ["node", str(ROOT / "tests/kaitai/dump.js"), FOLDER, *map(str, files)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    return [json.loads(line) for line in lines]


def stored(record):
    """The numbers of a record in the order in which they stand; bytes as numbers."""
    if isinstance(record, KaitaiStruct):
        parameters = type(record).__init__.__code__.co_varnames
        own = [name for name in dump.names(record)[0] if name not in parameters]
        return [x for name in own for x in stored(getattr(record, name))]
    if isinstance(record, (list, bytes)):
        return [x for element in record for x in stored(element)]
    return [record.value if hasattr(record, "value") else record]


def check_records(name, asset, data, spec):
    """Every number of the file is where SPEC.md says, under the name that it has there."""
    told = records.File(spec, data)
    same(f"{name}: header", stored(asset.header), told.header)
    same(f"{name}: modes", stored(asset.modes), told.modes)
    table = [(s.kind.encode(), s.layout, s.offset, s.length, s.crc, s.required) for s in asset.table]
    same(f"{name}: section table", table, told.table)
    bodies = {record.kind: section.body for record, section in zip(asset.table, asset.sections)}
    same(f"{name}: sections", list(bodies), list(told.bytes))
    for kind, body in bodies.items():
        if kind in told.sections:
            same(f"{name}: {kind}", stored(body), told.sections[kind])
        elif kind in ("SNAM", "GNAM"):
            same(f"{name}: {kind}", body.text, told.bytes[kind])
        elif kind != "META":  # which `info` tells whole
            same(f"{name}: {kind}", body, told.bytes[kind])
        record = records.RECORDS.get(kind)
        if record:
            first = body if kind in ("SKIN", "MASS") else next((x for x in flat(body)), None)
            for field, _ in told.fields[record]:
                same(f"{record}: {field}", first is None or hasattr(first, field), True)
    return sum(map(len, told.sections.values())) + len(told.header) + len(told.modes)


def flat(body):
    """The records of a section."""
    for part in getattr(body, "records", None) or getattr(body, "nodes", None) or body.vertices:
        yield from part.records if hasattr(part, "records") else [part]


def f32(x):
    return struct.pack("<f", x)


def info_of(asset, data):
    """What `info` tells of a file, from the reader's fields; q limits and ranges as the bytes of an f32."""
    header, metadata, skeleton = asset.header, asset.metadata, asset.skeleton
    unit = 2.0 ** header.unit_exponent
    corners = [asset.positions.records[v] for t in asset.triangles.records for v in t.corners]
    place = [[header.origin[k] + unit * getattr(p, "xyz"[k]) for p in corners] for k in range(3)]
    radii = [[] for _ in range(header.depth)]
    for node, rows in zip(asset.nodes.records, asset.rows.nodes):
        radii[node.level] += [r for k, r in enumerate(rows.radius) if node.used >> k & 1]
    omegas = [None if mode.omega_rad_s == -1 else mode.omega_rad_s / math.tau for mode in asset.modes]
    described = metadata.modes if metadata else [None] * header.mode_count
    times = [frame.time_s for frame in asset.frames.records] if asset.frames else []
    mass, error = asset.mass, metadata and getattr(metadata, "basis_error_rel", None)
    settings = metadata and {s.name.value: s.value.value for s in metadata.settings}
    joint_of = {joint.node: j for j, joint in enumerate(asset.joints.records)} if skeleton else {}

    def joint_above(node):
        above = skeleton.nodes[node].parent
        while above != 0xFFFFFFFF and above not in joint_of:
            above = skeleton.nodes[above].parent
        return joint_of.get(above)

    return dict(
        version=f"{header.version_major}.{header.version_minor}", bytes=len(data), vertices=header.vertex_count,
        triangles=header.triangle_count, modes=header.mode_count, nodes=header.node_count, depth=header.depth,
        origin=header.origin, bounds=dict(min=[min(x) for x in place], max=[max(x) for x in place]),
        scale_m=float(settings["scale"]) if settings and "scale" in settings else None,
        mass=mass and dict(
            mass_kg=mass.mass_kg, center_of_mass=mass.center_of_mass, inertia=mass.inertia,
            density_kg_m3=mass.density_kg_m3, scale_m=mass.scale_m, volume=mass.volume, source=mass.source.name),
        q_limit=[f32(mode.q_limit) for mode in asset.modes], q_range=[f32(mode.q_range) for mode in asset.modes],
        source=dict(name=metadata and metadata.source_name.value, hash=metadata and metadata.source_hash.hex()),
        mode_info=[dict(
            name=text.name.value if text and text.has_name else None, frequency_hz=frequency,
            modal_mass_kg=None if mode.modal_mass_kg == -1 else mode.modal_mass_kg,
            default_q=text.default_q if text and text.has_default_q else None)
            for mode, text, frequency in zip(asset.modes, described, omegas)],
        frames=len(times) or None, duration_s=times[-1] - times[0] if times and times[0] >= 0 else None,
        highest_frequency_hz=max((x for x in omegas if x is not None), default=None),
        sections=[dict(kind=s.kind, offset=s.offset, bytes=s.length) for s in asset.table],
        levels=[dict(level=level, spheres=len(own), radius_mean=sum(own) / len(own) * unit, radius_max=max(own) * unit)
                for level, own in enumerate(radii)],
        unit=unit, leaf_triangles_max=header.leaf_triangles_max,
        builder=metadata and metadata.builder.value, basis=metadata and metadata.basis.value,
        basis_error_rel=error and dict(
            max=error.max, rms=error.rms, frame=error.frame if error.has_frame else None,
            vertex=error.vertex if error.has_vertex else None),
        settings=settings, warnings=metadata and [text.value for text in metadata.warnings],
        # One of unknown kind is ignored (SPEC 7.4).
        groups=[dict(kind=group.kind.name, name=group.name, first_triangle=group.first_triangle,
                     triangles=group.triangle_count)
                for group in (asset.groups.records if asset.groups else []) if hasattr(group.kind, "name")],
        joints=skeleton and [dict(name=skeleton.nodes[joint.node].name, parent=joint_above(joint.node))
                             for joint in asset.joints.records],
        clips=skeleton and [dict(name=clip.name, duration_s=clip.duration_s)
                            for clip in (asset.clips.records if asset.clips else [])],
        bones=skeleton and len(asset.bones.records), influences_max=skeleton and asset.skin.influences_max)


def check_info(name, asset, data, file):
    printed = subprocess.run([BDTREE, "info", "--json", str(file)], capture_output=True, check=True).stdout
    told, own = json.loads(printed), info_of(asset, data)
    for numbers in ("q_limit", "q_range"):
        told[numbers] = [f32(x) for x in told[numbers]]
    same(f"{name}: the keys of `bdtree info --json`", set(own) | POSED, set(told))
    for key, value in own.items():
        same(f"{name}: {key}", value, told[key])
    return len(own)


def golden():
    """The golden files, and the example of SPEC.md."""
    files = sorted((ROOT / "fixtures/golden").glob("*.bdt")) + [ROOT / "format-spec/tests/example.bdt"]
    assert len(files) > 5, files
    spec = (ROOT / "format-spec/SPEC.md").read_text()
    counts = [0, 0]
    for file, javascript in zip(files, in_javascript(files), strict=True):
        name, data = file.name, file.read_bytes()
        python = dump.read(file)
        assert "fields" in python, f"{name}: {python}"
        same(f"{name}: Python and JavaScript", javascript, python)
        asset = Bdt.from_bytes(data)
        counts[0] += check_records(name, asset, data, spec)
        counts[1] += check_info(name, asset, data, file)
    print(f"{len(files)} files: both readers agree; {counts[0]} numbers are those of SPEC.md's tables, "
          f"{counts[1]} facts those of `bdtree info --json`")


def is_read(file):
    """Whether the reader of tests/python takes a file."""
    try:
        bdt_reader.info(file.read_bytes())
    except ValueError:
        return False
    return True


def rules():
    """Both readers refuse what the index calls structural, and nothing else; and they take the sound files."""
    folder = ROOT / "fixtures/rules"
    index = json.loads((folder / "index.json").read_text())
    expected = {entry["file"]: entry["structural"] for entry in index}
    expected |= {file.name: False for file in folder.glob("sound_*.bdt")}
    files = [folder / name for name in expected]
    for file, refused, javascript in zip(files, expected.values(), in_javascript(files), strict=True):
        found = ("refused" in dump.read(file), "refused" in javascript)
        same(f"{file.name}: refused by Python, by JavaScript", found, (refused, refused))
        # Written from SPEC.md alone, and it checks more: all that the schema holds it has to hold, too.
        same(f"{file.name}: refused by tests/python", refused and is_read(file), False)
    structural = sum(expected.values())
    print(f"{len(index)} files that break a rule each: both readers refuse {structural} of them, and the index says why not "
          f"the other {len(index) - structural}")


def example():
    """The Python of format-spec/README.md, run where it says that it runs."""
    text = (ROOT / "format-spec/README.md").read_text()
    [program] = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(program.splitlines()) <= 10, program
    [expected] = re.findall(r"It prints\n\n```text\n(.*?)```", text, re.S)
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT / "format-spec",
                         env={"PYTHONPATH": ":".join([FOLDER, *sys.path])})
    same("the example of format-spec/README.md", (run.stdout, run.stderr), (expected, ""))
    print("the example of format-spec/README.md prints what it says")


golden()
rules()
example()
