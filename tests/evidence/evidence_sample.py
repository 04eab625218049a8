"""A complete report with made-up numbers and hostile names."""

from __future__ import annotations

import io
import math

import numpy as np
from PIL import Image, ImageDraw

from evidence.document import verdict

HOSTILE = "<script>alert(1)</script> \"&' \x1b[31m\u202egnp.\udcff" + "long_file_name" * 12


def figure(name, unit, paper, ours, expected="", reproduced=None, direction=False):
    return {"name": name, "unit": unit, "paper": paper, "ours": ours, "expected": expected,
            "reproduced": reproduced, "direction": direction}  # fmt: skip


def row(name, figures, data="", setting="", note="", quoted=False):
    return {"name": name, "data": data, "setting": setting, "note": note, "figures": figures,
            "quoted": quoted}  # fmt: skip


def series(name, x, y):
    return {"name": name, "x": list(x), "y": list(y)}


def plot(title, x, y, *lines, kind="lines"):
    return {"title": title, "kind": kind, "x": list(x), "y": list(y), "series": list(lines)}


def section(key, title, about, rows, plots=(), pictures=(), failed=()):
    return {
        "key": key, "title": title, "about": about,
        "command": f"./run evidence --only {key}", "rows": list(rows),
        "plots": list(plots), "pictures": list(pictures), "failed": list(failed),
    }  # fmt: skip


def _table1():
    figures = [
        figure("success", "%", 100, 100.0, "100", True),
        figure("MPJPE-g", "mm", 0.003, 0.00042, "at most 0.003", True),
        figure("MPJPE", "mm", 0.003, 1.3e-10, "at most 0.003", True),
    ]
    tracker = [
        figure("success", "%", 92.5, None),
        figure("MPJPE-g", "mm", 49.192, None),
    ]
    return section(
        "table1",
        "Table 1: fidelity where nothing is in the way",
        "A motion that meets nothing is returned as it was given. The paper follows 40 sequences "
        "of AIST++ and sets a tracker trained by reinforcement learning beside it.\n\n"
        "The tracker is quoted, not run again.",
        [
            row("half-physics", figures, "dance, embedded, 12 clips",
                "Settings.paper(stiffness=0)"),
            row("half-physics", figures, "daily motion, embedded, 8 clips",
                "Settings.paper(stiffness=0)"),
            row("PHC+", tracker, "AIST++ test, 40 sequences", quoted=True,
                note="Seven days of training; its errors are of its successful runs only."),
        ],
        [
            plot("Global error over time, per clip", ("time", "s"), ("MPJPE-g", "mm"),
                 *(series(f"dance-{k:02d}", t := np.linspace(0, 12, 720).tolist(),
                          (3e-4 * (1.2 + np.sin(0.3 * k + np.array(t)))).tolist())
                   for k in range(3))),
        ],
        failed=[{"task": "dance-07/velocity", "cause": "FileError: dance-07.npz: damaged archive"}],
    )  # fmt: skip


def _table2():
    rng = np.random.default_rng(3)
    scenes = [f"room {k:02d}" for k in range(20)]
    before = rng.gamma(3.0, 2.6, 20).round(3).tolist()
    rows = [
        row("motion as it was generated", [
            figure("penetration rate", "%", 7.914, 8.4321, "over 0", True),
            figure("Depth_mean", "mm", 82.10, 77.0123, "over 0", True),
            figure("Depth_max", "mm", 172.19, 181.55, "over 0", True),
            figure("mean of penetrating vertices", "mm", None, 41.2),
        ], "20 furnished rooms from seed 0", "input, not simulated"),
        row("with half-physics", [
            figure("penetration rate", "%", 0.0, 0.0, "0.00", True),
            figure("Depth_mean", "mm", 0.0, 0.0004, "0.00", True),
            figure("Depth_max", "mm", 0.0, 0.0213, "0.00", False),
            figure("verified by an independent library", "mm", None, None),
        ], "20 furnished rooms from seed 0", "Settings.paper(stiffness=1, substeps=8)",
           "One room of twenty: a toe is 0.02 mm inside a chair's leg in one frame."),
        row(HOSTILE, [figure("penetration rate", "%", 7.914, 3.1)], "scenes=" + HOSTILE,
            "Settings(mode='velocity')"),
    ]  # fmt: skip
    return section(
        "table2",
        "Table 2: penetration in furnished rooms",
        "Generated motions walk through furniture; with half-physics nothing is inside anything.",
        rows,
        [
            plot("Penetration rate per room", ("room", ""), ("penetration rate", "%"),
                 series("as generated", scenes, before),
                 series("half-physics", scenes, [0.0] * 19 + [0.0021]), kind="bars"),
        ],
    )  # fmt: skip


