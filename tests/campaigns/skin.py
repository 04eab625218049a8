"""The campaign behind `campaigns/test_skin.py`: every posture, throw and room, judged on the skin.

    PYTHONPATH=tests python -m campaigns.skin [--contact skin] [--data DATA] --log rows.jsonl
        [--seconds 600] [--shard 0/2] [--only sit_] [--case ID] [--seeds 3]
        [--kinds posture,throw,room] [--summary]

Postures (`postures`) come in all kinds of furniture, settings and seeds; throws and rooms are the
cases of `campaigns.clear`. One row of numbers each; every committed pose is judged. Cases have a
fixed shuffled order, so any part of the campaign is a fair sample; logged cases are not run
again. `PYTHONPATH` chooses the build that is judged.
"""

from __future__ import annotations

import time
import zlib
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from itertools import product

import numpy as np

from campaigns import clear as clear_campaign
from halfphysics.body.body import Body
from halfphysics.errors import InputError
from halfphysics.settings import AS_IT_IS, Settings
from halfphysics.simulation.simulator import Simulator
from support.judges.skin_judge import SkinJudge
from support.postures.furniture import KINDS
from support.postures.postures import build, cases

#: Frames per second and substeps.
STEPS = ((30.0, 1), (30.0, 8), (60.0, 4), (120.0, 1), (120.0, 2))
STIFFNESS = (0.0, 1.0, 10.0)
DRIVES = (None, 0.02)
#: Factors on the written speed.
PACES = (1.0, 3.0)
#: Minimum distance of all skin vertices at the default clearance, sitting and grasping [m].
SEATED = 0.0006


@dataclass(frozen=True)
class Case:
    """A posture among furniture of a kind, with settings; the seed also selects the body."""

    name: str
    kind: str = "primitives"
    fps: float = 30.0
    substeps: int = 8
    stiffness: float = 1.0
    drive: float | None = 0.02
    pace: float = 1.0
    seed: int = 0

    @property
    def who(self) -> str:
        return WHO[self.seed % len(WHO)]

    @property
    def id(self) -> str:
        drive = "alg1" if self.drive is None else f"tau{self.drive:g}"
        return (
            f"posture-{self.name}-{self.kind}-{self.pace:g}x-{self.fps:g}fps-N{self.substeps}-"
            f"l{self.stiffness:g}-{drive}-s{self.seed}"
        )


def posture_cases(seeds=1):
    """All postures, with seeds 0 to `seeds` - 1."""
    return [
        Case(name, kind, fps, n, stiffness, drive, pace, seed)
        for name, kind, (fps, n), stiffness, drive, pace, seed in product(
            cases(), KINDS, STEPS, STIFFNESS, DRIVES, PACES, range(seeds)
        )
    ]


def all_cases(data, seeds=1, kinds=("posture", "throw", "room")):
    """Shuffled; kinds take turns."""
    groups = {
        "posture": lambda: posture_cases(seeds),
        "throw": clear_campaign.throw_cases,
        "room": lambda: clear_campaign.room_cases(data) if data is not None else [],
    }
    ranked = []
    for kind in kinds:
        found = sorted(groups[kind](), key=lambda c: zlib.crc32(c.id.encode()))
        ranked += [(rank, kind, case) for rank, case in enumerate(found)]
    return [case for _, _, case in sorted(ranked, key=lambda r: r[:2])]


def contacts():
    """The values of `Settings.contact` in this build."""
    out = []
    for contact in ("parts", "skin"):
        try:
            Settings(contact=contact)
        except InputError:
            continue
        out.append(contact)
    return tuple(out)


#: Bodies: seeds take turns. Three betas each, synthetic pose blend shapes.
WHO = ("default", *(f"beta{k}{sign}" for k in range(10) for sign in "+-"), "blend")


@cache
def body_of(who="default"):
    """A body of `WHO`, made once."""
    if who.startswith("beta"):
        betas = np.zeros(10)
        betas[int(who[4:-1])] = 3.0 if who.endswith("+") else -3.0
        return Body.default(betas)
    body = Body.default()
    if who == "blend":  # some millimetres at a bent joint
        rng = np.random.default_rng(0)
        blend = 5e-4 * rng.normal(size=(len(body.rest_vertices), 3, 486))
        return replace(body, posedirs=blend)
    return body


