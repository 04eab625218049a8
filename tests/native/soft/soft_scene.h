// Scenes of free objects over one soft layer, made from plain arrays as a C++ caller would.
#pragma once
#include <cmath>
#include <vector>

#include "assembly/soft_calls.h"
#include "stepping/stepper.h"

namespace soft_scene {

using hp::Vec3;

constexpr double gravity = 9.81;  // [m/s^2]

struct Layer {
  double thickness = 0.1;  // [m]
  double stiffness = 2e5;  // [Pa/m]
  double damping = 0;      // [Pa s/m]
  double densification = 0;
  double arm = 0, relaxation = 1;
  double friction = 0.8;
};

// A free body with one convex shape and samples on its surface.
struct Thing {
  double mass = 10;
  Vec3 inertia{0.1, 0.1, 0.1};  // [kg m^2]
  std::vector<Vec3> vertices;
  double radius = 0;  // rounding [m]
  double rim = 0;     // radius of a disc across x [m]
  std::vector<Vec3> points, normals;
  std::vector<double> areas;
  Vec3 position, velocity;
  hp::Quat turn{1, 0, 0, 0};
  double thickness = 0;  // of its own layer [m]
  double stiffness = 0, damping = 0;
};

// A box of these edges, `n` samples along each of those of its lower and upper faces.
inline Thing box(Vec3 size, double mass, int n) {
  Thing t;
  t.mass = mass;
  const Vec3 h = 0.5 * size;
  for (int k = 0; k < 8; k++)
    t.vertices.push_back({k & 1 ? h.x : -h.x, k & 2 ? h.y : -h.y, k & 4 ? h.z : -h.z});
  for (int face : {-1, 1})
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) {
        t.points.push_back(
            {size.x * ((i + 0.5) / n - 0.5), size.y * ((j + 0.5) / n - 0.5), face * h.z});
        t.normals.push_back({0, 0, (double)face});
        t.areas.push_back(size.x * size.y / (n * n));
      }
  t.inertia = {mass / 12 * (size.y * size.y + size.z * size.z),
               mass / 12 * (size.x * size.x + size.z * size.z),
               mass / 12 * (size.x * size.x + size.y * size.y)};
  return t;
}

// A ball with `n` samples of equal area on a spiral.
inline Thing ball(double radius, double mass, int n) {
  Thing t;
  t.mass = mass, t.radius = radius, t.vertices = {{0, 0, 0}};
  for (int i = 0; i < n; i++) {
    const double z = 1 - (2 * i + 1.0) / n, r = std::sqrt(1 - z * z), turn = 2.399963229728653 * i;
    const Vec3 normal{r * std::cos(turn), r * std::sin(turn), z};
    t.points.push_back(radius * normal);
    t.normals.push_back(normal);
    t.areas.push_back(4 * M_PI * radius * radius / n);
  }
  const double I = 0.4 * mass * radius * radius;
  t.inertia = {I, I, I};
  return t;
}

// A cylinder along y, lying; `around` samples by `along` on its side.
inline Thing roll(double radius, double length, double mass, int around, int along) {
  Thing t;
  t.mass = mass;
  t.rim = radius;
  t.vertices = {{0, -0.5 * length, 0}, {0, 0.5 * length, 0}};
  for (int i = 0; i < around; i++)
    for (int j = 0; j < along; j++) {
      const double a = 2 * M_PI * (i + 0.5) / around;
      const Vec3 normal{std::cos(a), 0, std::sin(a)};
      t.normals.push_back(normal);
      t.points.push_back(radius * normal + Vec3{0, length * ((j + 0.5) / along - 0.5), 0});
      t.areas.push_back(2 * M_PI * radius * length / (around * along));
    }
  const double across = mass * (3 * radius * radius + length * length) / 12;
  t.inertia = {across, 0.5 * mass * radius * radius, across};
  return t;
}

