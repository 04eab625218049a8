// What the numbers of a compiled world stand for: names of everything, and where people, objects and joints have
// their coordinates (src/halfphysics/simulation/coordinates.py is the same in Python).
#pragma once
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "assembly/array_view.h"

namespace hp {

constexpr int kJoints = 55;  // of SMPL-X

struct PersonPlace {
  std::string name;
  int root = 0;                         // body
  int qpos = 0;                         // first coordinate
  std::array<int, kJoints> joint_qpos;  // first coordinate of every joint's quaternion
  std::array<int, kJoints> body;        // of every joint
  std::array<int, kJoints> ball;        // which joint is the core's first, second, ... ball
  Vec3 rest_pelvis;                     // in the body's own axes [m]
  Mat3 axes;                            // the world's axes from those that the pose is given in
  Vec3 pelvis;                          // axes times rest_pelvis
  std::array<double, kJoints> stiffness;
};

struct ObjectPlace {
  std::string name;
  int body = 0, qpos = 0, dof = 0;  // qpos < 0: it has no coordinates of its own: it is held
  Vec3 com;                         // in the object's own frame, at which its body is [m]
  Mat3 inertia;                     // about it, in the object's axes [kg m^2]
  bool pushable = false;            // neither held nor on a trajectory
};

struct LinkPlace {
  std::string name;
  int body = 0;
};

struct JointPlace {
  std::string name;
  int qpos = 0, width = 1;
};

struct Labels {
  std::vector<std::string> everything;  // statics, objects, links, people
  std::vector<int> shape_name, shape_part, static_name;
  std::vector<PersonPlace> people;
  std::vector<ObjectPlace> objects;
  std::vector<LinkPlace> links;
  std::vector<JointPlace> joints;
  std::vector<double> start_qpos, start_qvel;  // objects at their start
  int substeps = 0;                  // of a frame; 0: as many as make at most 1/240 s each
  std::vector<double> own_friction;  // per row of material pairs
  std::vector<int> own_pair;         // rows x rows: the pair has a friction of its own

  int first_person() const { return (int)(everything.size() - people.size()); }
  // Index of a name in `everything`, -1: there is none.
  int find(std::string_view name) const;
  // Substeps of a frame of `dt` [s], as Settings.substeps_for.
  int substeps_for(double dt) const;
};

// Vectors turned by unit quaternions, with the operations of halfphysics.base.rotations.rotate.
inline Vec3 turned(Quat q, Vec3 v) {
  const Vec3 u{q.x, q.y, q.z}, t = 2.0 * cross(u, v);
  return v + q.w * t + cross(u, t);
}

}  // namespace hp
