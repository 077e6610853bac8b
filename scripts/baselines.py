# SPDX-License-Identifier: Apache-2.0
"""Measured results that are kept: what may move how far, and why it was last recorded.

A file of tb/baselines has, for each unit, what a command measured, the tools and the configuration
of then, and the reason that a person gave.  A number beyond its tolerance is red in `make test`
until it is recorded anew.
"""

import argparse
import json
from pathlib import Path

from synthesis import MeasureError, write_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of a command whose results have a baseline."""
    parser.add_argument("--baseline", type=Path, metavar="FILE", help="compare with it")
    parser.add_argument("--record", metavar="REASON", help="write the baseline, with this reason")


def settle(arguments: argparse.Namespace, result: dict, keys: tuple[str, ...]) -> int:
    """Record or compare as the arguments say; 1 when something moved beyond its tolerance."""
    if arguments.record is not None:
        if not arguments.baseline:
            raise MeasureError("--record needs --baseline, the file to write")
        record(arguments.baseline, result, keys, arguments.record)
        print(f"recorded in {arguments.baseline}")
        return 0
    if not arguments.baseline:
        return 0
    sentences = moved(load(arguments.baseline), result)
    print("\n".join(sentences) or f"within the tolerances of {arguments.baseline}")
    return 1 if sentences else 0


def load(file: Path) -> dict:
    """A baseline file."""
    try:
        return json.loads(file.read_text())
    except (OSError, ValueError) as error:
        raise MeasureError(f"{file} is no baseline: {error}") from error


def record(file: Path, result: dict, keys: tuple[str, ...], reason: str) -> None:
    """Put the units of a result into a file; other units and parts in it stay."""
    if not reason.strip():
        raise MeasureError("a baseline is recorded with a reason, REASON='...'")
    stored = load(file) if file.is_file() else {}
    stored["configuration"] = result["configuration"]
    stored["tolerances"] = stored.get("tolerances", {}) | result["tolerances"]
    for unit, values in result["units"].items():
        stored.setdefault("units", {}).setdefault(unit, {})[result["part"]] = {
            "values": {key: values[key] for key in keys if key in values},
            "reason": reason.strip(),
            "tools": result["tools"],
            "configuration_hash": result["configuration_hash"],
        }
    write_json(file, stored)


def moved(stored: dict, result: dict) -> list[str]:
    """A sentence for each number of a result that is beyond the tolerance of the baseline."""
    found = []
    if stored["configuration"] != result["configuration"]:
        raise MeasureError(
            f"the baseline is of {stored['configuration']}, this of {result['configuration']}"
        )
    for unit, values in result["units"].items():
        entry = stored["units"].get(unit, {}).get(result["part"])
        if entry is None:
            found.append(f"{unit} on {result['part']}: no baseline")
            continue
        for key, before in entry["values"].items():
            now, tolerance = values.get(key, 0), stored["tolerances"].get(key, 0)
            if abs(now - before) > tolerance * abs(before):
                found.append(
                    f"{unit} on {result['part']}: {key} was {before:g}, is {now:g}, beyond "
                    f"{tolerance:.0%}; if it is right, record it with REASON='...'"
                )
    return found