inline hp::Model model(const std::vector<Thing>& things) {
  hp::Model m;
  m.nbody = (int)things.size() + 1, m.njnt = (int)things.size();
  m.nq = 7 * m.njnt, m.nv = 6 * m.njnt;
  m.armature.assign(m.nv, 0.0);
  for (int b = 0; b < m.nbody; b++) {
    const Thing none{0, {}, {}, 0, 0, {}, {}, {}, {}, {}, {1, 0, 0, 0}, 0, 0, 0};
    const Thing& t = b > 0 ? things[b - 1] : none;
    m.parent.push_back(0);
    m.jnt_first.push_back(std::max(0, b - 1)), m.jnt_count.push_back(b > 0);
    m.dof_first.push_back(6 * std::max(0, b - 1)), m.dof_count.push_back(b > 0 ? 6 : 0);
    m.pos.push_back({}), m.ipos.push_back({});
    m.quat.push_back({}), m.iquat.push_back({});
    m.mass.push_back(t.mass), m.inertia.push_back(t.inertia);
    if (b == 0) continue;
    m.jnt_body.push_back(b), m.jnt_type.push_back(hp::Joint::Free);
    m.jnt_qpos.push_back(7 * (b - 1)), m.jnt_dof.push_back(6 * (b - 1));
    m.jnt_pos.push_back({}), m.jnt_axis.push_back({0, 0, 1});
    m.qpos0.insert(m.qpos0.end(), {0, 0, 0, 1, 0, 0, 0});
  }
  return m;
}

inline void set_layer(hp::SoftLayer& out, const Layer& layer) {
  out.thickness = layer.thickness;
  out.law = {layer.stiffness, layer.damping, layer.densification, layer.arm, layer.relaxation};
}

// The layer's visible surface is z = 0 where a half-space is the frame; name 0 is the static's.
inline void build(hp::Stepper& s, const std::vector<Thing>& things, const Layer& layer,
                  double e = 0) {
  hp::System& system = s.system;
  system.model = model(things);
  system.gravity = {0, 0, -gravity};
  hp::Static frame;
  frame.n = {0, 0, 1}, frame.offset = -layer.thickness;
  system.world.statics.push_back(frame);
  system.soft.of_static.resize(1);
  if (layer.stiffness > 0) set_layer(system.soft.of_static[0], layer);
  for (size_t i = 0; i < things.size(); i++) {
    const Thing& t = things[i];
    hp::CollisionShape shape;
    shape.body = (int)i + 1, shape.name = (int)i + 1;
    shape.hull.vertices = t.vertices, shape.hull.radius = t.radius;
    shape.hull.rim = t.rim, shape.hull.axis = {0, 1, 0};
    shape.hull.finish();
    system.world.shapes.push_back(shape);
    system.soft.samples.resize(i + 1);
    hp::SurfaceSamples& samples = system.soft.samples[i];
    samples.points = t.points, samples.normals = t.normals, samples.areas = t.areas;
    system.soft.of_shape.resize(i + 1);
    system.soft.of_shape[i].thickness = t.thickness;
    system.soft.of_shape[i].law.stiffness = t.stiffness;
    system.soft.of_shape[i].law.damping = t.damping;
  }
  const int n = (int)things.size() + 1;
  system.world.n_names = n;
  system.world.pairings.assign((size_t)n * n, hp::Pairing{layer.friction, e, false});
  s.finish({});
  std::vector<double> q, v;
  for (const Thing& t : things) {
    q.insert(q.end(),
             {t.position.x, t.position.y, t.position.z, t.turn.w, t.turn.x, t.turn.y, t.turn.z});
    v.insert(v.end(), {t.velocity.x, t.velocity.y, t.velocity.z, 0, 0, 0});
  }
  s.reset(q.data(), v.data());
}

inline void frame(hp::Stepper& s, double dt = 1.0 / 60, int n = 4) {
  const double none = 0;
  s.frame(&none, dt, n);
}

// What layers push up with at the end of the last frame [N].
inline double upward(const hp::Stepper& s) {
  double sum = 0;
  for (const hp::SoftPoint& p : s.result().soft) sum += p.area * p.pressure * p.normal.z;
  return sum;
}

}  // namespace soft_scene
