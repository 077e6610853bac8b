# SPDX-License-Identifier: Apache-2.0
"""What a configuration and its schema become: SystemVerilog, C++, JSON, JSON Schema, a table.

The options choose what is written of the schema alone: --cpp the C++ struct of all keys, --write
the table of a document (--check only compares it).

Usage: scripts/config_forms.py [--schema FILE] (--cpp | --write | --check) FILE
"""

import argparse
import json
import os
import sys
from pathlib import Path

from config_schema import SCHEMA, ConfigError, Key, Schema, Value, camel, load

HEAD = "// SPDX-License-Identifier: Apache-2.0\n"
BEGIN = "<!-- keys: written by scripts/config_forms.py --write -->\n"
END = "<!-- end of keys -->\n"
CPP_TYPES = {"int": "int", "bool": "bool", "float": "double"}


def write_changed(path: Path, text: str) -> None:
    """Make `path` hold `text`; whoever reads it meanwhile sees the old or the new one whole."""
    if not path.is_file() or path.read_text() != text:
        partial = path.with_suffix(f".{os.getpid()}")
        partial.write_text(text)
        partial.replace(path)


# --- One configuration: its machine, and all its keys --------------------------------------------


def package(schema: Schema, machine: str, config: dict[str, Value]) -> str:
    """`ti_config_pkg`: the keys that change the RTL."""
    lines = "".join(_sv(key, config[key.name]) for key in schema.keys.values() if key.hardware)
    return (
        f"{HEAD}\n/// Machine {machine}, written by scripts/configure.py.\n"
        f"package ti_config_pkg;\n\n{lines}\n  /// The digest of these, for programs.\n"
        f"  localparam logic [31:0] Hash = 32'h{machine};\n\nendpackage : ti_config_pkg\n"
    )


def macros(schema: Schema, machine: str, config: dict[str, Value]) -> str:
    """`ti_config.svh`: a macro TI_KEY for each true key, for what a package cannot choose."""
    true = [f"TI_{k.name.upper()}" for k in schema.keys.values() if config[k.name] is True]
    lines = "".join(f"`define {name}\n" for name in true)
    return (
        f"{HEAD}\n// Machine {machine}, written by scripts/configure.py.\n\n"
        f"`ifndef TI_CONFIG_SVH_\n`define TI_CONFIG_SVH_\n\n{lines}\n`endif  // TI_CONFIG_SVH_\n"
    )


def _sv(key: Key, value: Value) -> str:
    name = camel(key.name)
    if key.kind == "enum":
        values = ", ".join(f"{name}{camel(v)}" for v in key.values)
        return (
            f"  typedef enum int unsigned {{{values}}} {key.name}_e;\n"
            f"  localparam {key.name}_e {name} = {name}{camel(value)};\n"
        )
    kind, text = {
        "int": ("int unsigned" if key.low >= 0 else "int", f"{value}"),
        "bool": ("bit", f"1'b{value:d}" if key.kind == "bool" else ""),
        "float": ("real", f"{value!r}"),
    }[key.kind]
    return f"  localparam {kind} {name} = {text};\n"


def header(schema: Schema, machine: str, config: dict[str, Value]) -> str:
    """`ti_config.hpp`: the same for C++."""
    keys = [key for key in schema.keys.values() if key.hardware]
    lines = "".join(
        f"inline constexpr {_cpp_type(k)} k{camel(k.name)} = {_cpp(k, config[k.name])};\n"
        for k in keys
    )
    values = json.dumps({key.name: config[key.name] for key in keys})
    include = '#include "base/config_keys.hpp"\n\n' if any(k.values for k in keys) else ""
    return (
        f"{HEAD}// Machine {machine}, written by scripts/configure.py.\n"
        f"#pragma once\n\n{include}namespace ti::config {{\n\n"
        "/// All of them, as JSON.\n"
        f'inline constexpr char kJson[] = R"({values})";\n'
        f"{lines}\n}}  // namespace ti::config\n"
    )


def config_json(schema: Schema, name: str, config: dict[str, Value]) -> str:
    """`config.json`: all keys."""
    values = {key: config[key] for key in schema.keys}
    return json.dumps({"name": name, **values}, indent=2) + "\n"


# --- All configurations --------------------------------------------------------------------------


def json_schema(schema: Schema) -> str:
    """JSON Schema of `config.json`."""
    properties = {"name": {"type": "string"}}
    properties |= {key.name: _json_rule(key) for key in schema.keys.values()}
    return (
        json.dumps(
            {
                "$schema": "https://json-schema.org/draft/2020-12/schema",
                "title": "A configuration, as scripts/configure.py writes it",
                "type": "object",
                "properties": properties,
                "required": list(properties),
                "additionalProperties": False,
            },
            indent=2,
        )
        + "\n"
    )


