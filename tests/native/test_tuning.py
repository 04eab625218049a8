"""Constants of the core: each is defined once, with one meaning."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from halfphysics._native import tuning

HEADER = Path(__file__).resolve().parents[2] / "src" / "native" / "tuning.h"


def test_no_name_has_two_meanings():
    lines = [line.split("//")[0] for line in HEADER.read_text(encoding="utf-8").splitlines()]
    declared = [line for line in lines if line.startswith("constexpr ")]
    names = Counter(name for line in declared for name in re.findall(r"\b(k[A-Z]\w*) =", line))
    assert len(names) > 100
    assert [name for name, count in names.items() if count > 1] == []


def test_python_reads_what_it_shares():
    assert tuning.least_clearance == 2e-5
    assert tuning.resist_rounds == 6
