"""Matches the joints of a skeleton to SMPL-X joints by name.

CMU, Mixamo, Rokoko, LAFAN1, MotionBuilder, 3ds Max Biped, Unreal, Blender Rigify, Daz, SMPL and
others differ in prefixes, in how they mark left and right, and in a few words per joint. Names are
split into words, and each SMPL-X joint has the words that name it; if one word names two joints
("LeftShoulder" is the collar in Mixamo and the upper arm in older skeletons), the other names of
the same side decide. What all names have in common is left out where more joints are known then.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from halfphysics.formats.skeletons.shared_affixes import without_affixes
from halfphysics.motion.skeleton import JOINT_INDEX, JOINT_NAMES, N_JOINTS

_PREFIX = re.compile(
    r"^(.*:|mixamorig\d*[_ ]?|bip0*\d+[_ ]*|character\d*_|cc_base_|def[-_]|org[-_]|armature[_|]"
    r"|[fm]_avg_|jnt_|b_|j_bip_(c_)?)",
    re.IGNORECASE,
)
_SUFFIX = re.compile(r"(_jnt|_joint|_bone)$", re.IGNORECASE)
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_SIDES = {"l": "left", "r": "right", "left": "left", "right": "right"}

# Daz Genesis has a limb in two, of which the upper one bends ("lShldrBend"), MakeHuman numbers the
# two, Motive has "LUArm" and "LFArm".
_UPPER_ARM = ("upperarm", "uparm", "uarm", "shldrbend", "upperarm01", "humerus", "arm")
_SHOULDER = ("shoulder", "shldr")
_COLLAR = ("collar", "clavicle", "clav", "shoulderblade", "scapula")
_ELBOW = (
    *("forearm", "lowerarm", "lowarm", "farm", "forearmbend", "lowerarm01"),
    *("elbow", "radius"),
)
_THIGH = ("upleg", "upperleg", "thighbend", "upperleg01", "thigh", "femur")
_HIP = ("hip", "hipjoint")
_SHIN = ("lowerleg", "lowleg", "lowerleg01", "calf", "shin", "knee", "tibia", "leg")
_NECK = ("neck", "lowerneck", "necklower", "neck1", "neck01", "neck0")
_TOE = ("toe", "toebase", "toes", "ball", "toe0")
_FINGERS = {
    "thumb": "thumb",
    "index": "index",
    "point": "index",
    "middle": "middle",
    "mid": "middle",
    "ring": "ring",
    "pinky": "pinky",
    "pinkie": "pinky",
    "little": "pinky",
}
_NUMBERED = ("thumb", "index", "middle", "ring", "pinky")
_PALM = ("metacarpal", "meta", "carpal", "palm", "inhand", "in")
_TIP = ("tip", "end", "nub")


@dataclass(frozen=True)
class Name:
    """A joint's name split into parts: side ("", "left" or "right") and the other words."""

    side: str
    words: tuple[str, ...]

    @property
    def key(self) -> str:
        return "".join(self.words)


def parse(name: str) -> Name:
    """Split a name into words, without prefixes and suffixes."""
    bare = name
    while (match := _PREFIX.match(bare)) and match.end() < len(bare):
        bare = bare[match.end() :]
    bare = _SUFFIX.sub("", bare)
    words = [word.lower() for word in _WORD.findall(bare)]
    # "lThigh", "LHipJoint", "lfemur" and "Lefthand" have no separator after the side, and the side
    # of "LUArm" is in one word with the next letter.
    if "".join(words)[1:] in _IN_ONE:
        words = ["".join(words)]
    if words and words[0] not in _SIDES:
        for side in ("left", "right", "l", "r"):
            rest = words[0].removeprefix(side)
            if rest != words[0] and (len(side) > 1 or rest in _AFTER_SIDE):
                words[:1] = [side, rest]
                break
    sides = [_SIDES[word] for word in words if word in _SIDES]
    kept = tuple(word for word in words if word not in _SIDES)
    return Name(sides[0] if sides else "", kept)


#: Of which the first letter is a word of its own: "UArm".
_IN_ONE = {"uarm", "farm"}
_AFTER_SIDE = {
    *_UPPER_ARM,
    *_SHOULDER,
    *_COLLAR,
    *_ELBOW,
    *_THIGH,
    *_HIP,
    *_SHIN,
    *_TOE,
    *_FINGERS,
    *("hand", "wrist", "foot", "ankle", "fingers"),
}


