# SPDX-License-Identifier: Apache-2.0
"""Write a configuration in the forms that RTL, C++ and programs read.

The one source is `configs/NAME.yaml` (or a path), changed by KEY=VALUE arguments; keys that it
leaves out have the defaults of `configs/schema.yaml`.  DIR gets `ti_config_pkg.sv`
(`ti_config_pkg::NumTrv`), `ti_config.hpp` (`ti::config::kNumTrv`), `config.json` with its
`config.schema.json`, and what `scripts/counters.py` writes of the counters.  Files whose content
would not change keep their date, so that nothing is rebuilt.  A wrong key or value ends with one
sentence, status 2, and no file touched.

With --build the places are chosen here and printed, a line each: the folder of the configuration,
where all these files are, and the folder of its engine, where those of its RTL are.  The latter is
named by the keys of the RTL alone, so all configurations of one machine share it.

Usage: scripts/configure.py NAME_OR_PATH [KEY=VALUE ...] --out DIR
       scripts/configure.py NAME_OR_PATH [KEY=VALUE ...] --build DIR
"""

import argparse
import difflib
import hashlib
import json
import os
import re
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import config_forms
import config_schema
import counters
import yaml
from config_forms import write_changed
from config_schema import SCHEMA, ConfigError, Schema, Value, is_power

CONFIGS = SCHEMA.parent
READERS = ("trv", "list", "ist1")
LONGEST_FOLDER = 100


@dataclass(frozen=True)
class Configuration:
    """A checked configuration: its values in the order of the schema."""

    schema: Schema
    path: Path
    values: dict[str, Value]
    overrides: dict[str, Value]  # in the schema's order, only those that change the file's value

    @cached_property
    def name(self) -> str:
        """The file's name and the overrides."""
        return " ".join([self.path.stem, *self._words()])

    @cached_property
    def machine(self) -> str:
        """The same for two configurations exactly when their RTL is."""
        keys = self.schema.keys
        return _digest({k: v for k, v in self.values.items() if keys[k].hardware})

    @cached_property
    def folder(self) -> Path:
        """Place below the folder of builds; other values have another."""
        tag = "-".join([self.path.stem, *self._words()]).replace("=", "-")
        if self.path.resolve().parent != CONFIGS or len(tag) > LONGEST_FOLDER or _plain(tag) != tag:
            tag = f"{_plain(self.path.stem)}-{_digest([str(self.path.resolve()), self.values])}"
        return Path("config", tag)

    @cached_property
    def engine(self) -> Path:
        """Place of the engine below the folder of builds."""
        return Path("engine", self.machine)

    def _words(self) -> list[str]:
        return [f"{key}={json.dumps(v).strip(chr(34))}" for key, v in self.overrides.items()]

    def files_of_machine(self) -> dict[str, str]:
        """Name and text of what only the keys of the RTL decide."""
        return {
            "ti_config_pkg.sv": config_forms.package(self.schema, self.machine, self.values),
            "ti_config.svh": config_forms.macros(self.schema, self.machine, self.values),
            "ti_config.hpp": config_forms.header(self.schema, self.machine, self.values),
            "ti_count_pkg.sv": counters.package(self.values),
            "ti_counters.hpp": counters.header(self.values),
        }

    def files(self) -> dict[str, str]:
        """Name and text of all files."""
        return self.files_of_machine() | {
            "config.json": config_forms.config_json(self.schema, self.name, self.values),
            "config.schema.json": config_forms.json_schema(self.schema),
        }


def _digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:8]


def folder_name(words: str) -> str:
    """A folder's name for these words: readable, taken whole by every tool, short enough."""
    name = re.sub(r"[^\w=.-]", "_", "-".join(words.split()))
    return name if len(name) <= 120 else f"{name[:110]}-{_digest(words)}"


def _plain(name: str) -> str:
    """`name` without what makefiles and shells read as their own."""
    return re.sub(r"[^\w.-]", "_", name, flags=re.ASCII)


def find(name_or_path: str) -> Path:
    """The YAML file of a configuration's name, or the path itself."""
    names = {p.stem: p for p in sorted(CONFIGS.glob("*.yaml")) if p != SCHEMA}
    path = names.get(name_or_path, Path(name_or_path))
    if name_or_path == "auto" and not path.is_file():
        raise ConfigError(
            "auto: the machine that a picture calls for, which `make render` alone chooses; "
            f"name one of {', '.join(names)}, or give the path of a .yaml file"
        )
    if not path.is_file():
        raise ConfigError(
            f"{name_or_path}: no such configuration; there are {', '.join(names)}, "
            "or give the path of a .yaml file"
        )
    return path


