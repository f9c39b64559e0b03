#!/usr/bin/env python3
"""Writes the tables of docs/measured/benchmarks.md that quote docs/measured/record.csv.

A table stands between the lines `<!-- record: NAME -->` and `<!-- end -->`. With --check the page must already be
as it would be written.
"""
import csv
import sys
from collections import defaultdict
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "measured"


def digits(x):
    """Three digits, as people read them."""
    if x >= 1000:
        return f"{x:,.0f}".replace(",", " ")
    return f"{x:.3g}" if x < 100 else f"{x:.0f}"


def table(heads, rows):
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    return lines + ["| " + " | ".join(row) + " |" for row in rows]


def read():
    """benchmark, table -> row -> column -> value, in the record's order."""
    figures = defaultdict(lambda: defaultdict(dict))
    with open(FOLDER / "record.csv", newline="") as file:
        for line in csv.DictReader(file):
            place = figures[line["benchmark"], line["table"]][line["row"]]
            place[line["column"]] = line["value"]
    return figures


def in_turn(benchmark, name):
    """The rows of a table, also those of the same name: a column that comes again begins one."""
    rows = []
    with open(FOLDER / "record.csv", newline="") as file:
        for line in csv.DictReader(file):
            if (line["benchmark"], line["table"]) != (benchmark, name):
                continue
            if not rows or rows[-1][0] != line["row"] or line["column"] in rows[-1][1]:
                rows.append((line["row"], {}))
            rows[-1][1][line["column"]] = float(line["value"])
    return rows


def about(figures):
    known = {row: cells[""] for row, cells in figures["record", "about"].items()}
    libraries = ", ".join(f"{name} {known[name]}" for name in ("obvhs", "parry3d", "tinybvh-rs"))
    return [f"{known['machine']}; commit {known['commit']}; {known['date']}; {libraries}."]


def ball(figures):
    rows = []
    for name, cells in figures["ball", "times"].items():
        values = {column: float(value) for column, value in cells.items()}
        quartiles = f"{values['lower quartile']:.2f}–{values['upper quartile']:.2f}"
        rows.append([
            name,
            digits(values["ns per ball"] / 1000),
            f"{values['ratio of rounds']:.2f} ({quartiles})",
            digits(values["visits"]),
            digits(values["found"]),
        ])
    return table(["contender", "µs per ball", "ratio to the product (quartiles)", "visits", "contacts"], rows)


CONTENDERS = ["ours", "ours rigid", "paper's tree", "parry3d", "obvhs", "tinybvh"]


def workloads(figures):
    works = defaultdict(dict)
    for row, cells in figures["workloads", "contenders"].items():
        work, contender = row.rsplit(", ", 1)
        works[work][contender] = {column: float(value) for column, value in cells.items()}
    peers = {}
    for row, cells in figures["workloads", "ratios"].items():
        work, kind, _ = row.rsplit(", ", 2)
        if kind == "peer":
            peers[work] = cells
    rows = []
    for work, of in works.items():
        times = [digits(of[name]["total"]) if name in of else "–" for name in CONTENDERS]
        peer = peers[work]
        rows.append([
            work.replace(", 1 rays", ", 1 ray"),
            digits(of["ours"]["found"]),
            *times,
            f"**{digits(float(peer['to ours']))}**",
            f"{digits(float(peer['must']))}, {digits(float(peer['aim']))}" if "must" in peer else "–",
        ])
    heads = ["work", "contacts", "bdtree", "bdtree, rigid", *CONTENDERS[2:], "fastest peer to bdtree", "must, aim"]
    return table(heads, rows)


def redundant(figures):
    of = figures["workloads", "contenders"]
    [work] = {row.rsplit(", ", 1)[0] for row in of if row.startswith("W4")}
    rows = []
    for name in ["ours rigid", "ours at rest", "ours", "ours none kept", "ours all kept"]:
        cells = of[f"{work}, {name}"]
        total, floor = float(cells["total"]), float(cells["total, floor"])
        base = of[f"{work}, ours rigid"]
        rows.append([
            name.replace("ours", "bdtree", 1),
            digits(total),
            f"{total / float(base['total']):.2f}",
            f"{floor / float(base['total, floor']):.2f}",
        ])
    return table(["asset", "µs per step", "to rigid", "to rigid, floors"], rows)


def kernel(_):
    columns = ["Avx2", "in the file's order", "plain read"]
    of = [(place, cells) for place, cells in in_turn("kernel", "nodes") if cells["modes"] == 10]
    rows = [[place, *(digits(cells[column]) for column in columns)] for place, cells in of]
    # The best kernel of the commit that was measured goes in the file's order.
    best = "AVX-512" if any("Avx512" in cells for _, cells in of) else "AVX2"
    return table(["from", "AVX2, ns", f"{best} in the file's order, ns", "plain read, ns"], rows)


def kernel_modes(_):
    of = [cells for place, cells in in_turn("kernel", "nodes") if place == "L1"]
    heads = ["modes, from L1", *(digits(cells["modes"]) for cells in of)]
    return table(heads, [["AVX2", *(digits(cells["Avx2"]) for cells in of)]])


def levels(figures):
    of = defaultdict(dict)
    for row, cells in figures["depth", "levels"].items():
        tree, query, level = row.split(", ")
        if tree == "wrapped":
            mean, most = (float(cells[c]) for c in ("error over the diagonal, mean", "most"))
            error = f"{mean:.3f}, {most:.3f}" if mean > 0 else "0"
            of[level][query] = [digits(float(cells["µs"])), error]
    none = ["–", "–"]
    rows = [
        [level, *queries.get("ball", none), *queries.get("pair", none)]
        for level, queries in of.items()
    ]
    return table(["level", "ball: µs", "error", "pair: µs", "error"], rows)


BLOCKS = {
    "about": about,
    "ball": ball,
    "workloads": workloads,
    "redundant": redundant,
    "kernel": kernel,
    "kernel_modes": kernel_modes,
    "levels": levels,
}


def main():
    page = FOLDER / "benchmarks.md"
    text = page.read_text()
    figures = read()
    for name, make in BLOCKS.items():
        begin, end = f"<!-- record: {name} -->\n", "<!-- end -->"
        if text.count(begin) != 1:
            sys.exit(f"{page.name}: {begin.strip()} is there {text.count(begin)} times, not once")
        before, rest = text.split(begin)
        _, after = rest.split(end, 1)
        text = before + begin + "\n" + "\n".join(make(figures)) + "\n\n" + end + after
    if "--check" in sys.argv[1:]:
        if text != page.read_text():
            sys.exit(f"{page.name} does not quote record.csv: run ci/quote_record.py")
        print("benchmarks.md quotes record.csv")
    else:
        page.write_text(text)


if __name__ == "__main__":
    main()