def match_joints(names: Sequence[str], parents: Sequence[int]) -> dict[int, int]:
    """SMPL-X joint -> joint of the skeleton, for all joints found.

    Pelvis and spine are not included: the pelvis is the joint where the legs meet, and the spine
    goes from there to the joint where the arms meet.

    Args:
        names: Names of the skeleton's joints, parents before children.
        parents: Parent of each joint, -1 for the root.
    """
    if names_of_smplx(names):
        index = {name: i for i, name in enumerate(names)}
        return {j: index[name] for name, j in JOINT_INDEX.items()}
    found, bare = _matched(names, parents), without_affixes(names)
    other = found if bare == list(names) else _matched(bare, parents)
    return other if len(other) > len(found) else found


def _matched(names: Sequence[str], parents: Sequence[int]) -> dict[int, int]:
    """`match_joints` by these very names."""
    taken = [parse(name) for name in names]
    found: dict[int, int] = {}

    def put(target: str, side: str, words: Sequence[str]) -> None:
        """Match `target` by the first word that names a joint of this side, the uppermost one."""
        joint = JOINT_INDEX[f"{side}_{target}" if side else target]
        for word in words:
            for i, name in enumerate(taken):
                if name.side == side and name.key == word and i not in found.values():
                    found[joint] = i
                    return

    put("head", "", ("head",))
    put("neck", "", _NECK)
    put("jaw", "", ("jaw",))
    for side in ("left", "right"):
        keys = {name.key for name in taken if name.side == side}
        upper_arm = any(word in keys for word in _UPPER_ARM)
        elbow = any(word in keys for word in _ELBOW)
        thigh = any(word in keys for word in _THIGH)
        put("shoulder", side, _UPPER_ARM if upper_arm and elbow else (*_SHOULDER, *_UPPER_ARM))
        put("collar", side, (*_COLLAR, *_SHOULDER))
        put("elbow", side, _ELBOW)
        put("wrist", side, ("wrist", "hand"))
        put("hip", side, _THIGH if thigh else (*_HIP, "leg"))
        put("knee", side, _SHIN)
        ankle = "ankle" in keys
        put("ankle", side, ("ankle",) if ankle else ("foot",))
        put("foot", side, (*_TOE, "foot") if ankle else _TOE)
        _put_fingers(found, taken, parents, side)
    return found


def names_of_smplx(names: Sequence[str]) -> bool:
    """Whether a skeleton has all 55 SMPL-X joints under their own names."""
    return len(names) >= N_JOINTS and set(JOINT_NAMES) <= set(names)


def _finger_of(name: Name, biped: bool) -> str | None:
    """The finger of a joint; None: no finger, or a palm bone or a tip."""
    if any(word in _TIP for word in name.words):
        return None
    if name.words and name.words[0] == "finger" and len(name.words) > 1 and name.words[1].isdigit():
        number = int(name.words[1][0]) - (0 if biped else 1)
        finger = _NUMBERED[number] if 0 <= number < len(_NUMBERED) else None
    else:
        bare = [word.removeprefix("hand") for word in name.words]
        finger = next((_FINGERS[word] for word in bare if word in _FINGERS), None)
    # The thumb's metacarpal is the first joint of the SMPL family's thumb.
    if finger != "thumb" and any(word in _PALM for word in name.words):
        return None
    return finger if "toe" not in name.words and "foot" not in name.words else None


def _put_fingers(
    found: dict[int, int], taken: Sequence[Name], parents: Sequence[int], side: str
) -> None:
    """The first three joints of each finger below the wrist."""
    wrist = found.get(JOINT_INDEX[f"{side}_wrist"])
    if wrist is None:
        return
    below = {wrist}
    biped = any(name.words[:2] == ("finger", "0") for name in taken)
    chains: dict[str, list[int]] = {}
    ended: set[str] = set()
    for i, parent in enumerate(parents):
        if parent not in below:
            continue
        below.add(i)
        finger = _finger_of(taken[i], biped)
        if taken[i].words[-1:] == ("end",):
            ended.update(_FINGERS.get(word, "") for word in taken[i].words[-2:-1])
        if finger is None or taken[i].side not in (side, ""):
            continue
        chain = chains.setdefault(finger, [])
        # Each joint is below the one before: a second branch of the finger is skipped.
        if not chain or _is_above(chain[-1], i, parents):
            chain.append(i)
    for finger, chain in chains.items():
        # The palm's bone is a joint numbered 0 that three more follow, or, in SOMA, the first of
        # four that an end without a number follows ("Index1" to "Index4", "IndexEnd"). Mixamo's
        # fourth is the finger's tip, and an end of it has its number ("Index4_end").
        palm = taken[chain[0]].words[-1] in ("0", "00") or finger in ended
        if finger != "thumb" and len(chain) > 3 and palm:
            chain = chain[1:]
        for number, i in enumerate(chain[:3], 1):
            found[JOINT_INDEX[f"{side}_{finger}{number}"]] = i


def _is_above(above: int, joint: int, parents: Sequence[int]) -> bool:
    while joint >= 0:
        joint = parents[joint]
        if joint == above:
            return True
    return False