def load(name_or_path: str, overrides: list[str] = (), schema: Schema | None = None):
    """The `Configuration` of a name or path with its overrides, checked."""
    schema = schema or config_schema.load()
    path = find(name_or_path)
    stored = read(path, schema)
    changes = {}
    for override in overrides:
        name, equals, text = override.partition("=")
        if not name or not equals or not text:
            raise ConfigError(
                f"{override}: not an override; write KEY=VALUE, for example num_trv=2"
            )
        changes[name] = known(path, schema, name).of_text(text)
    values = schema.defaults() | stored | changes
    check(path, schema, values)
    values["streams"] = values["streams"] or values["cores"]
    if "interval_guard" not in stored | changes:
        values["interval_guard"] = outward_ulps(values)
    base = schema.defaults() | stored
    changes = {k: changes[k] for k in schema.keys if k in changes and changes[k] != base.get(k)}
    return Configuration(schema, path, values, changes)


def read(path: Path, schema: Schema) -> dict[str, object]:
    """Keys and values that stand in `path`: known keys, any values."""
    try:
        config = yaml.safe_load(path.read_text())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        place = f" line {mark.line + 1}" if mark else ""
        raise ConfigError(f"{path}:{place} is not YAML; write one 'key: value' a line") from None
    if not isinstance(config, dict):
        raise ConfigError(f"{path}: holds no keys; write one 'key: value' a line")
    return {name: known(path, schema, name).of(value) for name, value in config.items()}


def known(path: Path, schema: Schema, name: str) -> config_schema.Key:
    """The key of that name."""
    if name in schema.keys:
        return schema.keys[name]
    near = difflib.get_close_matches(str(name), schema.keys, n=1)
    hint = f"did you mean {near[0]}?" if near else f"the keys are {', '.join(schema.keys)}"
    raise ConfigError(f"{path}: unknown key {name}; {hint}")


# --- What values must be; all that one key asks of another is here -------------------------------


def check(path: Path, schema: Schema, config: dict[str, object]) -> None:
    """Raise `ConfigError` at the first value that is impossible."""
    for name, key in schema.keys.items():
        if not key.allows(config[name]):
            raise ConfigError(f"{path}: {name} is {config[name]}, but must be {key.allowed()}")
    if config["num_list"] > config["num_trv"]:
        raise ConfigError(
            f"{path}: num_list is {config['num_list']}, "
            f"but must be at most num_trv, {config['num_trv']}"
        )
    if config["streams"] and config["cores"] % config["streams"]:
        raise ConfigError(
            f"{path}: streams is {config['streams']}, but must be 0 or divide cores, "
            f"{config['cores']}"
        )
    check_range(path, config)
    check_reciprocal(path, config)
    check_thickness(path, config)
    check_record(path, config)
    for unit in READERS:
        check_l1(path, config, unit)
        check_l2(path, config, unit)


