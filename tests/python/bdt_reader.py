#!/usr/bin/env python3
"""Reads a .bdt file by format-spec/SPEC.md alone and prints a part of what
`bdtree info --json` prints: what SPEC.md defines.

Usage: bdt_reader.py FILE.bdt

Python >= 3.9, standard library only. Checks checksums, padding, canonical order, numbers and
ranges, but not the bounds. Exit code 1 and one line on stderr when a rule is broken, 2 without a
file.
"""
import json
import math
import struct
import sys
import zlib
from fractions import Fraction

# kind: required, element bytes, layouts (SPEC 4.2)
KINDS = {b"NODE": (1, 32, 2), b"ROWS": (1, 32, 3), b"LIST": (1, 2, 1), b"TRIS": (1, 16, 1),
         b"SLOT": (1, 4, 1), b"VERT": (1, 12, 1), b"DISP": (1, 12, 1, 2), b"VMOD": (1, 8, 1),
         b"SKIN": (1, 32, 1), b"INFS": (1, 4, 1), b"INFL": (1, 8, 1), b"BONE": (1, 200, 1),
         b"BFLD": (1, 4, 1), b"BLSS": (1, 4, 1), b"BLST": (1, 16, 2), b"BROW": (1, 32, 2),
         b"SKEL": (1, 64, 1), b"JNTS": (1, 4, 1), b"SNAM": (1, 1, 1),
         b"CLIP": (0, 24, 1), b"CHAN": (0, 28, 1), b"KEYS": (0, 4, 1),
         b"MASS": (0, 128, 1), b"MMOM": (0, 48, 1),
         b"FRMS": (0, 64, 1), b"FRMQ": (0, 4, 1), b"GRPS": (0, 20, 1), b"GNAM": (0, 1, 1),
         b"META": (0, 1, 2)}
ALWAYS, OF_SKINS, OF_CLIPS = list(KINDS)[:7], list(KINDS)[8:19], list(KINDS)[19:22]


def check(holds, rule, what):
    if not holds:
        raise ValueError(f"{what} (SPEC {rule})")


def up64(n):
    return (n + 63) // 64 * 64


def floats(data, where):
    values = struct.unpack(f"<{len(data) // 4}f", data)
    check(all(v == 0 or 2.0 ** -126 <= abs(v) < math.inf for v in values), "5.1", where)
    return values


def short(x):
    """The f32 x as the shortest decimal that reads back equal."""
    texts = (f"{x:.{digits}g}" for digits in range(1, 10))
    return next(float(t) for t in texts if struct.pack("<f", float(t)) == struct.pack("<f", x))


def read_header(data):
    check(data[:8] == b"\x89BDT\r\n\x1a\n" and len(data) >= 128, "9.1", "no header with the magic")
    (major, minor, size, file_bytes, crc, features, _, e, *origin, n, f, m, nodes, depth, sections,
     norm, leaf_max) = struct.unpack_from("<2HIQ3Ii3d6IfI", data, 8)
    check(major == 0, "9.1", f"version {major}.{minor}")
    check(m <= 512 and sections <= 64, "2.1", "mode_count, section_count")
    check(size == up64(128 + 32 * (m + sections)) <= len(data), "2.3", f"header_bytes {size}")
    check(zlib.crc32(data[:24] + bytes(4) + data[28:size]) == crc, "2.4", "header_crc")
    check(file_bytes == len(data), "3.4", f"file_bytes {file_bytes}, found {len(data)}")
    check(not any(data[96:128] + data[128 + 32 * (m + sections):size]), "2.1", "reserved bytes, padding")
    check(features == 0, "9.3", f"unknown required features {features:#x}")
    check(min(n, f, nodes, depth, leaf_max) >= 1 and depth <= 32 and leaf_max <= 255, "2.1", "counts")
    check(abs(e) <= 100 and all(abs(o) <= 2.0 ** 80 for o in origin), "5.2", "unit, origin")
    check(floats(data[88:92], "position_norm_max")[0] >= 0, "5.1", "position_norm_max")
    modes = list(struct.iter_unpack("<4f2d", data[128:128 + 32 * m]))
    floats(b"".join(struct.pack("<4f", *mode[:4]) for mode in modes), "mode table")
    for limit, q_range, scale, w, omega, mass in modes:
        check(math.frexp(limit)[0] == 0.5 and limit <= 2.0 ** 126, "2.2", "q_limit")
        check(0 < q_range <= limit and 0 < scale and 0 <= w, "2.2", "mode table")
        check(omega == -1 or 0 <= omega < math.inf, "2.2", "omega_rad_s")
        check(mass == -1 or 0 < mass < math.inf, "2.2", "modal_mass_kg")
        norm += w * limit
    check(2.0 ** -20 <= norm <= 2.0 ** 60, "5.4", "range of lengths")
    return (f"{major}.{minor}", origin, 2.0 ** e, n, f, m, nodes, depth, sections, size, leaf_max, modes)


