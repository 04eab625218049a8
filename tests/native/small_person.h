// A person of four bodies, made from plain arrays as a C++ caller would: a free pelvis, a
// chest and a leg of two bones on ball joints, each in a capsule, over the floor z = 0.
#pragma once
#include <vector>

#include "stepping/stepper.h"

namespace small_person {

constexpr int bodies = 4;  // without the world
constexpr int numbers =
    7 + 3 * 4;                   // length of a pose: root position and quaternion, then ball joints
constexpr double radius = 0.07;  // radius of all capsules [m]

enum Name { floor_name, person_name, names };

struct Bone {
  int parent;
  hp::Vec3 offset;  // position of its joint in the parent's frame [m]
  hp::Vec3 end;     // the capsule goes from the joint to here; own frame [m]
  double mass;      // [kg]
};

inline std::vector<Bone> bones() {
  return {{0, {0, 0, 0}, {0, 0.15, 0}, 12},
          {1, {0, 0, 0.2}, {0, 0, 0.35}, 30},
          {1, {0, 0.05, -0.1}, {0, 0, -0.35}, 9},
          {3, {0, 0, -0.4}, {0, 0, -0.35}, 4}};
}

inline hp::Model model() {
  hp::Model m;
  m.nbody = bodies + 1, m.njnt = bodies, m.nq = numbers, m.nv = 6 + 3 * 3;
  auto add = [&](int parent, int jnt_count, int dof_count, const Bone* bone) {
    m.parent.push_back(parent);
    m.jnt_first.push_back((int)m.jnt_type.size()), m.jnt_count.push_back(jnt_count);
    m.dof_first.push_back((int)m.armature.size()), m.dof_count.push_back(dof_count);
    m.pos.push_back(bone ? bone->offset : hp::Vec3{});
    m.quat.push_back({}), m.iquat.push_back({});
    m.ipos.push_back(bone ? 0.5 * bone->end : hp::Vec3{});
    m.mass.push_back(bone ? bone->mass : 0);
    const double inertia = bone ? 0.01 * bone->mass : 0;
    m.inertia.push_back({inertia, inertia, 0.5 * inertia});
  };
  add(0, 0, 0, nullptr);
  for (const Bone& bone : bones()) {
    const bool root = bone.parent == 0;
    add(bone.parent, 1, root ? 6 : 3, &bone);
    m.jnt_body.push_back((int)m.parent.size() - 1);
    m.jnt_type.push_back(root ? hp::Joint::Free : hp::Joint::Ball);
    m.jnt_qpos.push_back((int)m.qpos0.size()), m.jnt_dof.push_back((int)m.armature.size());
    m.jnt_pos.push_back({}), m.jnt_axis.push_back({0, 0, 1});
    if (root) m.qpos0.insert(m.qpos0.end(), {0, 0, 1});
    m.qpos0.insert(m.qpos0.end(), {1, 0, 0, 0});
    m.armature.insert(m.armature.end(), root ? 6 : 3, 0.0);
  }
  return m;
}

inline void add_shapes(hp::World& world) {
  int body = 0;
  for (const Bone& bone : bones()) {
    hp::CollisionShape shape;
    shape.body = ++body, shape.name = person_name, shape.person = 0, shape.part = body - 1;
    shape.hull.vertices = {{0, 0, 0}, bone.end};
    shape.hull.radius = radius;
    shape.hull.finish();
    world.shapes.push_back(shape);
  }
  hp::Static floor;
  floor.kind = hp::Static::Kind::HalfSpace;
  floor.name = floor_name;
  floor.n = {0, 0, 1};
  world.statics.push_back(floor);
  world.n_names = names;
  world.pairings.assign(names * names, hp::Pairing{0.8, 0, false});
}

// With the time constant of the default settings [s], or 0: Algorithm 1.
inline void build(hp::Stepper& s, double time_constant) {
  s.system.model = model();
  add_shapes(s.system.world);
  s.system.drive_settings.time_constant = time_constant;
  s.finish({1});
}

// A pose of a bowing and kicking person, `height` over the floor and `time` [s] into the motion.
inline std::vector<double> pose(double time, double height) {
  std::vector<double> q = {0.3 * time, 0.1 * std::sin(3 * time), height};
  const hp::Vec3 turns[bodies] = {{0.2 * std::sin(2 * time), 0.1 * time, 0.3 * time},
                                  {0.4 * std::sin(5 * time), 0.1, 0},
                                  {0.9 * std::sin(4 * time), 0, 0.2},
                                  {0.5 - 0.5 * std::cos(4 * time), 0, 0}};
  for (hp::Vec3 r : turns) {
    const hp::Quat turn = hp::exp_quat(r);
    q.insert(q.end(), {turn.w, turn.x, turn.y, turn.z});
  }
  return q;
}

// The lowest point of all capsules at a pose [m], by the chain of joints alone.
inline double lowest(const double* q) {
  std::vector<hp::Vec3> at(bodies + 1);
  std::vector<hp::Quat> turn(bodies + 1);
  double least = 1e300;
  int b = 0;
  for (const Bone& bone : bones()) {
    const hp::Quat own = hp::load4(q + 3 + 4 * b);
    const int p = bone.parent;
    b++;
    at[b] = p == 0 ? hp::load3(q) : at[p] + hp::to_matrix(turn[p]) * bone.offset;
    turn[b] = hp::normalized(p == 0 ? own : turn[p] * own);
    const hp::Vec3 end = at[b] + hp::to_matrix(turn[b]) * bone.end;
    least = std::min({least, at[b].z - radius, end.z - radius});
  }
  return least;
}

}  // namespace small_person
