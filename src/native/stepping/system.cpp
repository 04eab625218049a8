#include "stepping/system.h"

#include <algorithm>
#include <stdexcept>

namespace hp {

void System::finish(const std::vector<int>& person_roots) {
  model.finish();
  drives.clear();
  person.assign(model.nbody, 0);
  for (int root : person_roots) {
    if (root <= 0 || root >= model.nbody) throw std::invalid_argument("bad root body");
    drives.emplace_back(model, root);
    person[root] = 1;
  }
  find_loads();
  find_objects();
  std::vector<char> others = person;
  for (int b : objects) others[b] = 1;
  articulations.finish(model, others);
  for (CollisionShape& m : world.shapes) {
    if (m.body <= 0 || m.body >= model.nbody) throw std::invalid_argument("bad body of a shape");
    m.finish();
  }
  soft.finish(world);
  for (size_t i = 0; i < world.statics.size(); i++)
    world.statics[i].layer = soft.layer_of_static((int)i).thickness;
  for (size_t i = 0; i < world.shapes.size(); i++)
    world.shapes[i].layer =
        std::max(soft.layer_of_shape((int)i).thickness, soft.samples_of((int)i).thickest);
  find_joint_reach();
  world.standing.assign(model.nbody, 0);
  world.asleep.assign(model.nbody, 0);
  world.prescribed_exits.pace.assign(model.nbody, 1);
  world.prescribed_exits.squeezed.assign(model.nbody, 0);
}

void System::find_objects() {
  objects.clear();
  std::vector<int> tree_size(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) tree_size[model.root[b]]++;
  for (int b = 1; b < model.nbody; b++)
    if (!person[b] && model.jnt_count[b] == 1 && tree_size[b] == 1 &&
        model.jnt_type[model.jnt_first[b]] == Joint::Free)
      objects.push_back(b);
}

// Held objects are bodies of a person's tree that no joint moves.
void System::find_loads() {
  holds_load.assign(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++)
    if (is_person(b) && model.dof_count[b] == 0) holds_load[b] = holds_load[model.root[b]] = 1;
}

void System::find_joint_reach() {
  joint_reach.assign(model.nbody, 0);
  for (const CollisionShape& m : world.shapes)
    for (const CollisionShape::Influence& t : m.influences) {
      double far = t.far;
      for (int b = t.body; b > 0; far += norm(model.pos[b]), b = model.parent[b])
        joint_reach[b] = std::max(joint_reach[b], far);
    }
}

int System::ball_count() const {
  int n = 0;
  for (const Drive& d : drives) n += d.ball_count();
  return n;
}

double System::speed_bound(const Kinematics& k, const CollisionShape& shape,
                           const std::vector<Twist>& t) const {
  double fastest = shape.weighted_bound([&](const CollisionShape::Influence& tie) {
    const Twist& w = t[tie.body];
    const Vec3 at = k.xpos[tie.body] + k.xmat[tie.body] * tie.anchor;
    return norm(w.v + cross(w.w, at - k.reference(model, tie.body))) + norm(w.w) * tie.reach;
  });
  for (const CollisionShape::BlendBound& s : shape.blend_bounds) {
    // The change of a rotation matrix is sqrt(2) times the angular velocity.
    const Skin& skin = *shape.skin;
    fastest += std::sqrt(2.0) * s.gain *
               norm(t[skin.body[s.joint]].w - t[skin.body[skin.parent[s.joint]]].w);
  }
  return fastest;
}

}  // namespace hp