def read_sections(data, at, count, end):
    found, table, layouts = {}, [], {}
    for kind, layout, offset, length, crc, required in struct.iter_unpack(
            "<4sIQQII", data[at:at + 32 * count]):
        name = "".join(chr(b) if 33 <= b <= 126 else "." for b in kind)
        check(offset == up64(end) and offset + length <= len(data), "3.3", f"{name} at {offset}")
        check(not any(data[end:offset]), "3.3", f"padding before {name}")
        end = offset + length
        check(zlib.crc32(data[offset:end]) == crc, "4.1", f"checksum of {name}")
        check(required == KINDS.get(kind, (0,))[0], "4.4", f"{name}, required {required}")
        check(kind not in found, "4.4", f"{name} stands twice")
        check(kind not in KINDS or layout in KINDS[kind][2:], "4.4", f"layout {layout} of {name}")
        found[kind], layouts[kind] = data[offset:end], layout
        table.append(dict(kind=name, offset=offset, bytes=length))
    check(end == len(data), "3.4", "bytes behind the last section")
    check([k for k in found if k in KINDS] == [k for k in KINDS if k in found], "4.2", "order of kinds")
    check(all(k in found for k in ALWAYS), "4.2", "a section is missing")
    check((b"VMOD" in found) == (layouts[b"DISP"] == 2), "4.2", "VMOD and the layout of DISP")
    for kinds in ((b"GRPS", b"GNAM"), (b"FRMS", b"FRMQ"), OF_SKINS, OF_CLIPS):
        check(len({k in found for k in kinds}) == 1, "4.2", f"some sections are there: {kinds}")
    check(b"SKIN" in found or b"CLIP" not in found, "4.2", "clips without a skin")
    check(b"SKIN" not in found or b"FRMS" not in found, "4.2", "a skin and frames")
    check(b"MASS" in found or b"MMOM" not in found, "4.2", "momenta without a mass")
    return found, table


def read_lists(data, m):
    """The mode lists by where they start: in descending order, so each entry that does not ascend
    begins one."""
    entries = struct.unpack(f"<{len(data) // 2}H", data)
    check(all(j < m for j in entries), "6.7", "entries of LIST")
    starts = [i for i, j in enumerate(entries) if i == 0 or j <= entries[i - 1]]
    lists = {a: entries[a:b] for a, b in zip(starts, starts[1:] + [len(entries)])}
    contents = list(lists.values())
    check(all(a > b for a, b in zip(contents, contents[1:])), "6.7", "order of LIST")
    return lists


def use_list(lists, used, start, count, where):
    """Checks that a whole list is used, or none."""
    check(len(lists.get(start, ())) == count if count else start == 0, "6.7", f"list of {where}")
    used.update([start] if count else [])