def _json_rule(key: Key) -> dict:
    about = {"description": key.text, "default": key.default}
    if key.kind == "bool":
        return {"type": "boolean", **about}
    if key.kind == "enum":
        return {"type": "string", "enum": list(key.values), **about}
    kind = {"int": "integer", "float": "number"}[key.kind]
    if key.power:
        powers = [1 << i for i in range(32) if key.low <= 1 << i <= key.high]
        return {"type": kind, "enum": powers, **about}
    return {"type": kind, "minimum": key.low, "maximum": key.high, **about}


def keys_header(schema: Schema) -> str:
    """`base/config_keys.hpp`: `ti::Config` with all keys, and what its loader checks."""
    keys = schema.keys.values()
    enums = "".join(
        f"enum class {camel(k.name)} {{ {', '.join(f'k{camel(v)}' for v in k.values)} }};\n"
        f"inline constexpr const char* k{camel(k.name)}Names[] = "
        f"{{{', '.join(json.dumps(v) for v in k.values)}}};\n\n"
        for k in keys
        if k.values
    )
    members = "".join(
        f"  /// {k.text}\n  {_cpp_type(k)} {k.name} = {_cpp(k, k.default)};\n" for k in keys
    )
    rules = "".join(f"  take({_cpp_rule(k)});\n" for k in keys)
    formats = ", ".join(f"{{{e}, {m}}}" for e, m in schema.formats)
    return (
        f"{HEAD}// Written by scripts/config_forms.py from configs/schema.yaml.\n"
        "#pragma once\n\n#include <string>\n\n"
        '#include "base/config_rules.hpp"\n#include "base/format.hpp"\n\nnamespace ti {\n\n'
        "/// The number formats that the model is compiled for, in their default modes.\n"
        f"inline constexpr Format kModelFormats[] = {{{formats}}};\n\n{enums}"
        "/// The keys of a configuration; `load_config` reads them.\n"
        "struct Config {\n"
        "  std::string name;\n"
        "  std::string json;  ///< all keys, as the file has them\n"
        "  Format format;  ///< of exp_bits and frac_bits\n"
        f"{members}}};\n\n"
        "/// Calls `take` with what `load_config` asks of each key, in their order.\n"
        "template <typename Take>\n"
        f"void each_config_rule(Take&& take) {{\n{rules}}}\n\n"
        "}  // namespace ti\n"
    )


def _cpp_type(key: Key) -> str:
    return camel(key.name) if key.kind == "enum" else CPP_TYPES[key.kind]


def _cpp(key: Key, value: Value) -> str:
    if key.kind == "enum":
        return f"{camel(key.name)}::k{camel(value)}"
    return json.dumps(value)


def _cpp_rule(key: Key) -> str:
    words = [f'"{key.name}"', f"&Config::{key.name}"]
    if key.kind == "enum":
        words.append(f"k{camel(key.name)}Names")
    if key.kind in ("int", "float"):
        words += [json.dumps(key.low), json.dumps(key.high)]
    if key.kind == "int":
        words.append(json.dumps(key.power))
    words.append(json.dumps(key.allowed()))
    return f"{key.kind.capitalize()}Rule{{{', '.join(words)}}}"


def markdown(schema: Schema) -> str:
    """The table of docs/configuration.md."""
    lines = ["| key | values | default | what it is |", "|---|---|---:|---|"]
    for group, title in schema.groups.items():
        lines.append(f"| **{title}** | | | |")
        for key in schema.keys.values():
            if key.group == group:
                default = json.dumps(key.default).strip('"')
                about = key.text if key.hardware else f"{key.text} Not of the RTL."
                lines.append(f"| `{key.name}` | {key.allowed()} | {default} | {about} |")
    formats = ", ".join(f"({e},{m})" for e, m in schema.formats)
    lines += [
        "",
        "The model takes every number format; it is compiled for those of `exp_bits`, `frac_bits` "
        f"{formats}, rounding to nearest and keeping subnormals, and slower in others.",
    ]
    return "\n".join(lines) + "\n"


def document(text: str, schema: Schema) -> str:
    """A document with the table of the keys between its markers."""
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ConfigError(f"no lines {BEGIN.strip()} and {END.strip()}")
    return before + BEGIN + markdown(schema) + END + after


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--schema", type=Path, default=SCHEMA, metavar="FILE")
    group = parser.add_mutually_exclusive_group(required=True)
    for option in ("--cpp", "--check", "--write"):
        group.add_argument(option, type=Path, metavar="FILE")
    arguments = parser.parse_args()
    try:
        schema = load(arguments.schema)
        if arguments.cpp:
            arguments.cpp.parent.mkdir(parents=True, exist_ok=True)
            write_changed(arguments.cpp, keys_header(schema))
            return 0
        path = arguments.check or arguments.write
        text = path.read_text()
        wanted = document(text, schema)
    except ConfigError as error:
        print(error, file=sys.stderr)
        return 2
    if arguments.write:
        write_changed(path, wanted)
    elif text != wanted:
        print(f"{path}: its table is not that of the schema; run scripts/config_forms.py --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
