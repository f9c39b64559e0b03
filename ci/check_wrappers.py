#!/usr/bin/env python3
"""bdtree.hpp and the C# files call every function of the C interface that bdtree-capi/symbols.txt lists.

Comments do not count. In C# a function counts when it is declared and called. `ci/capi.sh` checks besides that the test
programs of both call every function. `--self-test` tries the check on sources with each function taken out.
"""
import pathlib
import re
import sys

CAPI = pathlib.Path(__file__).resolve().parent.parent / "bdtree-capi"
STRING_OR_COMMENT = re.compile(r'("(?:\\.|[^"\\])*")|//[^\n]*|/\*.*?\*/', re.DOTALL)


def code(text):
    return STRING_OR_COMMENT.sub(lambda piece: piece[1] or " ", text)


def missing(symbols, cpp, csharp):
    """What the two lack, in words."""
    called = set(re.findall(r"\bbdt_\w+", cpp))
    uses = re.findall(r"\bbdt_\w+", csharp)
    lacks = [f"bdtree.hpp does not call {symbol}" for symbol in symbols if symbol not in called]
    for symbol in symbols:
        if not re.search(rf"\[DllImport\(\w+\)\] internal static extern \w+ {symbol}\(", csharp):
            lacks.append(f"no C# file declares {symbol}")
        elif uses.count(symbol) < 2:
            lacks.append(f"no C# file calls {symbol}")
    return lacks


symbols = (CAPI / "symbols.txt").read_text(encoding="utf-8").split()
cpp = code((CAPI / "include/bdtree.hpp").read_text(encoding="utf-8"))
csharp = code("\n".join(path.read_text(encoding="utf-8") for path in sorted((CAPI / "csharp").glob("*.cs"))))
if sys.argv[1:] == ["--self-test"]:
    for symbol in symbols:
        word = rf"\b{symbol}\b"
        without = [re.sub(word, "other", text) for text in (cpp, csharp)]
        expected = [f"bdtree.hpp does not call {symbol}", f"no C# file declares {symbol}"]
        assert missing(symbols, *without) == expected, symbol
        commented = code(re.sub(word, r"/* \g<0> */", cpp))
        assert missing([symbol], commented, csharp) == expected[:1], symbol
    declared = csharp.replace("Native.bdt_world_momenta", "Native.other")
    assert missing(symbols, cpp, declared) == ["no C# file calls bdt_world_momenta"]
    print(f"{len(symbols)} functions are missed where they are taken out")
    sys.exit()
lacks = missing(symbols, cpp, csharp)
if lacks:
    sys.exit("\n".join(lacks))
print(f"bdtree.hpp and the C# files call {len(symbols)} functions")
