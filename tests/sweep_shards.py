"""Small samples and shards made by hand, for tests of what reads and writes them."""

from __future__ import annotations

import io
import json
import tarfile

import numpy as np

from halfphysics.io.npz import npz_bytes

FRAMES = 30


def sample(number, card=None):
    """Key and files of a sample, all from its number."""
    rng = np.random.default_rng(number)
    body = np.zeros((FRAMES, 2000), np.int8)
    body[number % FRAMES :, 100:160] = 21
    files = {
        "card.json": json.dumps(card or {"number": number, "factors": {"mass": 0.5}}).encode(),
        "human.npz": npz_bytes(
            {
                "poses": rng.normal(size=(FRAMES, 156)),
                "trans": rng.normal(size=(FRAMES, 3)),
                "betas": np.zeros(10),
                "gender": np.array("neutral"),
                "fps": np.array(30.0),
            }
        ),
        "object.npz": npz_bytes(
            {
                "angles": np.zeros((FRAMES, 3)),
                "trans": rng.normal(size=(FRAMES, 3)),
                "name": np.array("tür/blatt"),
                "joints": np.array(["door/hinge", "door/handle"]),
            }
        ),
        "contact.npz": npz_bytes(
            {
                "body": body,
                "human_parts": np.zeros((FRAMES, 55), bool),
                "nothing": np.zeros((0, 3)),
                "threshold_m": np.array(0.002),
            }
        ),
    }
    return f"{number:09d}", files


def write_tar(path, samples):
    """A shard as a sweep leaves it, written by the standard library in one go."""
    with tarfile.open(path, "w", format=tarfile.USTAR_FORMAT) as archive:
        for key, files in samples:
            for name, data in files.items():
                info = tarfile.TarInfo(f"{key}.{name}")
                info.size = len(data)
                archive.addfile(info, io.BytesIO(data))
    return path
