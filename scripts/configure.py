# SPDX-License-Identifier: Apache-2.0
"""Write a configuration in the forms that RTL, C++ and programs read.

The one source is `configs/NAME.yaml` (or a path), changed by KEY=VALUE arguments.  DIR gets
`ti_config_pkg.sv` (`ti_config_pkg::NumTrv`), `ti_config.hpp` (`ti::config::kNumTrv`),
`config.json` (the keys as they are), and what `scripts/counters.py` writes of the counters.
Files whose content would not change keep their date, so that nothing is rebuilt.  A wrong key or
value ends with one sentence, status 2, and no file touched.

Usage: scripts/configure.py NAME_OR_PATH [KEY=VALUE ...] --out DIR
"""

import argparse
import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import counters
import yaml

CONFIGS = Path(__file__).resolve().parents[1] / "configs"
L1S = ("trv", "list", "ist1")


@dataclass(frozen=True)
class Key:
    """Range of one key; `power` asks for a power of two."""

    low: int
    high: int
    power: bool = False

    def allows(self, value: int) -> bool:
        return self.low <= value <= self.high and (not self.power or is_power(value))

    def __str__(self) -> str:
        return f"{'a power of two' if self.power else 'a number'} from {self.low} to {self.high}"


KEYS = {
    "exp_bits": Key(3, 8),
    "frac_bits": Key(2, 23),
    "cores": Key(1, 64),
    "core_tile": Key(1, 4096),
    "fp_add_stages": Key(4, 7),
    "fp_mul_stages": Key(3, 5),
    "fp_rcp_bits_per_stage": Key(1, 3),
    "fp_rcp_end_stages": Key(2, 4),
    "num_trv": Key(1, 256),
    "num_list": Key(1, 256),
    "num_ist1": Key(1, 256),
    "trv_slots": Key(2, 256, power=True),
    "list_slots": Key(2, 256, power=True),
    "ist1_slots": Key(2, 256, power=True),
    "stack_depth": Key(1, 64),
    "line_bytes": Key(32, 128, power=True),
    "trv_l1_bytes": Key(64, 1 << 24),
    "trv_l1_ways": Key(1, 16, power=True),
    "trv_rows": Key(1, 256),
    "list_l1_bytes": Key(64, 1 << 24),
    "list_l1_ways": Key(1, 16, power=True),
    "list_rows": Key(1, 256),
    "ist1_l1_bytes": Key(64, 1 << 24),
    "ist1_l1_ways": Key(1, 16, power=True),
    "ist1_rows": Key(1, 256),
    "deal_tile": Key(1, 65536),
    "watchdog_steps": Key(1, 65535),
    "addr_bits": Key(20, 64),
    "max_reads": Key(2, 1024, power=True),
    "counters": Key(0, 1),
    "ring_delays": Key(0, 1),
    "clock_mhz": Key(1, 10000),
}

OF_REPORTS = ("clock_mhz",)  # keys that change no machine


class ConfigError(Exception):
    """One sentence that names the file, the key and what is allowed."""


def is_power(value: int) -> bool:
    return value > 0 and value & (value - 1) == 0


def find(name_or_path: str) -> Path:
    """The YAML file of a configuration's name, or the path itself."""
    named = CONFIGS / f"{name_or_path}.yaml"
    path = named if named.is_file() else Path(name_or_path)
    if not path.is_file():
        names = ", ".join(sorted(p.stem for p in CONFIGS.glob("*.yaml")))
        raise ConfigError(
            f"{name_or_path}: no such configuration; there are {names}, "
            "or give the path of a .yaml file"
        )
    return path


def read(path: Path, overrides: list[str]) -> dict[str, int]:
    """Keys and values of `path` after the overrides, not yet checked."""
    try:
        config = yaml.safe_load(path.read_text())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        place = f" line {mark.line + 1}" if mark else ""
        raise ConfigError(f"{path}:{place} is not YAML; write one 'key: number' a line") from None
    if not isinstance(config, dict):
        raise ConfigError(f"{path}: holds no keys; write one 'key: number' a line")
    for override in overrides:
        key, equals, text = override.partition("=")
        try:
            value = int(text, 0)
        except ValueError:
            equals = ""
        if not equals:
            raise ConfigError(
                f"{override}: not an override; write KEY=NUMBER, for example num_trv=2"
            )
        config[key] = value
    return config