def read_tree(s, m_all, node_count, depth, leaf_max, f, lists, used):
    """Checks nodes and rows; returns the radii of each level."""
    rows = s[b"ROWS"]
    child, slot, row = 1, 0, 0
    levels, level_of = [[] for _ in range(depth)], {0: 0}
    for i, (*firsts, start, m, inner, leaf, c0, c1, c2, c3, c4, c5, c6, c7, level, e0, e1, e2) in enumerate(
            struct.iter_unpack("<4IH11B3b", s[b"NODE"])):
        counts = (c0, c1, c2, c3, c4, c5, c6, c7)
        check(firsts == [child, slot, row] and child > i, "6.3", f"node {i}")
        check(min(e0, e1, e2) >= -126 and m <= m_all, "6.1", f"node {i}")
        check(level == level_of.pop(i) < depth, "6.4", f"level of node {i}")
        check(inner | leaf and not inner & leaf and max(counts) <= leaf_max, "6.2", f"lanes of node {i}")
        use_list(lists, used, start, m, f"node {i}")
        pairs = (m + 1) // 2
        own = rows[32 * row:32 * (row + 6 + 6 * pairs)]
        check(len(own) == 32 * (6 + 6 * pairs), "4.3", "length of ROWS")
        plain = floats(own[:128] + own[128 + 192 * pairs:], f"rows of node {i}")
        # One per pair, quantity and lane: the numbers of the two modes.
        numbers = list(struct.iter_unpack("<2h", own[128:128 + 192 * pairs]))
        check(not m % 2 or not any(second for _, second in numbers[-48:]), "6.5", f"last pair of node {i}")
        for k in range(8):
            lane = plain[k::8]
            check((leaf >> k & 1) == (counts[k] > 0), "6.2", f"lane {k} of node {i}")
            if (inner | leaf) >> k & 1:
                growths = sum((numbers[p + 24 + k] for p in range(0, 48 * pairs, 48)), ())
                check(min(lane[3:] + growths) >= 0, "6.5", f"lane {k} of node {i}")
                levels[level].append(lane[3])
            else:
                check(not any(lane + sum(numbers[k::8], ())), "6.5", f"empty lane {k} of node {i}")
        children = bin(inner).count("1")
        level_of.update((child + c, level + 1) for c in range(children))
        child, slot, row = child + children, slot + sum(counts), row + 6 + 6 * pairs
    sums, sizes = (child, slot, 32 * row), (node_count, f, len(rows))
    check(sums == sizes, "6.3", f"sums over nodes {sums}, sections {sizes}")
    check(all(levels), "6.4", "depth")
    return levels


