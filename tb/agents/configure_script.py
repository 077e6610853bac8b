# SPDX-License-Identifier: Apache-2.0
"""Run `scripts/configure.py` and `scripts/config_forms.py`, and read what they say."""

import subprocess
import sys
from pathlib import Path

import config_schema
import jsonschema

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = ROOT / "scripts/configure.py"
FORMS = ROOT / "scripts/config_forms.py"
DOCUMENT = ROOT / "docs/configuration.md"
SCHEMA = config_schema.load()


def script(*arguments, script=SCRIPT):
    command = [sys.executable, str(script), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def refused(result, out, *words):
    """One sentence with these words, status 2, nothing written."""
    assert result.returncode == 2, result.stderr
    assert result.stderr.count("\n") == 1
    assert [word for word in words if word not in result.stderr] == [], result.stderr
    assert not out.exists()


def complaints(schema, value):
    """What JSON Schema says of a value."""
    validator = jsonschema.Draft202012Validator(schema)
    validator.check_schema(schema)
    return [error.message for error in validator.iter_errors(value)]
