#include "stepping/soft_rules.h"

#include <algorithm>

#include "stepping/data.h"

namespace hp {

void SoftRules::reset(const Model& m, bool any) {
  level_.assign(any ? m.nbody : 0, 0);
  kick_.assign(any ? m.nv : 0, 0);
}

void SoftRules::ease_gravity(const System& system, Data& data, double h) const {
  if (data.step.host_v_free) return;
  for (const int b : system.objects)
    if (level_[b] && system.world.active[b] && !system.world.asleep[b] && !system.model.held[b])
      for (int i = 0; i < 3; i++)
        data.step.v_free[system.model.dof_first[b] + i] -= 0.5 * h * system.gravity[i];
}

void SoftRules::choose(const System& system, const Data& data) {
  const Model& model = system.model;
  rules_.assign(model.nbody, data.step.host_v_free ? Rule::End : Rule::Mean);
  std::vector<char> free(model.nbody, 0);
  for (const int b : system.objects) free[b] = !model.held[b];
  for (int b = 1; b < model.nbody; b++) {
    if (model.root[b] != b) continue;
    const int island = data.islands.of_tree(b);
    if (!free[b] || data.attempt.islands[island].violated) rules_[island] = Rule::End;
  }
}

void SoftRules::begin_record(const Model& m) {
  pressed_.assign(m.nbody, Pressed::No);
  force_.assign(m.nv, 0.0);
}

Vec3 SoftRules::record(const System& system, const Data& data, Rule rule, int tree_a, int tree_b,
                       const Contact& row) {
  const bool mean = rule == Rule::Mean;
  for (const int root : {tree_a, tree_b}) pressed_[root] = mean ? Pressed::ByMean : Pressed::ByEnd;
  if (!mean) return row.impulse;
  const double q = dot(row.impulse, row.n);
  for (const auto& [end, sign] : {std::pair{&row.a, q}, std::pair{&row.b, -q}}) {
    if (end->count == 0) continue;
    const int body = end->body[0], d = system.model.dof_first[body];
    const Kinematics& kin = data.state.pose.kin;
    const Vec3 force = sign * row.n;
    const Vec3 moment = mul_t(kin.xmat[body], cross(end->point[0] - kin.xpos[body], force));
    for (int i = 0; i < 3; i++) force_[d + i] += force[i], force_[d + 3 + i] += moment[i];
  }
  return row.impulse + q * row.n;
}

// The other half of impulses and of gravity, of trees that have begun their step.
void SoftRules::end_record(const System& system, Data& data, const std::vector<double>& share) {
  const Model& model = system.model;
  const auto by_mean = [](Pressed p) { return p == Pressed::ByMean; };
  kick_.assign(model.nv, 0.0);
  if (std::any_of(pressed_.begin(), pressed_.end(), by_mean)) {
    kick_ = force_;
    data.inertia.solve(model, kick_.data());
  }
  const double half = 0.5 * data.step.gravity_time;
  for (const int b : system.objects) {
    if (!system.world.active[b] || model.held[b] || (!share.empty() && share[b] < 0)) continue;
    if (by_mean(pressed_[b]) || (level_[b] && pressed_[b] == Pressed::ByEnd))
      for (int i = 0; i < 3; i++) kick_[model.dof_first[b] + i] += half * system.gravity[i];
    level_[b] = by_mean(pressed_[b]);
  }
}

const double* SoftRules::load(const double* in) {
  level_.assign(in, in + level_.size());
  return in + level_.size();
}

void SoftRules::adopt(const SoftRules& old, const std::vector<int>& body) {
  for (size_t b = 0; b < body.size(); b++) level_[b] = body[b] >= 0 ? old.level_[body[b]] : 0;
}

}  // namespace hp
