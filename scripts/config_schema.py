# SPDX-License-Identifier: Apache-2.0
"""`configs/schema.yaml` as Python: the keys of a configuration and the values that they take."""

import re
from dataclasses import dataclass
from pathlib import Path

import yaml

SCHEMA = Path(__file__).resolve().parents[1] / "configs/schema.yaml"
TYPES = {"int": int, "bool": bool, "enum": str, "float": float}
FIELDS = {"type", "default", "group", "text", "range", "power", "values", "hardware"}
INT_LIMIT = 1 << 31  # of an int in C++
Value = int | bool | str | float


class ConfigError(Exception):
    """One sentence that names the file, the key and what is allowed."""


def is_power(value: int) -> bool:
    return value > 0 and value & (value - 1) == 0


def camel(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("_"))


@dataclass(frozen=True)
class Key:
    """One key: `kind` is a word of TYPES, `low` and `high` bound numbers, an enum has `values`."""

    name: str
    kind: str
    default: Value
    group: str
    text: str
    low: float = 0
    high: float = 0
    power: bool = False
    values: tuple[str, ...] = ()
    hardware: bool = True

    def allows(self, value: object) -> bool:
        if type(value) is not TYPES[self.kind]:
            return False
        if self.kind == "enum":
            return value in self.values
        return self.kind == "bool" or (
            self.low <= value <= self.high and (not self.power or is_power(value))
        )

    def allowed(self) -> str:
        """The values that it takes, in words."""
        if self.kind == "bool":
            return "true or false"
        if self.kind == "enum":
            return f"one of {', '.join(self.values)}"
        what = {"int": "a whole number", "float": "a number"}[self.kind]
        return f"{'a power of two' if self.power else what} from {self.low} to {self.high}"

    def of(self, value: object) -> object:
        """`value` of a file in the type of the key where nothing is lost; else as it is."""
        if self.kind == "float" and type(value) is int:
            return float(value)
        if self.kind == "bool" and type(value) is int and value in (0, 1):
            return bool(value)
        return value

    def of_text(self, text: str) -> object:
        """The value that KEY=`text` means; `text` itself when it is none of the type."""
        try:
            if self.kind == "int":
                return int(text, 0)
            if self.kind == "float":
                return float(text)
        except ValueError:
            return text
        if self.kind == "bool":
            return {"0": False, "1": True, "false": False, "true": True}.get(text, text)
        return text


@dataclass(frozen=True)
class Schema:
    """All keys in their order, the titles of their groups, and formats of the compiled model."""

    keys: dict[str, Key]
    groups: dict[str, str]
    formats: tuple[tuple[int, int], ...]

    def defaults(self) -> dict[str, Value]:
        return {key.name: key.default for key in self.keys.values()}


def load(path: Path = SCHEMA) -> Schema:
    """The schema of a file; a `ConfigError` names what is wrong with it."""
    try:
        table = yaml.safe_load(path.read_text())
        groups = table["groups"]
        formats = tuple((int(e), int(m)) for e, m in table["formats"])
        keys = {name: _key(name, entry, groups) for name, entry in table["keys"].items()}
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None
    except (yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise ConfigError(f"{path}: not a schema: {' '.join(str(error).split())}") from None
    return Schema(keys, groups, formats)


def _key(name: str, entry: dict, groups: dict) -> Key:
    """One entry of the schema, checked."""

    def need(what: bool, sentence: str) -> None:
        if not what:
            raise ConfigError(f"{name}: {sentence}")

    need(re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name), "a key is written in snake_case")
    need(not entry.keys() - FIELDS, f"unknown field {', '.join(entry.keys() - FIELDS)}")
    need(entry["type"] in TYPES, f"the types are {', '.join(TYPES)}")
    need(entry["group"] in groups, f"there is no group {entry['group']}")
    numeric = entry["type"] in ("int", "float")
    need(numeric == ("range" in entry), "numbers have a range, others have none")
    need((entry["type"] == "enum") == bool(entry.get("values")), "an enum has values")
    low, high = entry.get("range", (0, 0))
    need(-INT_LIMIT <= low <= high < INT_LIMIT, "the range is not that of an int")
    key = Key(
        name=name,
        kind=entry["type"],
        default=entry["default"],
        group=entry["group"],
        text=entry["text"],
        low=low,
        high=high,
        power=entry.get("power", False),
        values=tuple(entry.get("values", ())),
        hardware=entry.get("hardware", True),
    )
    need(key.allows(key.default), f"the default {key.default} is not {key.allowed()}")
    return key
