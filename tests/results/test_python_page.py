"""docs/python.md and a user's script run as they are printed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib

from support.paths import ROOT, TESTS

PAGE = ROOT / "docs" / "python.md"
#: Blocks that need what the test environment has not, marked "python no-run": torch.
BLOCKS = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.S | re.M)


def test_the_snippets_run_one_after_the_other(tmp_path):
    script = tmp_path / "snippets.py"
    script.write_text("\n".join(BLOCKS), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, script],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "charts.png").stat().st_size > 10_000


def test_a_result_is_the_line_that_is_printed():
    names: dict[str, object] = {}
    exec(BLOCKS[0], names)
    words = " ".join(PAGE.read_text(encoding="utf-8").split())
    assert f"`{names['result']!r}`" in words


def test_the_page_names_every_variable():
    """Of a dataset with all there is."""
    from support import small_results as small

    text = PAGE.read_text(encoding="utf-8")
    patterns = {
        "contact_": "`contact_COLUMN`",
        "inside_": "`inside_COLUMN`",
        "breach_": "`breach_COLUMN`",
        "diagnostic_": "`diagnostic_NAME`",
        "articulation_": "`articulation_NAME.JOINT`",
        "substep_": "`substep_...`",
    }
    patterns = {start: name.strip("`") for start, name in patterns.items()}
    for name in small.result().to_xarray(vertices=False).data_vars:
        general = next((v for start, v in patterns.items() if name.startswith(start)), name)
        assert f"`{general}" in text, name


def test_a_users_script(tmp_path):
    """The one that mypy --strict accepts (pyproject.toml names it for ./run check)."""
    done = subprocess.run(
        [sys.executable, TESTS / "users" / "script.py", tmp_path],
        env={**os.environ, "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0].startswith("Result(20 frames at 30 fps, 1 person, 1 object, ")
    assert re.fullmatch(r"\d+\.\d N, error 0 mm, same: True", lines[-1])
    assert not lines[-1].startswith("0.0 N")
    assert {path.name for path in tmp_path.iterdir()} == {"charts.png", "result.html", "result.npz"}


def test_mypy_is_told_of_the_script():
    with (ROOT / "pyproject.toml").open("rb") as file:
        mypy = tomllib.load(file)["tool"]["mypy"]
    assert mypy["strict"] is True
    assert "tests/users/script.py" in mypy["files"]