def _started_inside(case, settings, pressing, verdict):
    """A row of a case without evidence: the skin is inside at the start, the parts are not."""
    return {
        "id": case.id,
        "group": "posture" if pressing else case.kind,
        "contact": settings.contact,
        "skipped": True,
        "start_mm": _mm(verdict.start),
    }


def _set_up(case, data, body):
    """Motion, scene, and the parts that must press (none: no part must)."""
    if isinstance(case, Case):
        made = build(case.name, body, case.kind, case.fps, case.seed, pace=case.pace)
        return made.motion, made.scene, True
    return *clear_campaign.set_up(case, data), False


def run(case, data=None, contact="skin", body=None, **changes):
    """The numbers of one case; `changes` of `Settings`."""
    body = body_of(getattr(case, "who", "default")) if body is None else body
    motion, scene, pressing = _set_up(case, data, body)
    settings = Settings(
        contact=contact,
        substeps=case.substeps,
        stiffness=case.stiffness,
        drive_time=case.drive,
        record="substeps",
        **{**AS_IT_IS, **changes},
    )
    judge = SkinJudge(body, scene)
    first = judge.judge_motion(motion[:2], poses=1)
    if not first.clear:
        return _started_inside(case, settings, pressing, first)
    begin = time.perf_counter()
    simulator = Simulator(scene, body=body, settings=settings, fps=case.fps)
    simulator.world.stepper.keep_pieces(True)  # the judge sees every committed pose
    made = time.perf_counter() - begin
    simulator.reset(motion[0])
    begin = time.perf_counter()
    frames = [simulator.step(motion[t]) for t in range(1, len(motion))]
    took = time.perf_counter() - begin
    begin = time.perf_counter()
    verdict = judge.judge_frames(simulator, motion[0], frames, least=True)
    closed = getattr(case, "kind", "") != "sheets"
    corrected = motion.with_frames(
        np.array([motion[0].translation, *(f.pose.translation for f in frames)]),
        np.array([motion[0].rotations, *(f.pose.rotations for f in frames)]),
    )
    rate, depth = judge.penetration(corrected) if closed else (0.0, 0.0)
    finite = all(np.isfinite(f.substeps).all() for f in frames)
    own = asdict(case)
    return {
        "id": case.id,
        "group": own.pop("kind") if not pressing else "posture",
        **own,
        "among": case.kind if pressing else "",
        "who": getattr(case, "who", "default"),
        "contact": contact,
        "skipped": False,
        "ok": bool(verdict.clear and finite and verdict.start > 0.0 and rate == depth == 0.0),
        "start_mm": _mm(verdict.start),
        "gap_mm": _mm(verdict.gap),
        "last_mm": _mm(verdict.gaps[-1]),
        "nearest": "/".join(map(str, verdict.nearest)),
        "depth_mm": _mm(verdict.depth),
        "deepest": "/".join(map(str, verdict.deepest)),
        "share": round(100.0 * float(verdict.shares.max()), 4),
        "metric_rate": rate,
        "metric_mm": depth,
        "cut": len(verdict.cut),
        "crossed": len({pose for _, _, pose in verdict.crossed}),
        "first_crossed": list(verdict.crossed[0]) if verdict.crossed else None,
        "coal": len(verdict.coal),
        "swallowed": len(verdict.swallowed),
        "finite": finite,
        "poses": verdict.poses,
        "frames": len(frames),
        "touched": sum(len(f.contacts.part) > 0 for f in frames),
        "lost": sum(f.lost_time for f in frames) * case.fps / len(frames),
        "residual_mm": 1e3 * max(f.diagnostics["residual"] for f in frames),
        "setup_s": round(made, 3),
        "per_second": len(frames) / took,
        "judged_s": round(time.perf_counter() - begin, 2),
    }


def _mm(x):
    return None if np.isinf(x) else 1e3 * float(x)


def first_contact(case, contact="skin", body=None):
    """Distance of the skin [m] at the end of the first frame with a contact; None: no contact."""
    body = body_of(case.who) if body is None else body
    made = build(case.name, body, case.kind, case.fps, case.seed, pace=case.pace)
    settings = Settings(
        contact=contact,
        substeps=case.substeps,
        stiffness=case.stiffness,
        drive_time=case.drive,
        **AS_IT_IS,
    )
    simulator = Simulator(made.scene, body=body, settings=settings, fps=case.fps)
    simulator.reset(made.motion[0])
    for t in range(1, len(made.motion)):
        frame = simulator.step(made.motion[t])
        if len(frame.contacts.part):
            return SkinJudge(body, made.scene, samples=1).surface_distance(frame.pose)
    return None


