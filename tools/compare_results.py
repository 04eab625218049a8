"""Are the results still the same to the bit? Hashes of simulations, compared with a record.

A change that is said to change no number is shown to change none: this simulates, measures and
writes some hundred cases (tools/result_cases: scenarios, clips, meshes, settings, baselines, live
edits, a person in a MuJoCo world, labels, pictures, files) and compares SHA-256 of what comes out
with those of a record.

    python tools/compare_results.py record               # before the change: into out/results.json
    python tools/compare_results.py compare              # after it; 1: something differs
    python tools/compare_results.py compare --quick      # a part of every family, in under a minute
    python tools/compare_results.py compare --only 'live/*' --only '*/self_contact'
    python tools/compare_results.py compare --vector all # the core built for AVX2, SSE2, plain loops
    python tools/compare_results.py list

What is run is the `halfphysics` that Python imports: the installed one, or the one of this checkout
with PYTHONPATH=src and tools/build_inplace.sh. `--vector` builds this checkout's core instead, in
build/vector-MODE, and runs it with this checkout's Python files. Motions and meshes are read from
../shared/data, or $HALFPHYSICS_TEST_DATA.

The hashes hold for one machine's libm, numpy and mujoco: their versions stand at the head of the
record, and where they differ that is said, and compared all the same.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from fnmatch import fnmatch
from multiprocessing import get_context
from pathlib import Path
from typing import Any

RECORD = Path(__file__).resolve().parents[1] / "out" / "results.json"
#: Packages that take part in the numbers.
PACKAGES = ("numpy", "scipy", "mujoco", "trimesh", "coacd", "pillow", "usd-core")
#: Threads of numpy's linear algebra: their number may change its sums.
ALONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
#: Of what went wrong so much is shown [characters].
SAID = 300

#: What came of a case: its hash and those of its values, or what went wrong.
Outcome = Mapping[str, Any]


def main() -> int:
    """Do what the command line says; 0: done and nothing differs, 1: something does."""
    options = _options()
    if options.vector:
        from result_cases.vectors import run_in_modes

        return run_in_modes(options)
    os.environ.update(ALONE)
    from result_cases import all_cases

    chosen = _chosen(options, all_cases())
    if options.what == "list":
        print("\n".join(chosen))
        return 0
    head = described()
    print("\n".join(f"{name}: {value}" for name, value in head.items()), flush=True)
    with tempfile.TemporaryDirectory() as folder:
        # What the program keeps between runs must not hide a change of how it is made.
        os.environ["HALFPHYSICS_CACHE"] = folder
        outcomes = run(chosen, options.jobs)
        if options.what == "record":
            return record(options.file, head, dict(outcomes))
        return compare(options.file, head, outcomes)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("record", "compare", "list"))
    parser.add_argument("file", nargs="?", type=Path, default=RECORD, help="the record")
    parser.add_argument("--quick", action="store_true", help="a part of every family")
    parser.add_argument("--only", action="append", default=[], metavar="PATTERN",
                        help="cases of these names (*, ? and [...] match); may be repeated")  # fmt: skip
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--vector", choices=("avx2", "sse2", "plain", "all"),
                        help="build this checkout's core for these instructions and run it")  # fmt: skip
    return parser.parse_args()


def _chosen(options: argparse.Namespace, cases: Mapping[str, Any]) -> list[str]:
    names = [name for name, case in cases.items() if case.quick or not options.quick]
    if options.only:
        names = [n for n in names if any(fnmatch(n, pattern) for pattern in options.only)]
    if not names:
        sys.exit(f"no case of these names: {', '.join(options.only)}")
    return names


def described() -> dict[str, str]:
    """What the numbers may depend on besides the code."""
    from importlib.metadata import PackageNotFoundError, version

    import halfphysics

    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    libc = " ".join(platform.libc_ver()).strip() or platform.platform()
    return {
        "halfphysics": str(Path(halfphysics.__file__).parent),
        "platform": f"{platform.system()} {platform.machine()}, {libc}, {_processor()}",
        "python": platform.python_version(),
        "packages": ", ".join(f"{name} {number}" for name, number in found.items()),
    }


def _processor() -> str:
    """The widest vectors of the processor, by which numpy chooses its loops."""
    try:
        flags = Path("/proc/cpuinfo").read_text().split()
    except OSError:
        return platform.processor()
    return next((name for name in ("avx512f", "avx2", "sse2") if name in flags), "no vectors")


# -- running -----------------------------------------------------------------------------------


def run(names: list[str], jobs: int) -> Iterator[tuple[str, Outcome]]:
    """Run cases in other processes; what came of each, in the order given, as soon as it is known."""
    began, found, told = time.perf_counter(), {}, 0
    for name, outcome in _everything(names, max(1, jobs)):
        found[name] = outcome
        while told < len(names) and names[told] in found:
            yield names[told], found[names[told]]
            told += 1
    print(f"{len(found)} cases in {time.perf_counter() - began:.1f} s", flush=True)


def _everything(names: list[str], jobs: int) -> Iterator[tuple[str, Outcome]]:
    """Cases as they are done. Where a process dies, each case left gets a process of its own."""
    left = set(names)
    try:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            futures = {pool.submit(outcome_of, name): name for name in names}
            for future in as_completed(futures):
                outcome = future.result()
                left.discard(futures[future])
                yield futures[future], outcome
    except BrokenProcessPool:
        for name in (n for n in names if n in left):
            yield name, _alone(name)


def _alone(name: str) -> Outcome:
    try:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            return pool.submit(outcome_of, name).result()
    except BrokenProcessPool:
        return {"error": "its process died"}


def outcome_of(name: str) -> Outcome:
    """Run one case: {"hash", "values", "seconds"}, or {"error"}."""
    import warnings

    from result_cases import all_cases
    from result_cases.digests import digests

    began = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            whole, each = digests(all_cases()[name].run())
    except Exception as error:  # one case that fails leaves the others to be compared
        said = " ".join(f"{type(error).__name__}: {error}".split())
        return {"error": said[:SAID] + ("..." if len(said) > SAID else "")}
    return {"hash": whole, "values": each, "seconds": time.process_time() - began}


# -- the record --------------------------------------------------------------------------------


def record(file: Path, head: Mapping[str, str], outcomes: Mapping[str, Outcome]) -> int:
    """Write a record, one line a case; those of cases that were not run stay."""
    from result_cases import all_cases

    before = json.loads(file.read_text())["cases"] if file.exists() else {}
    kept = {name: before[name] for name in all_cases() if name in before}
    kept |= {name: _line(outcome) for name, outcome in outcomes.items() if "error" not in outcome}
    about = {name: value for name, value in head.items() if name != "halfphysics"}
    lines = ",\n".join(f" {json.dumps(name)}: {json.dumps(kept[name])}" for name in sorted(kept))
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f'{{"about": {json.dumps(about, indent=1)},\n"cases": {{\n{lines}\n}}}}\n')
    failed = 0
    for name, outcome in outcomes.items():
        if "error" in outcome:
            print(f"failed     {name}: {outcome['error']}")
            failed += 1
    print(f"{file}: {len(outcomes) - failed} cases recorded, {failed} failed")
    return int(failed > 0)


def _line(outcome: Outcome) -> dict[str, Any]:
    return {"hash": outcome["hash"], "values": outcome["values"]}


def compare(file: Path, head: Mapping[str, str], outcomes: Iterable[tuple[str, Outcome]]) -> int:
    """Say of each case whether it is equal to the record's; 1 where one is not."""
    known = json.loads(file.read_text())
    for name, value in known["about"].items():
        if value != head[name]:
            print(
                f"NOTE: the record was made with another {name}: {value}. Differences may come "
                "from that and not from the code"
            )
    counts = dict.fromkeys(("equal", "different", "failed", "unrecorded"), 0)
    for name, outcome in outcomes:
        verdict, detail = _verdict(known["cases"].get(name), outcome)
        counts[verdict] += 1
        print(f"{verdict:10} {outcome.get('seconds', 0.0):6.2f} s  {name}{detail}", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in counts.items()))
    return int(counts["equal"] < sum(counts.values()))


def _verdict(before: Outcome | None, now: Outcome) -> tuple[str, str]:
    if "error" in now:
        return "failed", f": {now['error']}"
    if before is None:
        return "unrecorded", ""
    if before["hash"] == now["hash"]:
        return "equal", ""
    old, new = before["values"], now["values"]
    changed = [name for name in {**old, **new} if old.get(name) != new.get(name)]
    return "different", f": {', '.join(changed)}"


if __name__ == "__main__":
    sys.exit(main())
