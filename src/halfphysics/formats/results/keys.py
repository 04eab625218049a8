"""The keys of a result file; docs/result-files.md describes each."""

from __future__ import annotations

#: Version of the layout; a reader refuses newer ones.
VERSION = 1
VERSION_KEY = "meta/format_version"
OBJECT = "object/"
JOINT = "joint/"
CONTACT = "contact/"
INSIDE = "inside/"
BREACHES = "breaches/"
SOFT = "soft_contact/"
#: After the prefix of a person: the records of the things that are held, by number of the hold.
HOLD = "hold/"
SUBSTEPS = "meta/substeps/"
DIAGNOSTICS = "meta/diagnostics/"


def person_prefix(index: int) -> str:
    """The prefix of the keys of a person's motions."""
    return "meta/" if index == 0 else f"person/{index}/"
