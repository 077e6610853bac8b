# SPDX-License-Identifier: Apache-2.0
"""Packed structs of the packages of `rtl/` as Python dicts; the packages are the table.

A dict holds an integer for a field of bits, a tuple ([0] first) for a packed array, a dict for a
struct.  Fields that `pack` is not given are 0.
"""

import json
import re
from functools import cache
from pathlib import Path

import cocotb
import config_schema
import counters

RTL = Path(__file__).resolve().parents[2] / "rtl"
TYPEDEF = re.compile(
    r"typedef\s+(?:struct\s+packed\s*\{(?P<fields>.*?)\}|enum\s+logic\s*(?P<enum>\[.*?\])\s*\{.*?\}"
    r"|(?P<base>[\w:]+)\s*(?P<range>\[.*?\])?)\s*(?P<name>\w+)\s*;",
    re.DOTALL,
)
CONSTANT = re.compile(
    r"localparam\s+(?:int unsigned|\w+)\s+(\w+)(?:\[\w+\])?\s*=\s*(.*?);", re.DOTALL
)
FIELD = re.compile(r"^\s*([\w:]+)\s*(\[.*?\])?\s*(\w+)\s*$")


def clog2(value):
    return max(value - 1, 0).bit_length()


class Bits:
    """An integer of `width` bits."""

    def __init__(self, width):
        self.width = width

    def pack(self, value, name):
        assert 0 <= value < 1 << self.width, f"{name}: {value:#x} does not fit in {self.width} bits"
        return value

    def unpack(self, bits):
        return bits


class Array:
    """`count` elements, [0] lowest."""

    def __init__(self, count, element):
        self.width = count * element.width
        self._element = element
        self._lows = range(0, self.width, element.width)
        self._mask = (1 << element.width) - 1

    def pack(self, values, name):
        values = values or (0,) * len(self._lows)
        assert len(values) == len(self._lows), (
            f"{name} has {len(self._lows)} elements, not {len(values)}"
        )
        pairs = zip(values, self._lows, strict=True)
        return sum(self._element.pack(value, name) << low for value, low in pairs)

    def unpack(self, bits):
        return tuple(self._element.unpack(bits >> low & self._mask) for low in self._lows)


class Struct:
    """Fields by name, the highest first."""

    def __init__(self, fields):
        self.width = sum(kind.width for kind in fields.values())
        self._places, top = {}, self.width  # name -> lowest bit, mask, type
        for name, kind in fields.items():
            top -= kind.width
            self._places[name] = top, (1 << kind.width) - 1, kind

    def names(self):
        names = []
        for name, (_, _, kind) in reversed(self._places.items()):
            names += kind.names() if isinstance(kind, Struct) else [name]
        return names

    def pack(self, values, name):
        values = values or {}
        unknown = values.keys() - self._places.keys()
        assert not unknown, f"{name} has no field {', '.join(sorted(unknown))}"
        bits = 0
        for field, value in values.items():
            low, _, kind = self._places[field]
            bits |= kind.pack(value, field) << low
        return bits

    def unpack(self, bits):
        return {
            field: kind.unpack(bits >> low & mask)
            for field, (low, mask, kind) in self._places.items()
        }


class Payloads:
    """The structs of all packages for one configuration, a dict of the keys in `configs/`."""

    def __init__(self, config):
        sources = (RTL.parent / line for line in (RTL / "ti.f").read_text().splitlines())
        text = "".join(path.read_text() for path in sources if path.stem.endswith("_pkg"))
        text = re.sub(r"//[^\n]*", "", text + counters.package(config))
        self._constants = {_camel(key): value for key, value in config.items()}
        for name, key in config_schema.load().keys.items():
            for value in key.values or ():
                self._constants[_camel(name) + _camel(value)] = value
        for name, expression in CONSTANT.findall(text):
            if re.fullmatch(r"[\w\s:$()<>=?*+&\[\]-]+", expression):
                self._constants[name] = self._evaluate(expression)
            elif array := re.fullmatch(r"'\{([^{}]+)\}", expression):
                parts = array[1].split(",")
                self._constants[name] = [self._evaluate(part) for part in parts]
        self._types = {"logic": Bits(1)}
        for match in TYPEDEF.finditer(text):
            self._types[match["name"]] = self._type_of(match)

    @property
    def format(self):
        """As `Oracle` takes it: bits of exponent and fraction, modes, table bits, Newton steps."""
        names = ("ExpBits", "FracBits", "TowardZero", "Flush", "RcpTableBits", "RcpNewtonSteps")
        return tuple(self._constants[name] for name in names)

    def width(self, name):
        return self._types[name].width

    def names(self, name):
        """Names of the fields of a struct, from the lowest up; its structs are entered."""
        return self._types[name].names()

    def pack(self, name, values=None, **fields):
        """The bits of a struct, from a dict or keywords."""
        return self._types[name].pack({**(values or {}), **fields}, name)

    def pack_vec(self, vec):
        return self._types["vec3_t"].pack(vec, "vec3_t")

    def unpack_vec(self, bits):
        return self._types["vec3_t"].unpack(bits)

    def unpack(self, name, bits):
        return self._types[name].unpack(bits)

    def _type_of(self, match):
        if match["fields"] is None:
            base = self._types[_plain(match["base"])] if match["base"] else Bits(1)
            return self._array(base, match["enum"] or match["range"])
        fields = {}
        for line in match["fields"].split(";"):
            if line.strip():
                base, extent, name = FIELD.match(line).groups()
                fields[name] = self._array(self._types[_plain(base)], extent)
        return Struct(fields)

    def _array(self, base, extent):
        if not extent:
            return base
        high, low = (self._evaluate(part) for part in extent.strip("[] ").split(":"))
        count = high - low + 1
        return Bits(count) if base.width == 1 else Array(count, base)

    def _evaluate(self, expression):
        text = re.sub(r"\w+::", "", expression).replace("$clog2", "clog2").replace("&&", "and")
        text = _ternary(" ".join(text.split()))
        return eval(text, {"clog2": clog2}, self._constants)  # text of the package only


@cache
def payloads():
    """The structs of the configuration that this simulation was built for."""
    return Payloads(configuration())


@cache
def configuration():
    """The configuration that `bench.run` built: the simulation runs in a folder below the build."""
    config = json.loads((Path.cwd().parent / "config/config.json").read_text())
    config.pop("name")
    return config


def parameter(name, otherwise=0):
    """A parameter of the unit in this simulation; `otherwise` where pytest only collects."""
    top = getattr(cocotb, "top", None)
    return otherwise if top is None else int(getattr(top, name).value)


def _ternary(text):
    """`a ? b : c` of SystemVerilog, nested at will, as Python has it."""
    depth, question, colon, open_questions = 0, None, None, 0
    for at, char in enumerate(text):
        depth += (char == "(") - (char == ")")
        if depth == 0 and char == "?":
            question = at if question is None else question
            open_questions += 1
        elif depth == 0 and char == ":":
            open_questions -= 1
            if open_questions == 0:
                colon = at
                break
    if question is not None:
        condition, yes, no = text[:question], text[question + 1 : colon], text[colon + 1 :]
        return f"({_ternary(yes)}) if ({_ternary(condition)}) else ({_ternary(no)})"
    return re.sub(r"\((.*)\)", lambda inner: f"({_ternary(inner[1])})", text, count=1)


def _plain(name):
    """A type's name without its package; names are unique among the packages."""
    return name.rsplit("::", 1)[-1]


def _camel(key):
    return "".join(word.capitalize() for word in key.split("_"))
