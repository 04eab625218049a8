"""A sample of the campaign."""

from __future__ import annotations

from campaigns.wasm_and_c import c_example


def test_c_example():
    assert c_example(20) == 0.0
