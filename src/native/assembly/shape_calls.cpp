#include "assembly/shape_calls.h"

namespace hp::assembly {

void add_shape(Stepper& s, int body, int name, int person, int part, Rows3 vertices, Rows3 normals,
               double radius, Doubles rim) {
  CollisionShape v;
  v.body = body, v.name = name, v.person = person, v.part = part;
  v.hull = convex(vertices, radius, rim, vectors(normals));
  s.system.world.shapes.push_back(std::move(v));
}

void set_slack(Stepper& s, double slack) {
  need(!s.system.world.shapes.empty() && slack >= 0, "set_slack: no shape, or less than 0");
  s.system.world.shapes.back().slack = slack;
}

void add_skin_shapes(Stepper& s, const SkinShapes& person_shapes, int person, Ints names) {
  const Model& m = s.system.model;
  const Skin& skin = *person_shapes.skin;
  need(names.shape(0) == person_shapes.shapes.size(), "add_skin_shapes: one name per shape");
  for (size_t j = 0; j < skin.body.size(); j++) {
    need(skin.body[j] > 0 && skin.body[j] < m.nbody && m.dof_first[skin.body[j]] == skin.dof[j],
         "add_skin_shapes: the skin is of other bodies");
    need(j == 0 || m.dof_count[skin.body[j]] == 3, "add_skin_shapes: a joint that is no ball");
  }
  s.system.skins.push_back(person_shapes.skin);
  for (size_t i = 0; i < person_shapes.shapes.size(); i++) {
    CollisionShape v = person_shapes.shapes[i];
    v.name = names.data()[i], v.person = person;
    s.system.world.shapes.push_back(std::move(v));
  }
}

void add_half_space(Stepper& s, int name, Doubles n, double offset) {
  need(n.shape(0) == 3, "add_half_space: the normal must be (3,)");
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

void set_self_pairs(Stepper& s, Square pairs) {
  const int n = (int)s.system.world.shapes.size();
  need(pairs.shape(0) == 0 || pairs.shape(1) == 2, "self pairs must be (n, 2)");
  std::vector<std::pair<int, int>> all;
  for (size_t k = 0; k < pairs.shape(0); k++) {
    const int i = (int)pairs.data()[2 * k], j = (int)pairs.data()[2 * k + 1];
    need(0 <= i && i < j && j < n, "self pairs: no such shapes");
    need(s.system.tree(i) == s.system.tree(j), "self pairs: not of one tree");
    all.push_back({i, j});
  }
  s.system.world.set_self_pairs(all);
}

void start_asleep(Stepper& s, int body) { s.start_asleep(body); }

void add_trajectory(Stepper& s, int body, double fps, bool loop, Rows3 position, Rows4 turn) {
  need(fps > 0 && fps <= 1e5, "add_trajectory: the frame rate must be over 0, up to 1e5");
  s.add_trajectory({body, fps, loop, vectors(position), quats(turn)});
}

}  // namespace hp::assembly
