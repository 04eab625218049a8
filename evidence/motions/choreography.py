"""Dances made from a seed: figures on the beat, in ten styles.

Nothing comes from a data set. The tempo, the amplitude and the figures of a clip are drawn from its
seed and number; the same seed and number give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from evidence.motions.dancer import SIDES, Score, danced

if TYPE_CHECKING:
    from halfphysics.body.body import Body
    from halfphysics.motion.motion import Motion

#: Clips, frames per second and seconds of a clip: about those of the AIST++ test set.
CLIPS, FPS, SECONDS = 40, 60.0, 8.0

#: A figure writes itself into a score from a time [s] on, and returns its number of beats.
Figure = Callable[[Score, np.random.Generator, float, float], float]


def _arms(score: Score, rng: np.random.Generator, at: float, seconds: float, size: float) -> None:
    """Both arms to anywhere, as one mirror image or each to its own."""
    mirrored = rng.random() < 0.5
    pose: dict[str, float] = {}
    for side in SIDES:
        if not (mirrored and pose):
            pose = {
                "ahead": rng.uniform(-20.0, 110.0),
                "down": 20.0 + size * rng.uniform(-95.0, 55.0),
                "turned": rng.uniform(-45.0, 45.0),
                "elbow": rng.uniform(5.0, 120.0),
                "forearm": rng.uniform(-60.0, 60.0),
                "wrist": rng.uniform(-40.0, 40.0),
                "curl": rng.choice([5.0, 20.0, 70.0]),
            }
        score.to(at, seconds, **{f"{side}_{name}": value for name, value in pose.items()})


def _stand(score: Score, at: float, seconds: float, knee: float = 20.0) -> None:
    """Back onto both feet, upright."""
    score.both(at, seconds, hip=0.55 * knee, knee=knee, open=6.0, out=8.0, point=0.0)
    score.to(at, seconds, lean=3.0, roll=0.0, air=0.0)


def _sides(rng: np.random.Generator) -> tuple[str, str, float]:
    """A side, the other one, and 1 if the first is the left one."""
    return ("left", "right", 1.0) if rng.random() < 0.5 else ("right", "left", -1.0)


def groove(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """Four beats from foot to foot, arms swinging against them."""
    beat = score.beat
    swing, lift = size * rng.uniform(35.0, 60.0), size * rng.uniform(15.0, 40.0)
    side, other, left = _sides(rng)
    _stand(score, at, 0.5 * beat)
    score.to(at, beat, bounce=size * rng.uniform(4.0, 11.0))
    for k in range(4):
        t = at + k * beat
        sign = left if k % 2 == 0 else -left
        score.to(t, 0.8 * beat, roll=5.0 * sign, side=-12.0 * size * sign, twist=swing * 0.4 * sign)
        score.to(t, 0.7 * beat, nod=rng.uniform(-5.0, 18.0), look=rng.uniform(-25.0, 25.0))
        front, back = (side, other) if k % 2 == 0 else (other, side)
        score.to(t, 0.8 * beat, **{f"{front}_ahead": 85.0, f"{front}_down": 70.0 - swing})
        score.to(t, 0.8 * beat, **{f"{front}_elbow": 50.0 + swing, f"{back}_elbow": 35.0})
        score.to(t, 0.8 * beat, **{f"{back}_ahead": -15.0, f"{back}_down": 72.0 - 0.4 * swing})
        # The free foot steps: up in the first half of the beat, down in the second.
        score.to(t, 0.45 * beat, **{f"{back}_hip": 12.0 + lift, f"{back}_knee": 25.0 + 1.6 * lift})
        step = {f"{back}_hip": 12.0, f"{back}_knee": 20.0, f"{back}_open": rng.uniform(2.0, 18.0)}
        score.to(t + 0.5 * beat, 0.45 * beat, **step)
    return 4.0


def wave(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """A wave that runs from one hand through the chest into the other, and back."""
    beat, (side, other, left) = score.beat, _sides(rng)
    score.both(at, 0.6 * beat, ahead=25.0, down=5.0, elbow=15.0, wrist=0.0, turned=0.0, curl=5.0)
    lag, up = beat / 5.0, beat / 3.0
    links = [
        (f"{side}_wrist", 45.0), (f"{side}_elbow", 70.0), (f"{side}_down", -45.0),
        (f"{side}_shrug", 18.0), ("side", 18.0 * left), (f"{other}_shrug", 18.0),
        (f"{other}_down", -45.0), (f"{other}_elbow", 70.0), (f"{other}_wrist", 45.0),
    ]  # fmt: skip
    for k, (name, peak) in enumerate(links + links[::-1]):
        t = at + 0.6 * beat + k * lag
        rest = 12.0 if name.endswith(("elbow", "down")) else 0.0
        score.to(t, up, **{name: size * peak})
        score.to(t + up, up, **{name: rest})
    for k in range(5):
        t, (free, still) = at + k * beat, (side, other) if k % 2 == 0 else (other, side)
        # A slow step to the side on every beat, the standing knee giving.
        away = {"hip": 30.0, "knee": 48.0, "open": size * 26.0}
        score.to(t, 0.5 * beat, **{f"{free}_{name}": value for name, value in away.items()})
        score.to(t + 0.5 * beat, 0.45 * beat, **{f"{free}_hip": 9.0, f"{free}_knee": 16.0})
        score.to(t, 0.9 * beat, **{f"{still}_hip": 15.0, f"{still}_knee": 27.0, f"{still}_open": 2})
        score.to(t, 0.9 * beat, look=25.0 * left * (1.0 - k / 2.0))
    return 5.0


def hit(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """Poses struck within a quarter of a beat and held."""
    beats = int(rng.integers(3, 6))
    for k in range(beats):
        t, snap = at + k * score.beat, rng.uniform(0.3, 0.5) * score.beat
        _arms(score, rng, t, snap, size)
        score.to(t, snap, twist=rng.uniform(-30.0, 30.0), side=rng.uniform(-18.0, 18.0))
        score.to(t, snap, bend=rng.uniform(-10.0, 25.0), look=rng.uniform(-45.0, 45.0))
        for side in SIDES:
            knee = rng.uniform(10.0, 55.0)
            leg = {"hip": 0.55 * knee, "knee": knee, "open": rng.uniform(0.0, 22.0)}
            score.to(t, snap, **{f"{side}_{name}": value for name, value in leg.items()})
    return float(beats)


def kick(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """One leg thrown up, straight ahead or to the side, the arms against it."""
    beat, (side, other, left) = score.beat, _sides(rng)
    high, aside = size * rng.uniform(70.0, 100.0), rng.uniform(0.0, 40.0)
    score.to(at, 0.9 * beat, **{f"{other}_hip": 14.0, f"{other}_knee": 24.0, f"{side}_hip": -15.0})
    score.to(at, 0.9 * beat, **{f"{side}_knee": 60.0, f"{side}_open": 5.0, "lean": 8.0})
    score.to(at + 0.9 * beat, 0.7 * beat, **{f"{side}_hip": high, f"{side}_open": aside})
    score.to(at + 1.0 * beat, 0.6 * beat, **{f"{side}_knee": 8.0, f"{side}_point": 30.0})
    score.to(at + 0.9 * beat, 0.7 * beat, lean=-14.0, bend=15.0, twist=20.0 * left)
    score.to(at + 0.9 * beat, 0.7 * beat, **{f"{other}_ahead": 90.0, f"{other}_down": 0.0})
    score.to(at + 0.9 * beat, 0.7 * beat, **{f"{side}_ahead": -20.0, f"{side}_down": 15.0})
    score.to(at + 1.7 * beat, 0.9 * beat, twist=0.0, bend=4.0)
    _stand(score, at + 1.7 * beat, 0.9 * beat)
    return 3.0


def spin(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """A whole turn, or two, on one foot, arms thrown out and drawn in."""
    beat, (side, other, left) = score.beat, _sides(rng)
    turns = 2.0 if size > 0.85 and rng.random() < 0.5 else 1.0
    lasts = max(1.6 * beat, 1.15 * turns)
    score.to(at, 0.9 * beat, twist=-25.0 * left, bounce=0.0)
    score.both(at, 0.9 * beat, ahead=15.0, down=0.0, elbow=10.0, hip=20.0, knee=38.0)
    spun = at + 0.8 * beat
    score.to(spun, lasts, turn=score["turn"] + 360.0 * turns * left)
    score.to(spun, 0.5 * lasts, twist=10.0 * left)
    score.both(spun, 0.45 * lasts, ahead=75.0, down=35.0, elbow=115.0, curl=50.0)
    score.to(spun, 0.4 * lasts, **{f"{side}_hip": 55.0, f"{side}_knee": 95.0, f"{side}_out": 35.0})
    score.to(spun, 0.4 * lasts, **{f"{other}_hip": 6.0, f"{other}_knee": 10.0})
    score.both(spun + 0.7 * lasts, 0.3 * lasts, ahead=10.0, down=15.0, elbow=15.0)
    score.to(spun + 0.7 * lasts, 0.3 * lasts, twist=0.0)
    _stand(score, spun + 0.75 * lasts, 0.4 * lasts, 30.0)
    return 0.8 + lasts / beat + 0.4


def jump(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """Down, up with the legs tucked or apart, down again."""
    beat, crouch = score.beat, 0.5
    score.both(at, crouch, hip=55.0, knee=80.0, ahead=-25.0, down=60.0, elbow=15.0, open=8.0)
    score.to(at, crouch, lean=22.0, bend=15.0)
    off, high = at + crouch, size * rng.uniform(0.22, 0.36)
    score.both(off - 0.05, 0.22, hip=4.0, knee=8.0, ahead=80.0, down=-50.0, elbow=15.0)
    score.to(off - 0.05, 0.25, lean=0.0, bend=-5.0)
    score.to(off + 0.05, 0.27, air=high)
    score.to(off + 0.32, 0.27, air=0.0)
    if rng.random() < 0.5:
        score.both(off + 0.17, 0.17, hip=50.0, knee=60.0, point=25.0)
    else:
        score.both(off + 0.17, 0.17, hip=15.0, knee=8.0, open=42.0, point=30.0)
    score.both(off + 0.38, 0.2, hip=14.0, knee=26.0, open=10.0, point=10.0)
    if rng.random() < 0.4:
        score.to(off, 0.65, turn=score["turn"] + 180.0 * rng.choice([-1.0, 1.0]))
    score.both(off + 0.58, 0.25, hip=42.0, knee=66.0, point=0.0)
    score.both(off + 0.5, 0.5, down=40.0, ahead=40.0, elbow=40.0)
    score.to(off + 0.58, 0.25, lean=14.0)
    _stand(score, off + 0.85, 0.5)
    return (crouch + 1.35) / beat


def floor(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """Down on the haunches and the hands, legs sweeping out in turn, and up again."""
    beat, (side, other, left) = score.beat, _sides(rng)
    score.both(at, 1.5 * beat, hip=98.0, knee=118.0, open=16.0, out=20.0)
    score.both(at, 1.5 * beat, ahead=70.0, down=55.0, elbow=20.0, wrist=-30.0, curl=5.0)
    score.to(at, 1.5 * beat, lean=38.0, bend=40.0, nod=-20.0, bounce=0.0)
    t, step = at + 1.5 * beat, max(beat, 0.5)
    for k in range(4):
        out, held = (side, other) if k % 2 == 0 else (other, side)
        score.to(t, 0.8 * step, **{f"{out}_knee": 12.0, f"{out}_open": size * 50.0})
        score.to(t, 0.8 * step, **{f"{out}_hip": rng.uniform(45.0, 75.0)})
        score.to(t, 0.8 * step, **{f"{held}_hip": 98.0, f"{held}_knee": 118.0, f"{held}_open": 14})
        score.to(t, step, turn=score["turn"] + size * rng.uniform(40.0, 90.0) * left)
        score.to(t, 0.8 * step, **{f"{held}_down": -10.0, f"{held}_ahead": 10.0})
        score.to(t, 0.8 * step, **{f"{out}_down": 60.0, f"{out}_ahead": 75.0})
        score.to(t, 0.8 * step, twist=28.0 * left * (-1.0) ** k, side=12.0 * left * (-1.0) ** k)
        t += step
    score.both(t, step, hip=98.0, knee=118.0, open=14.0, down=50.0, ahead=70.0)
    score.to(t, step, twist=0.0, side=0.0)
    _stand(score, t + step, 1.4 * beat, 24.0)
    score.to(t + step, 1.4 * beat, bend=5.0, nod=0.0)
    score.both(t + step, 1.4 * beat, wrist=0.0, down=60.0, ahead=20.0, elbow=35.0)
    return 3.1 + 5.0 * step / beat


def footwork(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """Knees up in turn on every half beat, heels and toes, a little around."""
    beat, (side, other, left) = score.beat, _sides(rng)
    half = max(0.5 * beat, 0.26)
    _arms(score, rng, at, beat, 0.7 * size)
    for k in range(8):
        t = at + k * half
        up, down = (side, other) if k % 2 == 0 else (other, side)
        knee = size * rng.uniform(55.0, 95.0)
        lifted = {"hip": 0.75 * knee, "knee": knee, "out": rng.uniform(-15.0, 35.0), "point": 25.0}
        score.to(t, 0.9 * half, **{f"{up}_{name}": value for name, value in lifted.items()})
        score.to(t, 0.9 * half, **{f"{down}_hip": 9.0, f"{down}_knee": 16.0, f"{down}_point": 0.0})
        score.to(t, 0.9 * half, **{f"{down}_open": rng.uniform(-4.0, 16.0), f"{down}_out": 8.0})
        score.to(t, 0.9 * half, twist=18.0 * size * (-1.0) ** k, lean=rng.uniform(0.0, 12.0))
        for arm, sign in ((up, 1.0), (down, -1.0)):
            score.to(t, 0.9 * half, **{f"{arm}_elbow": 70.0 - 35.0 * sign * size})
            score.to(t, 0.9 * half, **{f"{arm}_down": 45.0 + 25.0 * sign * size})
    score.to(at, 8.0 * half, turn=score["turn"] + rng.uniform(30.0, 120.0) * left)
    _stand(score, at + 8.0 * half, 0.6 * beat)
    return 8.0 * half / beat + 0.6


def lunge(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """A wide step into one knee, both arms sweeping overhead, and out of it."""
    beat, (side, other, left) = score.beat, _sides(rng)
    deep = size * rng.uniform(55.0, 80.0)
    front = {"hip": deep, "knee": 1.05 * deep, "open": rng.uniform(5.0, 30.0), "out": 20.0}
    score.to(at, 1.2 * beat, **{f"{side}_{name}": value for name, value in front.items()})
    back = {"hip": -18.0, "knee": 22.0, "open": 18.0, "point": 20.0}
    score.to(at, 1.2 * beat, **{f"{other}_{name}": value for name, value in back.items()})
    score.both(at, 0.6 * beat, ahead=20.0, down=10.0, elbow=10.0)
    score.both(at + 0.6 * beat, 0.6 * beat, ahead=40.0, down=-75.0)
    score.to(at, 1.2 * beat, lean=12.0, bend=-18.0, twist=30.0 * left, nod=-15.0)
    score.to(at + 1.3 * beat, 0.9 * beat, twist=-30.0 * left, bend=20.0, side=18.0 * left)
    score.both(at + 1.3 * beat, 0.9 * beat, ahead=95.0, down=20.0, elbow=30.0)
    score.to(at + 2.3 * beat, 0.9 * beat, twist=0.0, bend=4.0, side=0.0, nod=0.0)
    _stand(score, at + 2.3 * beat, 0.9 * beat)
    return 3.3


def swing(score: Score, rng: np.random.Generator, at: float, size: float) -> float:
    """Arms whirling up and around the head, one after the other, hips and chest against them."""
    beat, (side, other, left) = score.beat, _sides(rng)
    for k in range(6):
        t = at + 0.5 * k * beat
        lead, rest = (side, other) if k % 2 == 0 else (other, side)
        lasts = 0.5 * beat
        high = {"down": -70.0 * size, "ahead": rng.uniform(0.0, 40.0), "elbow": 25.0}
        score.to(t, lasts, **{f"{lead}_{name}": value for name, value in high.items()})
        low = {"down": 55.0, "ahead": rng.uniform(50.0, 100.0), "elbow": rng.uniform(60.0, 120.0)}
        score.to(t, lasts, **{f"{rest}_{name}": value for name, value in low.items()})
        score.to(t, lasts, **{f"{lead}_forearm": -50.0, f"{rest}_forearm": 50.0})
        sign = left * (-1.0) ** k
        score.to(t, lasts, side=16.0 * size * sign, roll=-7.0 * sign, twist=22.0 * size * sign)
        bent = 18.0 + 26.0 * size
        score.to(t, lasts, **{f"{lead}_knee": bent, f"{lead}_hip": 0.55 * bent})
        score.to(t, lasts, **{f"{rest}_knee": 16.0, f"{rest}_hip": 9.0})
    return 3.0


#: Style -> its figures (a figure that is listed twice is drawn twice as often), and its tempo
#: [beats/minute].
STYLES: dict[str, tuple[tuple[Figure, ...], tuple[float, float]]] = {
    "groove": ((groove, groove, hit, footwork), (88.0, 108.0)),
    "waves": ((wave, wave, hit, groove), (84.0, 104.0)),
    "locking": ((hit, hit, kick, groove), (100.0, 120.0)),
    "whirling": ((swing, swing, spin, hit), (104.0, 126.0)),
    "kicks": ((kick, kick, lunge, spin), (96.0, 120.0)),
    "spins": ((spin, spin, swing, lunge), (90.0, 112.0)),
    "jumps": ((jump, jump, groove, kick), (96.0, 120.0)),
    "floor": ((floor, footwork, floor, hit), (96.0, 118.0)),
    "house": ((footwork, footwork, groove, swing), (112.0, 130.0)),
    "jazz": ((lunge, kick, spin, jump, swing), (92.0, 124.0)),
}


def style_of(number: int) -> str:
    """The style of a clip: all of them in turn."""
    return tuple(STYLES)[number % len(STYLES)]


def dance(
    number: int,
    *,
    seed: int = 0,
    seconds: float = SECONDS,
    fps: float = FPS,
    body: Body | None = None,
) -> Motion:
    """Dance clip `number` of a seed, on a floor at z = 0.

    Args:
        number: Number of the clip, from 0.
        seed: Seed of all clips.
        seconds: Duration [s]; a shorter clip is the beginning of a longer one.
        fps: Frames per second.
        body: The body of the dancer; None: the default body.
    """
    if body is None:
        from halfphysics.body.body import Body

        body = Body.default()
    figures, (slow, fast) = STYLES[style_of(number)]
    rng = np.random.default_rng([seed, number])
    score = Score(60.0 / rng.uniform(slow, fast))
    size, heading = rng.uniform(0.85, 1.0), rng.uniform(-np.pi, np.pi)
    # The figure of the style comes first, so that the shortest clip has it.
    at = 0.1 + figures[0](score, rng, 0.1, size) * score.beat
    while at < seconds:
        figure = figures[int(rng.integers(len(figures)))]
        at += figure(score, rng, at, size) * score.beat
    return danced(body, score, seconds, fps, heading)
