"""The types of the TypeScript client name what the schema of the messages has, field by field."""

from __future__ import annotations

import re
from typing import get_args, get_type_hints

import msgspec
import pytest

from halfphysics.live import schema
from support.paths import ROOT

SOURCE = (ROOT / "js" / "client" / "src" / "messages.ts").read_text(encoding="utf-8")
STRUCTS = {  # a private one is a way to read, and no message
    name: kind
    for name, kind in vars(schema).items()
    if isinstance(kind, type)
    and issubclass(kind, msgspec.Struct)
    and kind is not msgspec.Struct
    and not name.startswith("_")
}


def fields(name: str) -> dict[str, bool]:
    """Field of an interface -> whether it may be missing."""
    body = re.search(rf"export interface {name} \{{\n(.*?)\n\}}", SOURCE, re.S)
    assert body, f"no interface {name}"
    text = re.sub(r"/\*\*.*?\*/", "", body[1], flags=re.S)
    return {k: bool(q) for k, q in re.findall(r"^  (\w+)(\??):", text, re.M)}


@pytest.mark.parametrize("name", sorted(STRUCTS))
def test_every_message_has_its_interface(name):
    struct = STRUCTS[name]
    config = struct.__struct_config__
    known = {field.encode_name for field in msgspec.structs.fields(struct)}
    if config.tag_field:
        known.add(config.tag_field)
    assert set(fields(name)) == known


@pytest.mark.parametrize("name", sorted(n for n in STRUCTS if STRUCTS[n].__struct_config__.tag))
def test_tags_are_those_of_the_schema(name):
    config = STRUCTS[name].__struct_config__
    assert re.search(
        rf'export interface {name} \{{.*?{config.tag_field}: "{config.tag}";', SOURCE, re.S
    )


def test_no_interface_is_stale():
    assert set(re.findall(r"export interface (\w+)", SOURCE)) - set(STRUCTS) == set()


def test_what_a_client_may_leave_out_has_a_default():
    sent = ["PersonPose", "Add", "Drag", "Stiffness", "Impulse", "Edit", "Subscribe", "Ping"]
    for name in sent:
        optional = {
            field.encode_name
            for field in msgspec.structs.fields(STRUCTS[name])
            if not field.required
        }
        missing = {field for field, may in fields(name).items() if may}
        assert missing == optional, name


def test_version_parts_and_codes():
    assert f"export const VERSION = {schema.VERSION};" in SOURCE
    parts = re.search(r"export type Part = (.*?);", SOURCE)[1]
    assert tuple(re.findall(r'"(\w+)"', parts)) == schema.PARTS
    codes = re.search(r"code: (.*?);", SOURCE)[1]
    kinds = get_args(get_type_hints(schema.ErrorMessage)["code"])
    assert set(re.findall(r'"(\w+)"', codes)) == set(kinds)