def reciprocal_half_ulps(config: dict[str, object]) -> int:
    """Bound on the error of a reciprocal in halves of a unit in the last place (`ti_fp_pkg`)."""
    toward_zero = config["rounding"] == "zero"
    if config["reciprocal"] == "division":
        return 2 if toward_zero else 1
    error = 3 << (28 - config["rcp_table_bits"])
    for _ in range(1, config["rcp_newton_steps"]):
        error = (error * error >> 30) + 1 + (1 << (29 - config["frac_bits"]))
    if config["rcp_newton_steps"]:
        error = (error * error >> 30) + 1
    sixteenths = (error << (config["frac_bits"] + 5) >> 30) + 1 + (24 if toward_zero else 12)
    return 2 * -(-sixteenths // 16)


def outward_ulps(config: dict[str, object]) -> int:
    """Units that cover the three roundings of the t of a plane (`ti_fp_pkg`)."""
    return reciprocal_half_ulps(config) + (6 if config["rounding"] == "zero" else 3)


def reciprocal_stages(config: dict[str, object]) -> int:
    """Register stages of a reciprocal (`ti_fp_pkg`)."""
    if config["reciprocal"] == "newton":
        product = 2 if config["fp_mul_stages"] >= 5 else 1
        return config["fp_rcp_end_stages"] + 1 + 2 * product * config["rcp_newton_steps"]
    bits = config["fp_rcp_bits_per_stage"]
    return config["fp_rcp_end_stages"] + (config["frac_bits"] + 1 + bits) // bits


def check_reciprocal(path: Path, config: dict[str, object]) -> None:
    """RD subtracts while it inverts: the reciprocal takes at least as long (`ti_fp_pkg`).

    The guards of the culls hold for an error of N units with 2 N^2 <= 2^M (`ti_ist1_verdict`).
    """
    if config["reciprocal"] == "newton":
        if config["rcp_table_bits"] > config["frac_bits"]:
            raise ConfigError(
                f"{path}: rcp_table_bits is {config['rcp_table_bits']}, "
                f"but must be at most frac_bits, {config['frac_bits']}"
            )
        ulps = reciprocal_half_ulps(config) // 2
        if 2 * ulps**2 > 1 << config["frac_bits"]:
            raise ConfigError(
                f"{path}: rcp_table_bits {config['rcp_table_bits']} and rcp_newton_steps "
                f"{config['rcp_newton_steps']} leave an error of up to {ulps} units in the last "
                f"place, too many for frac_bits {config['frac_bits']}; take more of either"
            )
    stages = reciprocal_stages(config)
    if config["fp_add_stages"] > stages:
        raise ConfigError(
            f"{path}: fp_add_stages is {config['fp_add_stages']}, "
            f"but must be at most the stages of the reciprocal, {stages}"
        )


def check_thickness(path: Path, config: dict[str, object]) -> None:
    """A thick ray covers the errors of test and walk, and is no thicker than A (`ti_rd_thick`)."""
    operations = 34 if config["rounding"] == "zero" else 17
    if config["traversal"] == "padded" and (
        operations + 4 * reciprocal_half_ulps(config) > 2 << config["frac_bits"]
    ):
        raise ConfigError(
            f"{path}: traversal is padded, but with frac_bits {config['frac_bits']} the rounding "
            "errors of a ray are larger than the scene; take plain, or more bits"
        )


def check_range(path: Path, config: dict[str, object]) -> None:
    """The inverse of 2^-M is a number.

    RD takes an axis whose inverse overflows for parallel: a ray may leave it by less than an ulp
    of its way, which the dilation of the tree covers, or hits are lost.
    """
    least = 1 + (config["frac_bits"] - 1).bit_length()
    if config["exp_bits"] < least:
        raise ConfigError(
            f"{path}: exp_bits is {config['exp_bits']}, but frac_bits {config['frac_bits']} asks "
            f"for {least} or more: the inverse of a direction of 2^-{config['frac_bits']} would "
            "overflow"
        )


def check_record(path: Path, config: dict[str, object]) -> None:
    """A line holds a record of Woop's test: nine coordinates and the triangle's number."""
    bits = 9 * (1 + config["exp_bits"] + config["frac_bits"]) + 32
    least = 32 if bits <= 256 else 64
    if config["triangle_test"] == "woop" and config["line_bytes"] < least:
        raise ConfigError(
            f"{path}: line_bytes is {config['line_bytes']}, but a record of the triangle test woop "
            f"asks for at least {least}"
        )


def check_l1(path: Path, config: dict[str, int], unit: str) -> None:
    """The L1 of `unit` divides into a power of two of sets; its rows are no more than its slots."""
    check_sets(path, config, f"{unit}_l1", 1)
    slots = config[f"{unit}_slots"]
    if config[f"{unit}_rows"] > slots:
        raise ConfigError(
            f"{path}: {unit}_rows is {config[f'{unit}_rows']}, "
            f"but must be from 1 to {unit}_slots, {slots}"
        )


def check_l2(path: Path, config: dict[str, int], unit: str) -> None:
    """The banks of the L2 of `unit`, where there is one, divide into powers of two of sets.

    Its latency has room for crossbar, queue and look-up.
    """
    if config[f"{unit}_l2_bytes"]:
        least = config["lookup_stages"] + 3
        if config["l2_latency"] < least:
            raise ConfigError(
                f"{path}: l2_latency is {config['l2_latency']}, but must be at least "
                f"lookup_stages + 3, {least}"
            )
        check_sets(path, config, f"{unit}_l2", config[f"{unit}_l2_banks"])


def check_sets(path: Path, config: dict[str, int], cache: str, banks: int) -> None:
    size = config[f"{cache}_bytes"]
    least = config["line_bytes"] * config[f"{cache}_ways"] * banks
    sets, rest = divmod(size, least)
    if rest or not is_power(sets):
        of_banks = f" * {cache}_banks" if banks > 1 else ""
        raise ConfigError(
            f"{path}: {cache}_bytes is {size}, but must be line_bytes * {cache}_ways{of_banks}, "
            f"{least}, times a power of two"
        )


# --- Files ---------------------------------------------------------------------------------------


def write(folder: Path, files: dict[str, str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in files.items():
        write_changed(folder / file, text)


def link(path: Path, target: Path) -> None:
    """Make `path` a link to `target`, in one step."""
    if not path.is_symlink() or path.readlink() != target:
        partial = path.with_name(f"{path.name}.{os.getpid()}")
        partial.symlink_to(target)
        partial.replace(path)


def configure(
    name_or_path: str, overrides: list[str], out: Path, schema: Schema | None = None
) -> dict[str, Value]:
    """Write all files of a configuration into `out`; its values."""
    configuration = load(name_or_path, overrides, schema)
    write(out, configuration.files())
    return configuration.values


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name_or_path", help="name of a file in configs/, or a path")
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE")
    places = parser.add_mutually_exclusive_group(required=True)
    places.add_argument("--out", type=Path, metavar="DIR")
    places.add_argument("--build", type=Path, metavar="DIR", help="where the Makefile builds")
    parser.add_argument("--schema", type=Path, default=SCHEMA, metavar="FILE")
    arguments = parser.parse_args()
    try:
        schema = config_schema.load(arguments.schema)
        configuration = load(arguments.name_or_path, arguments.overrides, schema)
        if arguments.out:
            write(arguments.out, configuration.files())
        else:
            folder, engine = (
                arguments.build / p for p in (configuration.folder, configuration.engine)
            )
            write(folder, configuration.files())
            write(engine / "config", configuration.files_of_machine())
            link(folder / "engine", Path("..", "..", configuration.engine))
            print(f"{folder}\n{engine}")
    except ConfigError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