def complaints(row):
    """Texts for each broken guarantee of a row; none if there is none."""
    out = []
    if row.get("skipped"):
        return [f"starts inside: {row['start_mm']} mm"] if row["group"] == "posture" else []
    if not row["finite"]:
        out.append("not finite")
    if row["depth_mm"] > 1e-6 or row["cut"] or row["coal"]:
        out.append(
            f"the skin is inside: {row['depth_mm']:.3f} mm {row['deepest']}, {row['share']:.2f} %, "
            f"cut at {row['cut']} of {row['poses']} poses, by coal at {row['coal']}"
        )
    if row["crossed"]:
        out.append(f"went through at {row['crossed']} poses, first {row['first_crossed']}")
    if row["swallowed"]:
        out.append("starts around something")
    if row["metric_rate"] > 0.0 or row["metric_mm"] > 0.0:
        out.append(f"metrics.penetration: {row['metric_rate']:.4f} %, {row['metric_mm']:.4f} mm")
    if not row["ok"] and not out:
        out.append("not clear")
    if row["group"] == "posture" and not row["touched"]:
        out.append("nothing was pressed")
    return out


def summary(rows):
    """A table by group, tool or case, kind and settings."""
    groups = {}
    for r in rows:
        if r.get("skipped"):
            continue
        keys = [(r["group"], "all"), (r["group"], f"N {r['substeps']} at {r['fps']:g} fps")]
        drive = "alg1" if r["drive"] is None else "tau"
        keys.append((r["group"], f"{drive} l{r['stiffness']:g}"))
        if r["group"] == "posture":
            keys += [("posture", r["among"]), ("posture", r["name"])]
        else:
            keys += [(r["group"], r["what"]), (r["group"], r["where"])]
        for key in keys:
            groups.setdefault(key, []).append(r)
    lines = [
        f"{'':34s}{'cases':>6s}{'clear':>6s}{'inside':>7s}{'worst mm':>9s}{'median':>8s}"
        f"{'gap mm':>8s}{'lost %':>8s}{'f/s med':>9s}{'p5':>7s}{'judge s':>8s}"
    ]
    for (kind, name), rs in sorted(groups.items()):
        depth = np.array([r["depth_mm"] for r in rs])
        gaps = [r["gap_mm"] for r in rs if r["gap_mm"] is not None]
        speed = np.array([r["per_second"] for r in rs])
        lines.append(
            f"{kind + ' ' + name:34s}{len(rs):6d}{sum(r['ok'] for r in rs):6d}"
            f"{sum(d > 1e-6 for d in depth):7d}{depth.max():9.3f}{np.median(depth):8.3f}"
            f"{min(gaps, default=np.inf):8.3f}{100 * np.mean([r['lost'] for r in rs]):8.3f}"
            f"{np.median(speed):9.0f}{np.percentile(speed, 5):7.0f}"
            f"{np.mean([r['judged_s'] for r in rs]):8.1f}"
        )
    return "\n".join(lines)


#: The campaign of `campaigns.clear`, with this judge.
campaign = partial(clear_campaign.campaign, run=run)


def main():
    options = clear_campaign.options_of(
        __doc__,
        "skin.jsonl",
        seeds={"type": int, "default": 1, "help": "postures with seeds 0 to this"},
        kinds={"default": "posture,throw,room"},
    )
    some = all_cases(options.data, options.seeds, options.kinds.split(","))
    some, rows = clear_campaign.rows_of(options, some, run)
    if not some:
        return
    print(summary(rows))
    clear_campaign.complain(rows, complaints)
    skipped = sum(row["skipped"] for row in rows)
    frames, poses = (sum(row.get(k, 0) for row in rows) for k in ("frames", "poses"))
    print(f"{len(rows)} of {len(some)} cases, {skipped} of them start with the skin inside")
    print(f"{frames} frames, {poses} committed poses")


if __name__ == "__main__":
    main()