def _table3():
    return section(
        "table3",
        "Table 3: joint torques instead of velocities",
        "A PD controller drives the joints, the root keeps its velocity. It loses the motion.",
        [
            row("joint torques (PD)", [
                figure("MPJPE-g", "mm", 83.109, 61.4567, "at least 10 over half-physics", True,
                       True),
                figure("MPJPE", "mm", 82.273, 60.98, "at least 10 over half-physics", True,
                       True),
            ], "dance, embedded, 12 clips",
               "Settings(mode='torque', joint_damping=0.8, stiffness=1.0)"),
        ],
        [
            plot("Error against gain", ("proportional gain", "N m/rad"), ("MPJPE-g", "mm"),
                 series("damping 0.5", (g := [1, 3, 10, 30, 100, 300, 1000, 3000, 10000]),
                        [812.0, 420.0, 190.0, 96.0, 61.0, 44.0, None, 71.0, 240.0]),
                 series("damping 2", g, [901, 512, 260, 130, 88, 70, 66, 80, 140]),
                 series("half-physics", [1, 10000], [0.0004, 0.0004])),
        ],
    )  # fmt: skip


def _table4():
    return section(
        "table4",
        "Table 4: internal forces and damping",
        "Forces that the body exerts on itself, and damping of its joints, throw the motion off.",
        [
            row("internal forces on", [
                figure("MPJPE-g", "mm", 145.524, 133.21, "at least 10", True),
                figure("MPJPE", "mm", 50.848, 4.02, "at least 10", False),
            ], "dance, embedded, 12 clips", "Settings(internal_forces=True)"),
            row("damping and internal forces on", [
                figure("MPJPE-g", "mm", 148.802, None, "at least 10", None),
                figure("MPJPE", "mm", 50.030, None, "at least 10", None),
            ], "dance, embedded, 12 clips", "Settings(internal_forces=True, joint_damping=1.0)",
               "The experiment ended in an error."),
        ],
        [
            plot("What each costs", ("", ""), ("error", "mm"),
                 series("paper", ["velocity to torque", "internal forces", "both with damping"],
                        [83.109, 145.524, 148.802]),
                 series("ours", ["velocity to torque", "internal forces", "both with damping"],
                        [61.457, 133.21, None]), kind="bars"),
        ],
        failed=[{"task": "damped", "cause": "no number: " + HOSTILE}],
    )  # fmt: skip


