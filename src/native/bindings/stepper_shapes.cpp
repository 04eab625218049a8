// What there is to collide: shapes of bodies, skins, static geometry, and what holds between pairs.
#include "bindings/stepper.h"

using namespace hp;
using namespace nb::literals;

namespace {

void add_shape(Stepper& s, int body, int name, int person, int part, Rows3 vertices, Rows3 normals,
               double radius, Doubles rim) {
  CollisionShape v;
  v.body = body, v.name = name, v.person = person, v.part = part;
  v.hull = convex(vertices, radius, rim, vectors(normals));
  s.system.world.shapes.push_back(std::move(v));
}

// Of the last shape: how far it sticks out of the surface that it stands for [m].
void set_slack(Stepper& s, double slack) {
  need(!s.system.world.shapes.empty() && slack >= 0, "set_slack: no shape, or less than 0");
  s.system.world.shapes.back().slack = slack;
}

// bend: (vertices, 3, features), or of no vertices: no pose blend shapes. Returns the skin's index.
int add_skin(Stepper& s, Ints body, Ints parent, Rows3 joint, Rows3 rest, Ints first, Ints at,
             Doubles weight, f64<nb::ndim<3>> bend) {
  auto skin = std::make_shared<Skin>();
  skin->body = list<int>(body), skin->parent = list<int>(parent);
  skin->joint = vectors(joint), skin->rest = vectors(rest);
  skin->first_weight = list<int>(first), skin->weight_joint = list<int>(at);
  skin->weight = list<double>(weight);
  const size_t n = rest.shape(0), joints = joint.shape(0);
  need(body.shape(0) == joints && parent.shape(0) == joints && first.shape(0) == n + 1 &&
           at.shape(0) == weight.shape(0) && (size_t)skin->first_weight[n] == at.shape(0),
       "add_skin: arrays that do not fit together");
  for (int b : skin->body) {
    need(b > 0 && b < s.system.model.nbody, "add_skin: no such body");
    skin->dof.push_back(s.system.model.dof_first[b]);
  }
  for (int j : skin->weight_joint) need(j >= 0 && (size_t)j < joints, "add_skin: no such joint");
  need(bend.shape(0) == 0 ||
           (bend.shape(0) == n && bend.shape(1) == 3 && bend.shape(2) == (size_t)skin->features()),
       "add_skin: bend has the wrong shape");
  skin->pose_blend.assign(bend.data(), bend.data() + bend.size());
  s.system.skins.push_back(std::move(skin));
  return (int)s.system.skins.size() - 1;
}

void add_skin_shape(Stepper& s, int skin, int name, int person, int part, Ints vertices) {
  CollisionShape v;
  v.skin = s.system.skins.at(skin);
  v.name = name, v.person = person, v.part = part;
  v.vertex = list<int>(vertices);
  need(!v.vertex.empty(), "add_skin_shape: a hull needs at least one vertex");
  for (int i : v.vertex)
    need(i >= 0 && (size_t)i < v.skin->rest.size(), "add_skin_shape: no such vertex");
  v.finish();
  s.system.world.shapes.push_back(std::move(v));
}

void add_half_space(Stepper& s, int name, Doubles n, double offset) {
  Static v;
  v.name = name, v.n = load3(n.data()), v.offset = offset;
  s.system.world.statics.push_back(std::move(v));
}

void add_hull(Stepper& s, int name, Rows3 vertices, Rows3 normals, double radius, Doubles rim) {
  Static v;
  v.kind = Static::Kind::Hull;
  v.name = name;
  v.hull = convex(vertices, radius, rim, vectors(normals));
  s.system.world.statics.push_back(std::move(v));
}

void add_mesh(Stepper& s, int name, const MeshTree& mesh) {
  Static v;
  v.kind = Static::Kind::Mesh;
  v.name = name;
  v.tree = mesh.tree;
  s.system.world.statics.push_back(std::move(v));
}

// Names x names each.
void set_pairings(Stepper& s, Square friction, Square restitution, Square ignore) {
  const size_t n = friction.shape(0);
  need(friction.shape(1) == n && restitution.shape(0) == n && restitution.shape(1) == n &&
           ignore.shape(0) == n && ignore.shape(1) == n,
       "pairings must be square and of one size");
  World& world = s.system.world;
  world.n_names = (int)n;
  world.pairings.resize(n * n);
  for (size_t i = 0; i < n * n; i++)
    world.pairings[i] = {friction.data()[i], restitution.data()[i], ignore.data()[i] != 0};
}

// Pairs (n, 2) of one person's shapes that may touch each other, the smaller index first.
void set_self_pairs(Stepper& s, Square pairs) {
  const int n = (int)s.system.world.shapes.size();
  need(pairs.shape(0) == 0 || pairs.shape(1) == 2, "self pairs must be (n, 2)");
  std::vector<std::pair<int, int>> list;
  for (size_t k = 0; k < pairs.shape(0); k++) {
    const int i = (int)pairs.data()[2 * k], j = (int)pairs.data()[2 * k + 1];
    need(0 <= i && i < j && j < n, "self pairs: no such shapes");
    need(s.system.tree(i) == s.system.tree(j), "self pairs: not of one tree");
    list.push_back({i, j});
  }
  s.system.world.set_self_pairs(list);
}

}  // namespace

void bind_stepper_shapes(StepperClass& stepper) {
  stepper.def("add_shape", &add_shape)
      .def("set_slack", &set_slack)
      .def("add_skin", &add_skin)
      .def("add_skin_shape", &add_skin_shape)
      .def("add_half_space", &add_half_space)
      .def("add_hull", &add_hull)
      .def("add_mesh", &add_mesh)
      .def("set_pairings", &set_pairings)
      .def("set_self_pairs", &set_self_pairs)
      // Poses (K, 3), (K, 4) of a kinematic body, K of them `fps` to the second; see Trajectory.
      .def("add_trajectory",
           [](Stepper& s, int body, double fps, bool loop, Rows3 position, Rows4 turn) {
             s.add_trajectory({body, fps, loop, vectors(position), quats(turn)});
           })
      .def("start_asleep", &Stepper::start_asleep);
}
