"""JSON and YAML that are nested, repeated or endless."""

from __future__ import annotations

from pathlib import Path

from support.files.hostile.attacks import attack, written


@attack("scene")
def json_of_a_gigabyte(folder: Path) -> Path:
    path = folder / "a.json"
    with path.open("wb") as handle:  # sparse: no blocks on the disk
        handle.write(b'{"statics": {}, "objects": {')
        handle.truncate(2**30)
    return path


@attack("scene")
def json_of_lists(folder: Path) -> Path:
    return written(folder / "a.json", '{"statics": [' + "[]," * 4_000_000 + "[]]}")


@attack("scene")
def json_nested(folder: Path) -> Path:
    return written(folder / "a.json", '{"statics": ' + "[" * 2_000_000)


@attack("scene")
def yaml_of_aliases(folder: Path) -> Path:
    lines = ["gravity: &a0 [" + ", ".join(["1"] * 10) + "]"]
    lines += [f"k{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 10)]
    return written(folder / "a.yaml", "\n".join(["statics: {}", *lines[:1], *lines[1:]]))


@attack("scene")
def yaml_of_aliases_for_a_number(folder: Path) -> Path:
    lists = "[&a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"
    for k in range(1, 12):
        lists += f", &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]"
    text = f"statics:\n  a: {{shape: sphere, radius: {lists}]}}\n"
    return written(folder / "a.yaml", text)


@attack("scene")
def yaml_nested(folder: Path) -> Path:
    return written(folder / "a.yaml", "statics: " + "[" * 100_000)


@attack("scene")
def yaml_nested_in_blocks(folder: Path) -> Path:
    return written(folder / "a.yaml", "- " * 100_000)