def read_mesh(s, n, f, lists, used):
    slots = struct.unpack(f"<{f}I", s[b"SLOT"])
    for slot, (a, b, c, triangle) in enumerate(struct.iter_unpack("<4I", s[b"TRIS"])):
        check(max(a, b, c) < n, "7.1", f"corners in slot {slot}")
        check(triangle < f and slots[triangle] == slot, "7.2", f"slot {slot}")
    floats(s[b"VERT"], "VERT")
    floats(s[b"DISP"], "DISP")
    records = list(struct.iter_unpack("<2I", s.get(b"VMOD", b"")))
    if records:
        check((records[0][0], records[-1]) == (0, (len(s[b"DISP"]) // 12, 0)), "7.6", "ends of VMOD")
    for i, ((first, start), (end, _)) in enumerate(zip(records, records[1:])):
        check(first <= end, "7.6", f"entries of vertex {i}")
        use_list(lists, used, start, end - first, f"vertex {i}")
    check(used == set(lists), "6.7", "lists that nothing uses")
    before = 0
    for first, count, _, start, length in struct.iter_unpack("<5I", s.get(b"GRPS", b"")):
        name = s[b"GNAM"][start:start + length]
        check(before <= first and first + count <= f and len(name) == length, "7.4", "GRPS")
        before, _ = first, name.decode("utf-8")


def read_frames(s, limits):
    """Number of frames and seconds from the first to the last."""
    if b"FRMS" not in s:
        return None, None
    frames = list(struct.iter_unpack("<8d", s[b"FRMS"]))
    q, m = floats(s[b"FRMQ"], "FRMQ"), len(limits)
    check(frames and len(s[b"FRMS"]) % 64 == 0, "7.5", "FRMS")
    check(len(q) == len(frames) * m, "4.3", "length of FRMQ")
    times = [frame[0] for frame in frames]
    known = any(time != -1 for time in times)
    check(not known or all(0 <= a <= b < math.inf for a, b in zip([0.0] + times, times)), "7.5", "times")
    for k, (_, x, y, z, w, *translation) in enumerate(frames):
        check(abs(x * x + y * y + z * z + w * w - 1) <= 2.0 ** -20, "7.5", f"rotation of frame {k}")
        check(all(abs(t) <= 2.0 ** 80 for t in translation), "7.5", f"translation of frame {k}")
    check(all(abs(x) <= limits[i % m] for i, x in enumerate(q)), "7.5", "q of a frame is over its limit")
    return len(frames), times[-1] - times[0] if known else None


def read_mass(s, modes):
    """The mass properties as `bdtree info` has them; checks them and the momenta."""
    if b"MASS" not in s:
        return None
    *numbers, source = struct.unpack_from("<13dI", s[b"MASS"])
    mass, *rest = numbers
    center, inertia, (density, scale, volume) = rest[:3], rest[3:9], rest[9:]
    check(all(map(math.isfinite, numbers)), "7.10", "a number of MASS")
    check(min(mass, density, scale, volume) > 0, "7.10", "mass, density, scale, volume")
    check(source in (1, 2, 3) and not any(s[b"MASS"][108:]), "7.10", "source, reserved bytes")
    check(abs(mass - density * volume * scale ** 3) <= 1e-9 * mass, "7.10", "mass and volume")
    check(min(inertia[:3]) > 0, "7.10", "inertia")
    # The minors of t/2 - J + 1e-9 t, over t, in fractions: exact.
    xx, yy, zz, xy, xz, yz = map(Fraction, inertia)
    t = xx + yy + zz
    raised = t / 2 + t / 10 ** 9
    a, b, c, d, e, f = raised - xx, raised - yy, raised - zz, -xy, -xz, -yz
    check(a > 0 and a * b > d * d and a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e) > 0,
          "7.10", "principal moments")
    momenta = list(struct.iter_unpack("<6d", s.get(b"MMOM", b"")))
    check(b"MMOM" not in s or len(momenta) == len(modes), "4.3", "length of MMOM")
    check(all(math.isfinite(x) for own in momenta for x in own), "7.10", "a number of MMOM")
    check(not momenta or all(mode[5] != -1 for mode in modes), "7.10", "modal masses")
    return dict(mass_kg=mass, center_of_mass=center, inertia=inertia, density_kg_m3=density, scale_m=scale,
                volume=volume, source=("surface", "lattice", "elements")[source - 1])


def read_starts(data, end, rule, where):
    starts = struct.unpack(f"<{len(data) // 4}I", data)
    check(starts[0] == 0 and starts[-1] == end, rule, f"ends of {where}")
    check(all(a <= b for a, b in zip(starts, starts[1:])), rule, where)
    return list(zip(starts, starts[1:]))


def read_influences(s):
    """The bones of each vertex; checks them against what SKIN says."""
    influences = list(struct.iter_unpack("<f2H", s[b"INFL"]))
    most, _, defect, minor, *reserved = struct.unpack("<2I2f4I", s[b"SKIN"])
    floats(s[b"SKIN"][8:16], "SKIN")
    check(not any(reserved) and most <= 255 and 0 <= defect <= 1 and 0 <= minor <= 1, "7.7", "SKIN")
    count, bones = len(s[b"BONE"]) // 200, []
    weights = []
    for i, (start, end) in enumerate(read_starts(s[b"INFS"], len(influences), "7.7", "INFS")):
        own = influences[start:end]
        check(all(2.0 ** -32 <= w <= 2 and not zero for w, _, zero in own), "7.7", f"weights of vertex {i}")
        bones.append([b for _, b, _ in own])
        weights.append([w for w, _, _ in own])
        check(bones[i] == sorted(set(bones[i])) and max(bones[i], default=0) < count, "7.7", f"vertex {i}")
        total = math.fsum(w for w, _, _ in own)
        check(total <= 2 and abs(total - 1) <= defect + 2.0 ** -40 * total, "7.7", f"sum of vertex {i}")
    check(most == max(map(len, bones)), "7.7", "influences_max")
    return most, bones, weights, minor


def read_bones(s, m, joint_count, bones_of, weights_of, minor):
    """Checks bones against the vertices that they move."""
    bones, positions = list(struct.iter_unpack("<2I12d24f", s[b"BONE"])), list(struct.iter_unpack("<3f", s[b"VERT"]))
    fields = floats(s[b"BFLD"], "BFLD")
    check(1 <= len(bones) <= 4096 and 1 <= joint_count <= 4096, "4.2", "bones, joints")
    check(len(fields) == len(bones) * m, "4.3", "length of BFLD")
    moved, cores = [[] for _ in bones], []
    for p, own in zip(positions, bones_of):
        for b in own:
            moved[b].append(p)
    for b, (joint, reserved, *numbers) in enumerate(bones):
        floats(struct.pack("<24f", *numbers[12:]), f"bone {b}")
        check(joint < joint_count and reserved == 0, "7.8", f"joint of bone {b}")
        check(all(abs(x) <= 2.0 ** 80 for x in numbers[:12]), "7.8", f"inverse_bind of bone {b}")
        low, high, core = numbers[24:27], numbers[27:30], (numbers[30:33], numbers[33:])
        cores.append(core)
        inside = all(a <= c <= d <= e for a, c, d, e in zip(low, *core, high))
        check(inside or core == ([1.0] * 3, [-1.0] * 3), "7.8", f"core box of bone {b}")
        check(moved[b] or (low, high) == ([1.0] * 3, [-1.0] * 3), "7.8", f"box of bone {b}")
        for p in moved[b]:
            check(all(a <= x <= c for a, x, c in zip(low, p, high)), "7.8", f"box of bone {b}")
    for i, (p, own, weights) in enumerate(zip(positions, bones_of, weights_of)):
        outside = [w for b, w in zip(own, weights) if not all(a <= x <= c for a, x, c in zip(cores[b][0], p, cores[b][1]))]
        check(math.fsum(outside) <= minor * (1 + 2.0 ** -40), "7.8", f"minor_share at vertex {i}")


def read_bone_lists(s):
    """Checks the bones of nodes and their rows, but not what these bound."""
    count, entries = len(s[b"BONE"]) // 200, list(struct.iter_unpack("<8H", s[b"BLST"]))
    spans = read_starts(s[b"BLSS"], len(entries), "6.10", "BLSS")
    rows = floats(s[b"BROW"], "BROW")
    check(len(rows) == 8 * (2 * len(spans) + 2 * len(entries)), "6.10", "length of BROW")
    check(max(map(max, entries), default=0) < count, "6.10", "bones of nodes")
    for i, (start, end) in enumerate(spans):
        first = 8 * (2 * i + 2 * start)
        inner, leaf = s[b"NODE"][32 * i + 18:32 * i + 20]
        for k in range(8):
            lane = rows[first + k:first + 8 * (2 + 2 * (end - start)):8]
            check(min(lane) >= 0, "6.10", f"lane {k} of node {i}")
            check((inner | leaf) >> k & 1 or not any(lane), "6.10", f"empty lane {k} of node {i}")
            own = [entry[k] for entry, middle in zip(entries[start:end], lane[2::2]) if middle]
            check(len(own) == len(set(own)), "6.10", f"bones of lane {k} of node {i}")
            check(all(middle or not gap for middle, gap in zip(lane[2::2], lane[3::2])), "6.10", f"lane {k} of node {i}")
            off = abs(math.fsum(lane[2::2]) - 1)
            check(not own or off <= (end - start + 4) * 2.0 ** -24, "6.10", f"middles of lane {k} of node {i}")
    longest = max(end - start for start, end in spans)
    check(longest <= 4096, "7.7", "node_bones_max")
    check(struct.unpack_from("<I", s[b"SKIN"], 4)[0] == longest, "7.7", "node_bones_max")


def read_name(s, start, length):
    name = s[b"SNAM"][start:start + length]
    check(len(name) == length, "7.8", "a name outside of SNAM")
    return name.decode("utf-8")


def read_skeleton(s):
    """Name and parent of each joint, and the kind of each node."""
    nodes = list(struct.iter_unpack("<4I12f", s[b"SKEL"]))
    joints = struct.unpack(f"<{len(s[b'JNTS']) // 4}I", s[b"JNTS"])
    check(1 <= len(nodes) <= 16384, "4.2", "nodes of the skeleton")
    for i, (parent, _, _, kind, *local) in enumerate(nodes):
        floats(struct.pack("<12f", *local), f"node {i} of SKEL")
        check(parent < i or parent == 2 ** 32 - 1, "7.8", f"parent of node {i} of SKEL")
        check(kind < 2, "7.8", f"kind of node {i} of SKEL")
        unit = abs(math.hypot(*local[3:7]) - 1) <= 2.0 ** -10
        check(kind == 1 or unit and local[10:] == [0, 0], "7.8", f"parts of node {i} of SKEL")
    names = [read_name(s, *node[1:3]) for node in nodes]
    check(all(node < len(nodes) for node in joints) and len(set(joints)) == len(joints), "7.8", "JNTS")
    joint_of, parents = {node: j for j, node in enumerate(joints)}, []
    for node in joints:
        above = nodes[node][0]
        while above != 2 ** 32 - 1 and above not in joint_of:
            above = nodes[above][0]
        parents.append(joint_of.get(above))
    return ([dict(name=names[node], parent=parent) for node, parent in zip(joints, parents)],
            [node[3] for node in nodes])


def read_clips(s, kinds, m):
    """Name and seconds of each clip."""
    keys, last = floats(s.get(b"KEYS", b""), "KEYS"), []
    for i, (target, count, path, between, key_count, first, zero) in enumerate(
            struct.iter_unpack("<7I", s.get(b"CHAN", b""))):
        check(path < 4 and between < 3 and key_count >= 1 and zero == 0, "7.9", f"channel {i}")
        if path == 3:
            check(target + count <= m, "7.9", f"modes of channel {i}")
        else:
            check(count == 1 and target < len(kinds) and kinds[target] == 0, "7.9", f"node of channel {i}")
        numbers = (3, 4, 3, count)[path] * (3 if between == 2 else 1)
        check(first + key_count * (1 + numbers) <= len(keys), "7.9", f"keys of channel {i}")
        times = keys[first:first + key_count]
        check(times[0] >= 0 and all(a < b for a, b in zip(times, times[1:])), "7.9", f"times of channel {i}")
        last.append(times[-1])
    clips = []
    for seconds, start, length, first, count in struct.iter_unpack("<d4I", s.get(b"CLIP", b"")):
        check(first + count <= len(last), "7.9", "channels of a clip")
        check(seconds == max(last[first:first + count], default=0), "7.9", "duration of a clip")
        clips.append(dict(name=read_name(s, start, length), duration_s=seconds))
    return clips


def read_skin(s, m):
    """Joints, clips and the largest number of influences."""
    if b"SKIN" not in s:
        return None, None, None
    joints, kinds = read_skeleton(s)
    most, bones_of, weights_of, minor = read_influences(s)
    read_bones(s, m, len(joints), bones_of, weights_of, minor)
    read_bone_lists(s)
    return joints, read_clips(s, kinds, m), most


def read_metadata(data, n, m):
    """Source name, source hash, error of the basis, name and default weight of each mode."""
    at = 0

    def take(n):
        nonlocal at
        at += n
        check(n <= 4194304 and at <= len(data), "8", "META is too short")
        return data[at - n:at]

    def count():
        return int.from_bytes(take(8), "little")

    def text():
        return take(count()).decode("utf-8")

    def optional(value):
        tag = take(1)[0]
        check(tag < 2, "8", "a tag in META")
        return value() if tag else None

    def number():
        x = struct.unpack("<d", take(8))[0]
        check(math.isfinite(x), "8", "a number in META")
        return x

    def error():
        return dict(max=number(), rms=number(), frame=optional(count), vertex=optional(count))

    _builder, name, digest, _basis = text(), text(), take(32).hex(), text()
    _settings = [(text(), text()) for _ in range(count())]
    modes = [(optional(text), optional(number)) for _ in range(count())]
    error, _warnings = optional(error), [text() for _ in range(count())]
    check(at == len(data) and len(modes) == m, "8", "META")
    check(not error or min(error["max"], error["rms"]) >= 0 and (error["vertex"] or 0) < n, "8", "error")
    return name, digest, error, modes


def info(data):
    version, origin, unit, n, f, m, nodes, depth, sections, end, leaf_max, modes = read_header(data)
    s, table = read_sections(data, 128 + 32 * m, sections, end)
    of_mass = dict(MASS=1) if b"MASS" in s else {}
    per_vertex = dict(VMOD=n + 1) if b"VMOD" in s else dict(DISP=n * m)
    of_skin = dict(SKIN=1, INFS=n + 1, BLSS=nodes + 1) if b"SKIN" in s else {}
    for kind, count in dict(NODE=nodes, TRIS=f, SLOT=f, VERT=n, **per_vertex, **of_skin, **of_mass).items():
        check(len(s[kind.encode()]) == count * KINDS[kind.encode()][1], "4.3", f"length of {kind}")
    check(all(len(s[k]) % KINDS[k][1] == 0 for k in s if k in KINDS), "4.3", "length of a section")
    lists, used = read_lists(s[b"LIST"], m), set()
    levels = read_tree(s, m, nodes, depth, leaf_max, f, lists, used)
    read_mesh(s, n, f, lists, used)
    joints, clips, influences = read_skin(s, m)
    mass = read_mass(s, modes)
    frames, duration = read_frames(s, [mode[0] for mode in modes])
    name, digest, error, described = None, None, None, [(None, None)] * m
    if b"META" in s:
        name, digest, error, described = read_metadata(s[b"META"], n, m)
    omegas = [mode[4] for mode in modes if mode[4] != -1]
    return dict(
        version=version, bytes=len(data), vertices=n, triangles=f, modes=m, nodes=nodes, depth=depth,
        origin=origin, mass=mass, q_limit=[short(q[0]) for q in modes], q_range=[short(q[1]) for q in modes],
        source=dict(name=name, hash=digest), frames=frames, duration_s=duration, basis_error_rel=error,
        highest_frequency_hz=max(omegas) / (2 * math.pi) if omegas else None, sections=table,
        mode_info=[dict(name=name, frequency_hz=None if mode[4] == -1 else mode[4] / (2 * math.pi),
                        modal_mass_kg=None if mode[5] == -1 else mode[5], default_q=default)
                   for (name, default), mode in zip(described, modes)],
        joints=joints, clips=clips, influences_max=influences,
        levels=[dict(level=i, spheres=len(r), radius_mean=sum(r) / len(r) * unit, radius_max=max(r) * unit)
                for i, r in enumerate(levels)])


if __name__ == "__main__":
    if len(sys.argv) != 2:
        print("usage: bdt_reader.py FILE.bdt", file=sys.stderr)
        sys.exit(2)
    try:
        with open(sys.argv[1], "rb") as file:
            print(json.dumps(info(file.read())))
    except (ValueError, KeyError, OSError) as error:
        sys.exit(f"{sys.argv[1]}: {error}")