def _figures():
    t = np.linspace(0, 3, 361)
    ball = np.where(t < 1.1, 0.0, 4.2 * (t - 1.1))
    lam = [0.0, 0.25, 0.5, 0.75, 1.0]
    return [
        section(
            "figure5",
            "Figure 5: objects answer",
            "A grasp, a glass that falls, a suitcase lifted by friction, a ball kicked.",
            [
                row("ball of 0.5 kg", [figure("speed after the kick", "m/s", None, 4.2137,
                    "over 1", True), figure("height", "mm", None, 312.4, "over 100", True)],
                    "scenario kick_ball", "Settings.paper(stiffness=0)"),
                row("ball of 200 kg", [figure("speed after the kick", "m/s", None, 0.0121,
                    "under 0.1", True), figure("bend of the ankle", "°", None, 38.2)],
                    "scenario kick_ball", "Settings.paper(stiffness=0)"),
            ],
            [
                plot("Way of the ball after the kick", ("time", "s"), ("distance", "m"),
                     series("0.5 kg", t.tolist(), ball.tolist()),
                     series("200 kg", t.tolist(), (ball * 0.003).tolist())),
                plot("Speed of the ball by its mass", ("mass of the ball", "kg"), ("speed", "m/s"),
                     series("half-physics", [0.1, 10, 1000], [7.4, 1.2, -0.013]),
                     series("MuJoCo mocap bodies", [0.1, 10, 1000], [5.11, 5.11, 5.09]),
                     kind="bars"),
            ],
            [{"caption": "A kick at a ball of 0.5 kg: every tenth frame", "task": "kick",
              "name": "strip"}],
        ),
        section(
            "figure8",
            "Figure 8: the firmness λ",
            "At λ = 0 the leg bends past the ball; at λ = 1 the whole body gives way.",
            [row("fixed ball", [
                figure("bend of the knee at λ = 0", "°", None, 61.0, "over 30", True),
                figure("shift of the pelvis at λ = 1", "mm", None, 211.0, "over 50", True)])],
            [plot("Bend and shift", ("λ", ""), ("bend of the knee", "°"),
                  series("", lam, [61.0, 40.2, 22.1, 9.0, 2.3]))],
            [{"caption": f"λ = {v}", "task": "kick", "name": f"still-{v}"} for v in (0, 1)]
            + [{"caption": "never drawn", "task": "kick", "name": "none"}],
        ),
    ]  # fmt: skip


def _whole(sections, **more):
    return {
        "title": "Half-Physics: the paper's evidence, reproduced and extended",
        "halfphysics": "0.1.0", "mujoco": "3.3.7", "quick": True, "seed": 0,
        "data": {"scenes": HOSTILE}, "verdict": verdict(sections), "sections": sections, **more,
    }  # fmt: skip


def document():
    """The content of `paper.json`."""
    return _whole([_table1(), _table2(), _table3(), _table4(), *_figures()])


def speed():
    """The content of `paper-speed.json`."""
    figures = [figure("speed", "frames/s", 952.94, 10423.7, "at least 952.94", True),
               figure("plain MuJoCo", "frames/s", None, 4210.0)]  # fmt: skip
    bars = series("", ["half-physics", "MuJoCo, velocities set"], [10423.7, 4210.0])
    rows = [row("half-physics", figures, "dance, embedded", "Settings.paper()")]
    plots = [plot("Speed", ("", ""), ("speed", "frames/s"), bars, kind="bars")]
    sections = [section("speed", "Speed", "How fast a motion comes back.", rows, plots)]
    return _whole(sections, machine={"platform": "an <ordinary> one", "cores": 2, "load": [0.5, 2]})


def png(width, height, frames):
    """A picture of people as boxes on a floor."""
    image = Image.new("RGB", (width, height), (226, 232, 236))
    draw = ImageDraw.Draw(image)
    draw.rectangle([0, height * 0.8, width, height], fill=(190, 196, 190))
    for k in range(frames):
        x = width * (k + 0.5) / frames
        top = height * (0.3 + 0.05 * math.sin(k))
        draw.rectangle([x - 12, top, x + 12, height * 0.86], fill=(70, 104, 140))
        draw.ellipse([x - 14, top - 32, x + 14, top - 4], fill=(70, 104, 140))
    data = io.BytesIO()
    image.save(data, "PNG")
    return data.getvalue()


def pictures(section, task, name):
    """The pictures of the sample; one is missing."""
    if name == "none":
        return None
    return png(1500, 300, 8) if name == "strip" else png(640, 480, 1)
