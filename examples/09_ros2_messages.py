"""A result as ROS 2 messages, without ROS: tf2, sensor and visualization_msgs as CDR bytes.

    python examples/09_ros2_messages.py out/demo/result.npz out/ros2

writes one file a message and frame, such as `tf_000000.cdr`. A node publishes them as they are:

    publisher = node.create_publisher(TFMessage, "/tf", 10)
    publisher.publish(data)        # rclpy takes serialized bytes

ROS's axes (REP 103) are ours: metres, z up, right-handed; its quaternions are x, y, z, w.
"""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import numpy as np

import halfphysics as hp

WORLD = "world"


class Cdr:
    """Writes plain CDR, little-endian: each number at a multiple of its size behind the header."""

    def __init__(self):
        self.data = bytearray()

    def put(self, layout, *values):
        """Numbers of one type, such as "d"."""
        size = struct.calcsize(layout)
        for value in values:
            self.data += bytes(-len(self.data) % size) + struct.pack(f"<{layout}", value)

    def text(self, text):
        """A string with its length, which counts the zero at its end."""
        data = text.encode() + b"\0"
        self.put("I", len(data))
        self.data += data

    def sequence(self, layout, values):
        """Numbers with their count."""
        self.put("I", len(values))
        self.put(layout, *values)

    def header(self, seconds, frame):
        """std_msgs/Header."""
        whole, rest = divmod(round(seconds * 1e9), 10**9)
        self.put("i", whole)
        self.put("I", rest)
        self.text(frame)

    def bytes(self):
        return b"\0\1\0\0" + bytes(self.data)


def tf_message(seconds, frames):
    """tf2_msgs/TFMessage of (child, position (3,), quaternion w, x, y, z) in the world."""
    cdr = Cdr()
    cdr.put("I", len(frames))
    for child, position, (w, x, y, z) in frames:
        cdr.header(seconds, WORLD)
        cdr.text(child)
        cdr.put("d", *position, x, y, z, w)
    return cdr.bytes()


def joint_state(seconds, values):
    """sensor_msgs/JointState of name -> angle [rad] or place [m], such as of doors and drawers."""
    cdr = Cdr()
    cdr.header(seconds, "")
    cdr.put("I", len(values))
    for name in values:
        cdr.text(name)
    cdr.sequence("d", list(values.values()))
    cdr.sequence("d", [])
    cdr.sequence("d", [])
    return cdr.bytes()


def marker_array(seconds, name, points, color=(0.4, 0.6, 0.9, 1.0), radius=0.03):
    """visualization_msgs/MarkerArray with one SPHERE_LIST: a person's joints, contacts."""
    sphere_list, add = 7, 0
    cdr = Cdr()
    cdr.put("I", 1)
    cdr.header(seconds, WORLD)
    cdr.text(name)
    cdr.put("i", 0, sphere_list, add)
    cdr.put("d", 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)  # pose
    cdr.put("d", 2 * radius, 2 * radius, 2 * radius)  # scale
    cdr.put("f", *color)
    cdr.put("i", 0)  # lifetime: until the next one
    cdr.put("I", 0)
    cdr.put("B", 0)  # frame_locked
    cdr.put("I", len(points))
    for point in points:
        cdr.put("d", *point)
    cdr.put("I", 0)  # colors
    cdr.text("")  # texture_resource
    cdr.header(0.0, "")  # texture: sensor_msgs/CompressedImage
    cdr.text("")
    cdr.put("I", 0)
    cdr.put("I", 0)  # uv_coordinates
    cdr.text("")  # text
    cdr.text("")  # mesh_resource
    cdr.text("")  # mesh_file: its name and data
    cdr.put("I", 0)
    cdr.put("B", 0)  # mesh_use_embedded_materials
    return cdr.bytes()


def messages(result, k):
    """Topic -> bytes of frame k of a result."""
    seconds = k / result.motion.fps
    frames, markers = [], {}
    for person in result.people:
        positions, quaternions = person.body.joint_frames(person.motion[k])
        rows = zip(hp.JOINT_NAMES, positions, quaternions, strict=True)
        frames += [(f"{person.name}/{joint}", p, q) for joint, p, q in rows]
        markers[person.name] = marker_array(seconds, person.name, positions)
    for name, track in result.objects.items():
        frames.append((name, track.position[k], track.quaternion[k]))
    angles = {name: float(np.ravel(values[k])[0]) for name, values in result.joints.items()}
    topics = {"tf": tf_message(seconds, frames), "joint_states": joint_state(seconds, angles)}
    return topics | {f"markers_{name}": data for name, data in markers.items()}


def main(path, folder):
    """Write the messages of every frame of a result; returns how many."""
    result = hp.Result.load(path)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for k in range(len(result.motion)):
        for topic, data in messages(result, k).items():
            (folder / f"{topic}_{k:06d}.cdr").write_bytes(data)
            count += 1
    print(f"{count} messages in {folder}")
    return count


if __name__ == "__main__":
    main(*sys.argv[1:])
