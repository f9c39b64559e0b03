"""Reads .bdt files with the reader that bdt.ksy gives in Python.

`dump` and `read` give what dump.js prints: names in lower case without underscores, numbers as the sixteen digits of an
f64, bytes as an `x` and hexadecimal digits.
"""
import struct

from bdt import Bdt
from kaitaistruct import KaitaiStruct


def names(record):
    """Names of the fields, and of the computed values."""
    own = [name for name in vars(record) if name not in vars(type(record))]
    computed = [name for name, value in vars(type(record)).items() if isinstance(value, property)]
    return [[name for name in some if not name.startswith(("_", "check"))] for some in (own, computed)]


def dump(value):
    if isinstance(value, list):
        return [dump(element) for element in value]
    if isinstance(value, (bool, str, type(None))):
        return value
    if isinstance(value, bytes):
        return "x" + value.hex()
    if not isinstance(value, KaitaiStruct):
        return struct.pack(">d", float(value)).hex()
    own, computed = names(value)
    fields = {}
    for name in own + computed:
        field = getattr(value, name)
        # A computed value that is a record stands elsewhere in the file already.
        if field is not None and not (name in computed and isinstance(field, KaitaiStruct)):
            fields[name.replace("_", "")] = dump(field)
    return fields


def read(path):
    """{"fields": …}, or {"refused": …} for a file that the reader does not take."""
    try:
        with open(path, "rb") as file:
            return {"fields": dump(Bdt.from_bytes(file.read()))}
    except Exception as error:  # whatever a generated reader raises is a refusal
        return {"refused": f"{type(error).__name__}: {error}"}
