"""Small samples and shards made by hand, for tests of their readers and writers."""

from __future__ import annotations

import io
import json
import tarfile
from functools import cache

import numpy as np

from halfphysics.base.npz_bytes import npz_bytes
from halfphysics.sweep.make.card import CHECKS
from halfphysics.sweep.plan.plan import Plan
from halfphysics.sweep.store.data_card import SPREADS, SUMMED, DataCard
from halfphysics.sweep.store.store import Store

FRAMES = 30


@cache
def sample(number):
    """Key and files of a sample, computed from its number."""
    return sample_with_card(number, card_of(number))


def card_of(number):
    """A card with all fields that a data card counts."""
    return {
        "number": number,
        "input": "a.npz" if number < 11 else "b.npz",
        "factors": {"mass": 0.5},
        "versions": {"halfphysics": "0"},
        "success": number % 5 != 0,
        "checks": dict.fromkeys(CHECKS, number % 5 != 0),
        **dict.fromkeys(SUMMED, number),
        **dict.fromkeys(SPREADS, 0.1 * number),
    }


def sample_with_card(number, card):
    """The same with another card."""
    rng = np.random.default_rng(number)
    body = np.zeros((FRAMES, 2000), np.int8)
    body[number % FRAMES :, 100:160] = 21
    files = {
        "card.json": json.dumps(card).encode(),
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
                "body/cup": body[:, ::2],
                "second:body/cup": body[:, ::3],
                "second/body:cup": body[:, ::5],
                "human_parts": np.zeros((FRAMES, 55), bool),
                "nothing": np.zeros((0, 3)),
                "threshold_m": np.array(0.002),
                "contacts/frame": rng.integers(0, FRAMES, 7),
            }
        ),
    }
    return f"{number:09d}", files


def arrays_of(data):
    """The arrays of an npz file by name."""
    with np.load(io.BytesIO(data), allow_pickle=False) as npz:
        return dict(npz)


def write_tar(path, samples):
    """A shard as a sweep writes it, by the standard library in one go."""
    with tarfile.open(path, "w", format=tarfile.USTAR_FORMAT) as archive:
        for key, files in samples:
            for name, data in files.items():
                info = tarfile.TarInfo(f"{key}.{name}")
                info.size = len(data)
                archive.addfile(info, io.BytesIO(data))
    return path


def plan_of(base, *, variants=11, batch=2, per_shard=6, formats=("webdataset",), seed=0):
    """A plan of so many variants: two files, values of a factor; the files are never opened."""
    for name in ("a.npz", "b.npz"):
        if not (base / name).exists():
            (base / name).write_bytes(name.encode())
    document = {
        "inputs": {"files": "*.npz"},
        "factors": {"motion.yaw": list(range(variants))},
        "outputs": {"formats": list(formats), "batch": batch, "variants_per_shard": per_shard},
        "seed": seed,
    }
    return Plan.from_document(document, base)


def record_of(store, batch, failed=()):
    """A worker's report on a batch in which variants 3 and 8 were filtered out."""
    numbers, card = store.layout.variants_of(batch), DataCard()
    cause = {"input": "a.npz", "factors": {}, "cause": "InputError: the clip is broken"}
    failures = [{"number": n, **cause} for n in numbers if n in failed]
    skipped = sum(number in (3, 8) for number in numbers)
    for number in numbers:
        if number not in (3, 8, *failed):
            card.sample(card_of(number))
    for failure in failures:
        card.failure(failure)
    card.skip(skipped)
    return {"skipped": skipped, "failures": failures, "sums": card.sums(), "inputs": {}}


def make_batch(store, batch, failed=(), **more):
    """Write a fragment, as a worker does."""
    numbers = store.layout.variants_of(batch)
    kept = (sample(n) for n in numbers if n not in (3, 8, *failed))
    store.write_fragment(batch, kept, record_of(store, batch, failed) | more)


def make(store, failed=(), **more):
    """The complete output of a sweep, written as a driver and its workers do."""
    for shard in range(store.layout.shards):
        if not store.done(shard):
            for batch in store.left(shard):
                make_batch(store, batch, failed, **more)
            store.seal(shard)
    return store.finish()


def run(folder, plan, program="this"):
    """A sweep from its start, or from its last state, to its end."""
    with Store(folder, plan, program) as store:
        return make(store)


def tree(folder):
    """The content of a folder without notes: path -> bytes."""
    files = sorted(p for p in folder.rglob("*") if p.is_file())
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in files
        if path.name != "driver.lock" and path.parent.name != "stats"
    }
