#!/usr/bin/env python3
"""bdtree.hpp and the C# files call every function of the C interface that bdtree-capi/symbols.txt lists, and the C# files
declare structs and functions as bdtree.h does: nothing else would notice a field or an argument in the wrong place.

Comments do not count. In C# a function counts when it is declared and called. `ci/capi.sh` checks besides that the test
programs of both call every function. `--self-test` tries the check on sources with something taken out or changed.
"""
import pathlib
import re
import sys

CAPI = pathlib.Path(__file__).resolve().parent.parent / "bdtree-capi"
STRING_OR_COMMENT = re.compile(r'("(?:\\.|[^"\\])*")|//[^\n]*|/\*.*?\*/', re.DOTALL)
TYPES = {
    "size_t": "UIntPtr", "uint8_t": "byte", "char": "byte", "int32_t": "int", "uint32_t": "uint", "uint64_t": "ulong",
    "void": "IntPtr",
}
# Fields that C# writes otherwise: without arrays, and with another name than their struct has.
FIELDS = {
    "double Inertia[6]": [f"double {name}" for name in ("Xx", "Yy", "Zz", "Xy", "Xz", "Yz")],
    "double Rows[3][4]": [f"double M{row}{column}" for row in range(3) for column in range(4)],
    "ManifoldPoint Points[4]": [f"ManifoldPoint Point{point}" for point in range(4)],
    "uint Lane": ["uint Index"],
}


def code(text):
    return STRING_OR_COMMENT.sub(lambda piece: piece[1] or " ", text)


def word(c_type):
    """The C# name of a type of bdtree.h, without its stars."""
    name = re.sub(r"\bconst\b|\bstruct\b|[*\s]", "", c_type)
    return TYPES.get(name, name[3:] if name.startswith("Bdt") else name)


def pascal(name):
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def structs_of_c(header):
    """Name to fields, as C# writes them."""
    structs = {}
    for name, body in re.findall(r"typedef struct Bdt(\w+) \{(.*?)\n\} Bdt", header, re.DOTALL):
        fields = [f"{word(kind)} {pascal(field)}" for kind, field in re.findall(r"([\w ]+?) (\w+[\[\d\]]*);", body)]
        structs[name] = [written for field in fields for written in FIELDS.get(field, [field])]
    return structs


def structs_of_csharp(text, enums):
    structs = {}
    for name, body in re.findall(r"public struct (\w+)\s*\{(.*?)\n    \}", text, re.DOTALL):
        fields = re.findall(r"public (\w+) ([\w, \n]+);", body)
        structs[name] = [
            f"{'uint' if kind in enums else kind} {field.strip()}" for kind, names in fields for field in names.split(",")
        ]
    return structs


def functions_of_c(header, handles):
    """Name to the types of the arguments: handles by name, other pointers with a star, arrays of handles as IntPtr."""
    functions = {}
    for name, arguments in re.findall(r"^\w[\w *]*?(bdt_\w+)\(([^;{]*)\);", header, re.MULTILINE):
        types = []
        for argument in [] if arguments.strip() == "void" else arguments.split(","):
            c_type = re.sub(r"\w+\s*$", "", argument.strip())
            kind, stars = word(c_type), c_type.count("*")
            if kind in handles:
                types.append("IntPtr*" if stars == 2 else "IntPtr" if name.endswith("_free") else kind)
            else:
                types.append(kind + ("*" if stars and kind != "IntPtr" else ""))
        functions[name] = types
    return functions


def functions_of_csharp(text, enums):
    functions = {}
    for name, arguments in re.findall(r"static extern \w+ (bdt_\w+)\(([^;]*)\);", text):
        types = []
        for argument in re.sub(r"\[[A-Z]\w*(, \w+)*\]", "", arguments).split(",") if arguments else []:
            *by, kind, _ = argument.split()
            plain = kind.replace("[]", "")
            types.append(("uint" if plain in enums else plain) + ("*" if by or kind != plain else ""))
        functions[name] = types
    return functions


def lacks(symbols, header, cpp, csharp):
    """What is missing or otherwise, in words."""
    handles = set(re.findall(r"typedef struct Bdt(\w+) Bdt\w+;", header))
    enums = set(re.findall(r"enum (\w+) : uint\b", csharp))
    declared, expected = functions_of_csharp(csharp, enums), functions_of_c(header, handles)
    structs = structs_of_csharp(csharp, enums)
    called = set(re.findall(r"\bbdt_\w+", cpp))
    uses = re.findall(r"\bbdt_\w+", csharp)
    found = [f"bdtree.hpp does not call {symbol}" for symbol in symbols if symbol not in called]
    for symbol in symbols:
        if symbol not in declared:
            found.append(f"no C# file declares {symbol}")
        elif uses.count(symbol) < 2:
            found.append(f"no C# file calls {symbol}")
        elif declared[symbol] != expected[symbol]:
            found.append(f"{symbol} takes {expected[symbol]}, in C# {declared[symbol]}")
    for name, fields in structs_of_c(header).items():
        if structs.get(name) != fields:
            found.append(f"{name} has {fields}, in C# {structs.get(name)}")
    return found


def self_test(symbols, header, cpp, csharp):
    for symbol in symbols:
        whole = rf"\b{symbol}\b"
        without = [re.sub(whole, "other", text) for text in (cpp, csharp)]
        expected = [f"bdtree.hpp does not call {symbol}", f"no C# file declares {symbol}"]
        assert lacks(symbols, header, *without) == expected, symbol
    commented = code(cpp.replace("bdt_version()", "/* bdt_version() */ 0"))
    assert lacks(symbols, header, commented, csharp) == ["bdtree.hpp does not call bdt_version"]
    for old, new, about in [
        ("Native.bdt_world_momenta", "Native.other", "no C# file calls bdt_world_momenta"),
        ("uint CollisionGroup, CollisionMask", "uint CollisionMask, CollisionGroup", "Tags has"),
        ("public double AtLeast", "public float AtLeast", "Bound has"),
        ("uint first, UIntPtr count", "UIntPtr first, UIntPtr count", "bdt_model_triangles takes"),
        ("ref Tags tags", "Tags tags", "bdt_instance_set_tags takes"),
    ]:
        changed = csharp.replace(old, new, 1)
        found = lacks(symbols, header, cpp, changed)
        assert changed != csharp and len(found) == 1 and found[0].startswith(about), (old, found)
    print(f"{len(symbols)} functions are missed where they are taken out, and changed declarations are found")


def main():
    symbols = (CAPI / "symbols.txt").read_text(encoding="utf-8").split()
    header, cpp = (code((CAPI / "include" / name).read_text(encoding="utf-8")) for name in ("bdtree.h", "bdtree.hpp"))
    csharp = code("\n".join(path.read_text(encoding="utf-8") for path in sorted((CAPI / "csharp").glob("*.cs"))))
    if sys.argv[1:] == ["--self-test"]:
        self_test(symbols, header, cpp, csharp)
        return
    found = lacks(symbols, header, cpp, csharp)
    if found:
        sys.exit("\n".join(found))
    print(f"bdtree.hpp and the C# files call {len(symbols)} functions, declared as in bdtree.h")


main()