def check(path: Path, config: dict[str, int]) -> None:
    """Raise `ConfigError` at the first key that is unknown, missing or impossible."""
    for key in config:
        if key not in KEYS:
            raise ConfigError(f"{path}: unknown key {key}; the keys are {', '.join(KEYS)}")
    for key, rule in KEYS.items():
        if key not in config:
            raise ConfigError(f"{path}: key {key} is missing; give it {rule}")
        value = config[key]
        if type(value) is not int or not rule.allows(value):
            raise ConfigError(f"{path}: {key} is {value}, but must be {rule}")
    if config["num_list"] > config["num_trv"]:
        raise ConfigError(
            f"{path}: num_list is {config['num_list']}, "
            f"but must be at most num_trv, {config['num_trv']}"
        )
    check_reciprocal(path, config)
    for unit in L1S:
        check_cache(path, config, unit)


def check_reciprocal(path: Path, config: dict[str, int]) -> None:
    """RD subtracts while it inverts: the reciprocal takes at least as long (`ti_fp_pkg`)."""
    bits = config["fp_rcp_bits_per_stage"]
    stages = config["fp_rcp_end_stages"] + (config["frac_bits"] + 1 + bits) // bits
    if config["fp_add_stages"] > stages:
        raise ConfigError(
            f"{path}: fp_add_stages is {config['fp_add_stages']}, "
            f"but must be at most the stages of the reciprocal, {stages}"
        )


def check_cache(path: Path, config: dict[str, int], unit: str) -> None:
    """The L1 of `unit` divides into a power of two of sets; its rows are no more than its slots."""
    size_key, slots = f"{unit}_l1_bytes", config[f"{unit}_slots"]
    way_bytes = config["line_bytes"] * config[f"{unit}_l1_ways"]
    sets, rest = divmod(config[size_key], way_bytes)
    if rest or not is_power(sets):
        raise ConfigError(
            f"{path}: {size_key} is {config[size_key]}, but must be line_bytes * {unit}_l1_ways, "
            f"{way_bytes}, times a power of two"
        )
    if config[f"{unit}_rows"] > slots:
        raise ConfigError(
            f"{path}: {unit}_rows is {config[f'{unit}_rows']}, "
            f"but must be from 1 to {unit}_slots, {slots}"
        )


def camel(key: str) -> str:
    return "".join(word.capitalize() for word in key.split("_"))


def package(name: str, config: dict[str, int]) -> str:
    # A localparam of 32 bits holds every range above.
    lines = "".join(f"  localparam int unsigned {camel(k)} = {config[k]};\n" for k in KEYS)
    return (
        "// SPDX-License-Identifier: Apache-2.0\n\n"
        f"/// Configuration `{name}`, written by scripts/configure.py.\n"
        f"package ti_config_pkg;\n\n{lines}\nendpackage : ti_config_pkg\n"
    )


def header(name: str, config: dict[str, int]) -> str:
    lines = "".join(f"inline constexpr int k{camel(k)} = {config[k]};\n" for k in KEYS)
    keys = json.dumps({key: config[key] for key in KEYS if key not in OF_REPORTS})
    return (
        "// SPDX-License-Identifier: Apache-2.0\n"
        f"// Configuration `{name}`, written by scripts/configure.py.\n"
        f'#pragma once\n\nnamespace ti::config {{\n\ninline constexpr char kName[] = "{name}";\n'
        f"/// The keys that the RTL is made of.\n"
        f'inline constexpr char kJson[] = R"({keys})";\n'
        f"{lines}\n}}  // namespace ti::config\n"
    )


def write_changed(path: Path, text: str) -> None:
    """Make `path` hold `text`; whoever reads it meanwhile sees the old or the new one whole."""
    if not path.is_file() or path.read_text() != text:
        partial = path.with_suffix(f".{os.getpid()}")
        partial.write_text(text)
        partial.replace(path)


def configure(name_or_path: str, overrides: list[str], out: Path) -> dict[str, int]:
    """Check the configuration and write its files into `out`; its values in the order of KEYS."""
    path = find(name_or_path)
    config = read(path, overrides)
    check(path, config)
    config = {key: config[key] for key in KEYS}
    name = " ".join([path.stem, *overrides])
    files = {
        "ti_config_pkg.sv": package(name, config),
        "ti_config.hpp": header(name, config),
        "ti_count_pkg.sv": counters.package(config),
        "ti_counters.hpp": counters.header(config),
        "config.json": json.dumps({"name": name, **config}, indent=2) + "\n",
    }
    out.mkdir(parents=True, exist_ok=True)
    for file, text in files.items():
        write_changed(out / file, text)
    return config


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name_or_path", help="name of a file in configs/, or a path")
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    arguments = parser.parse_args()
    try:
        configure(arguments.name_or_path, arguments.overrides, arguments.out)
    except ConfigError as error:
        print(error, file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
