"""The C library for tests: where it was built, and its functions by ctypes."""

from __future__ import annotations

import ctypes
import functools
import os
import re
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p

import numpy as np
import pytest

from support.paths import ROOT

HEADER = ROOT / "src" / "native" / "capi" / "halfphysics.h"
#: Builds that have it: of tools/build_inplace.sh, of tools/test_native.sh, of docs/c-api.md.
BUILDS = ("inplace", "native", "c")
CONTACT = np.dtype(
    [(name, "<i4") for name in ("person", "part", "subject", "other", "other_part", "reserved")]
    + [(name, "<f8", 3) for name in ("position", "normal", "impulse", "force")]
)


def folder():
    """The build that has the newest library; skips the test where there is none."""
    found = [ROOT / "build" / name / "libhalfphysics.so" for name in BUILDS]
    found = sorted((p for p in found if p.is_file()), key=lambda p: p.stat().st_mtime)
    if not found:
        pytest.skip("no C library: tools/test_native.sh builds it")
    return found[-1].parent


@functools.cache
def load():
    """The library, with the types of what it returns."""
    lib = ctypes.CDLL(os.fspath(folder() / "libhalfphysics.so"))
    for name in ("hp_world_load", "hp_world_open"):
        getattr(lib, name).restype = c_void_p
    for name in (
        "hp_error",
        "hp_version",
        "hp_name",
        "hp_body_name",
        "hp_hinge_name",
        "hp_joint_name",
    ):
        getattr(lib, name).restype = c_char_p
    return lib


def functions():
    """Names of all functions that the header declares."""
    return sorted(set(re.findall(r"\b(hp_\w+)\(", HEADER.read_text(encoding="utf-8"))))


class CError(Exception):
    """A call that failed: `status`, and what hp_error() says."""

    def __init__(self, status):
        super().__init__(load().hp_error().decode())
        self.status = status


class CWorld:
    """A world of the C library; methods as in the npm package."""

    handle = None

    def __init__(self, data):
        lib = load()
        self.handle = c_void_p(lib.hp_world_load(data, c_size_t(len(data))))
        if not self.handle:
            raise CError(2)
        self.people = lib.hp_person_count(self.handle)
        count = lib.hp_name_count(self.handle)
        self.names = [lib.hp_name(self.handle, i).decode() for i in range(count)]

    def __del__(self):
        if self.handle:
            load().hp_world_free(self.handle)

    def call(self, function, *given):
        """Calls a function with arrays, numbers and names; raises `CError`."""
        status = getattr(load(), f"hp_{function}")(self.handle, *map(_argument, given))
        if status:
            raise CError(status)

    def reset(self, *poses):
        self.call("reset", *_arrays(poses))

    def step(self, *poses, dt):
        self.call("step", *_arrays(poses), float(dt))

    def pose(self, person=0):
        translation, rotations = np.empty(3), np.empty((55, 3))
        self.call("get_pose", person, translation, rotations)
        return translation, rotations

    def object(self, name):
        position, quaternion = np.empty(3), np.empty(4)
        self.call("get_object", name, position, quaternion)
        return position, quaternion

    def velocity(self, name):
        velocity, angular = np.empty(3), np.empty(3)
        self.call("get_velocity", name, velocity, angular)
        return velocity, angular

    def bodies(self):
        out = np.empty((load().hp_body_count(self.handle), 7))
        self.call("get_bodies", out)
        return out

    def number(self, function, *given):
        """What a function such as get_clearance gives."""
        out = c_double()
        self.call(function, *given, byref(out))
        return out.value

    def contacts(self):
        count = c_size_t()
        self.call("get_contacts", None, c_size_t(0), byref(count))
        out = np.zeros(count.value, dtype=CONTACT)
        self.call("get_contacts", out, c_size_t(len(out)), byref(count))
        return out

    def save(self):
        size = c_size_t()
        self.call("save", None, c_size_t(0), byref(size))
        out = np.zeros(size.value, dtype=np.uint8)
        self.call("save", out, size, byref(size))
        return out.tobytes()

    def load(self, state):
        self.call("load", state, c_size_t(len(state)))


def _arrays(poses):
    translation = np.array([p.translation for p in poses], dtype=np.float64)
    return translation, np.array([p.rotations for p in poses], dtype=np.float64)


def _argument(value):
    if isinstance(value, str):
        return value.encode()
    if isinstance(value, float):
        return c_double(value)
    if isinstance(value, int):
        return c_int(value)
    if isinstance(value, np.ndarray):
        assert value.flags.c_contiguous
        return value.ctypes.data_as(c_void_p)
    return value
