"""A sweep file that has every key, and reading one from a text."""

from __future__ import annotations

from pathlib import Path

from halfphysics.sweep import Plan

WHOLE = """\
version: 1
inputs:
  - files: ["clips/**/*.npz"]
    fps: 30
    frames: 0:90
    assets: meshes
    ground: true
  - files: takes/*/
    objects: replayed
bodies: [own, {stature: 1.6}]
scenes: [own, room.yaml]
grounded: true
factors:
  objects.mass: [1, 2.5]
  settings.clearance: {from: 1e-3, to: 0.01, count: 3, scale: log}
  objects.friction: {uniform: [0.2, 1.2]}
  body.betas.0: {normal: [0, 1], within: [-2, 2]}
samples: 4
seed: 7
keep: objects.mass < 2 or scene == 'own'
keep_after: [success, drops == 0]
settings: {stiffness: {left_arm: 0.5}}
labels: {threshold: 0.01, also: [behave]}
outputs: {folder: out, formats: [hdf5, webdataset], variants_per_shard: 100, batch: 16,
  results: true}
"""


def load(folder: Path, text: str, name: str = "plan.yaml") -> Plan:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return Plan.load(path)
