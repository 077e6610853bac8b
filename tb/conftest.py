# SPDX-License-Identifier: Apache-2.0
"""Files that took longest the last time start first; the slowest tests go to build/test."""

import json
import os
from collections import Counter
from pathlib import Path

OUT = Path(__file__).resolve().parents[1] / "build/test"
FILES = OUT / "seconds-of-files.json"
_seconds = Counter()


def _known():
    return json.loads(FILES.read_text()) if FILES.is_file() else {}


def _file(item):
    return item.nodeid.split("::")[0]


def pytest_collection_modifyitems(items):
    """A file that was never timed may be long; of two such files, the one with fewer tests, as
    those of a whole machine are few and long.
    """
    known = _known()
    tests = Counter(map(_file, items))
    items.sort(key=lambda item: (-known.get(_file(item), float("inf")), tests[_file(item)]))


def pytest_runtest_logreport(report):
    _seconds[report.nodeid] += report.duration


def pytest_sessionfinish(session):
    """Times of what ran, known to the process that collects them."""
    if hasattr(session.config, "workerinput") or not _seconds:
        return
    OUT.mkdir(parents=True, exist_ok=True)
    files = Counter()
    for test, seconds in _seconds.items():
        files[test.split("::")[0]] += seconds
    part = FILES.with_suffix(f".{os.getpid()}")  # others may read meanwhile
    part.write_text(json.dumps(_known() | files, indent=1))
    part.replace(FILES)
    lines = [f"{seconds:7.1f} s  {test}\n" for test, seconds in _seconds.most_common(15)]
    (OUT / "slowest.txt").write_text("".join(lines))
