#!/usr/bin/env python3
"""The bill of materials of a package as CycloneDX 1.5 in JSON: sbom.py PACKAGE TARGET [FEATURE ...] >FILE

What is linked or runs in the build on that target, from `cargo metadata`, with the checksums of Cargo.lock. No serial number
and no time, so that the same sources give the same bytes."""
import json
import pathlib
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]


def main():
    name, target, *features = sys.argv[1:]
    read = metadata("--all-features", "--filter-platform", target)
    packages = {package["id"]: package for package in read["packages"]}
    nodes = {node["id"]: node for node in read["resolve"]["nodes"]}
    # What cargo metadata resolves is the whole workspace, all features on; what this program has of it cargo tree says.
    tree = ["tree", "--locked", "-p", name, "-e", "normal,build", "--target", target, "--prefix", "none", "--format", "{p}"]
    lines = cargo(*tree, *(["--features", ",".join(features)] if features else []))
    has = {tuple(line.split()[:2]) for line in lines.splitlines() if line}
    [root] = [id for id in read["workspace_members"] if packages[id]["name"] == name]
    own = {id for id, package in packages.items() if (package["name"], "v" + package["version"]) in has}
    needed = {id: sorted(d["pkg"] for d in nodes[id]["deps"] if d["pkg"] in own
                         and any(kind["kind"] != "dev" for kind in d["dep_kinds"])) for id in own}
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text(encoding="utf-8"))
    checksums = {(entry["name"], entry["version"]): entry.get("checksum") for entry in lock["package"]}

    def component(id):
        package = packages[id]
        kind = "application" if id == root else "library"
        purl = f"pkg:cargo/{package['name']}@{package['version']}"
        entry = {"type": kind, "bom-ref": purl, "name": package["name"], "version": package["version"], "purl": purl}
        if package["description"]:
            entry["description"] = " ".join(package["description"].split())
        if package["license"]:
            entry["licenses"] = [{"expression": package["license"].replace("/", " OR ")}]
        checksum = checksums[package["name"], package["version"]]
        if checksum:
            entry["hashes"] = [{"alg": "SHA-256", "content": checksum}]
        return entry

    components = {id: component(id) for id in needed}
    ordered = sorted(needed, key=lambda id: components[id]["purl"])
    bill = {
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": components[root], "properties": [{"name": "target", "value": target}]},
        "components": [components[id] for id in ordered if id != root],
        "dependencies": [{"ref": components[id]["purl"], "dependsOn": sorted(components[d]["purl"] for d in needed[id])}
                         for id in ordered],
    }
    print(json.dumps(bill, indent=1, ensure_ascii=False))


def cargo(*arguments):
    return subprocess.run(["cargo", *arguments], capture_output=True, text=True, check=True, cwd=ROOT).stdout


def metadata(*arguments):
    return json.loads(cargo("metadata", "--locked", "--format-version", "1", *arguments))


if __name__ == "__main__":
    main()
