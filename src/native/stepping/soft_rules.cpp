#include "stepping/soft_rules.h"

#include <algorithm>
#include <cmath>

#include "stepping/data.h"

namespace hp {

void SoftRules::reset(const Model& m, bool any) {
  level_.assign(any ? m.nbody : 0, 0);
  owed_.assign(any ? m.nbody : 0, 0.0);
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
  balanced_.assign(model.nbody, !data.step.host_v_free);
  island_ = data.islands.all();
  std::vector<char> free(model.nbody, 0);
  for (const int b : system.objects) free[b] = !model.held[b];
  for (int b = 1; b < model.nbody; b++) {
    if (model.root[b] != b) continue;
    const int island = data.islands.of_tree(b);
    if (!free[b] || data.attempt.islands[island].violated) rules_[island] = Rule::End;
    if (!free[b]) balanced_[island] = 0;
  }
}

void SoftRules::begin_record(const Model& m) {
  pressed_.assign(m.nbody, Pressed::No);
  given_.assign(m.nbody, 0.0);
  kept_.assign(m.nbody, 0.0);
  force_.assign(m.nv, 0.0);
  rub_.assign(m.nv, 0.0);
}

void SoftRules::push(const System& system, const Data& data, int island, int tree_a, int tree_b,
                     const Contact& row) {
  const Pressed by = rules_[island] == Rule::Mean ? Pressed::ByMean : Pressed::ByEnd;
  pressed_[tree_a] = pressed_[tree_b] = by;
  if (!balanced(island)) return;
  const double q = dot(row.impulse, row.n);
  for (const auto& [end, sign] : {std::pair{&row.a, 1.0}, std::pair{&row.b, -1.0}}) {
    if (end->count == 0) continue;
    const int body = end->body[0], d = system.model.dof_first[body];
    const Kinematics& kin = data.state.pose.kin;
    const Vec3 arm = end->point[0] - kin.xpos[body];
    const auto push = [&](Vec3 force, std::vector<double>& out) {
      const Vec3 moment = mul_t(kin.xmat[body], cross(arm, force));
      for (int i = 0; i < 3; i++) out[d + i] += force[i], out[d + 3 + i] += moment[i];
    };
    push(sign * q * row.n, force_);
    push(sign * (row.impulse - q * row.n), rub_);
  }
}

// The share s of the pushes f that an island keeps beside the velocity v that it moved with: of those with
// which it has not gained energy the nearest to that of its rule. With the velocity without contact v* and
// k = M^-1 f, it has gained (v + s k)^T M (v + s k)/2 - v*^T M v*/2 - what was given.
double SoftRules::kept_share(const System& system, const Data& data, int island) {
  const Model& model = system.model;
  const double usual = rules_[island] == Rule::Mean ? 1 : 0;
  const Step& step = data.step;
  std::vector<double> change(model.nv), momentum(model.nv);
  for (int i = 0; i < model.nv; i++) change[i] = step.v[i] - step.v_free[i];
  double fk = 0, fv = 0, gained = -given_[island];
  for (const int b : system.objects) {
    if (island_[b] != island || !system.world.active[b]) continue;
    gained -= owed_[b];
    owed_[b] = 0;
    const int d = model.dof_first[b], end = d + model.dof_count[b];
    data.inertia.inertia().multiply(model, {b, b, d, end}, change.data(), momentum.data());
    for (int i = d; i < end; i++) {
      fk += force_[i] * kick_[i], fv += force_[i] * step.v[i];
      gained += 0.5 * momentum[i] * (step.v[i] + step.v_free[i]) - rub_[i] * step.v[i];
    }
  }
  const auto energy = [&](double s) { return (0.5 * s * fk + fv) * s + gained; };
  if (!(fk > 0)) return usual;
  if (energy(usual) <= 0) {
    if (usual > 0) owed_[island] = -energy(usual);
    return usual;
  }
  const double least = -fv / fk;  // here it has least
  const double over = least * least - 2 * gained / fk;
  if (over <= 0) return least;
  return least < usual ? least + std::sqrt(over) : least - std::sqrt(over);
}

void SoftRules::balance(const System& system, const Data& data) {
  const Model& model = system.model;
  kick_ = force_;
  if (std::all_of(force_.begin(), force_.end(), [](double f) { return f == 0; })) return;
  data.inertia.solve(model, kick_.data());
  for (const int b : system.objects)
    if (island_[b] == b && balanced(b)) kept_[b] = kept_share(system, data, b);
  for (int i = 0; i < model.nv; i++) kick_[i] *= kept_[island_[model.root[model.dof_body[i]]]];
}

// Half of gravity too, of trees that have begun their step.
void SoftRules::end_record(const System& system, Data& data, const std::vector<double>& share) {
  const Model& model = system.model;
  const auto by_mean = [](Pressed p) { return p == Pressed::ByMean; };
  const double half = 0.5 * data.step.gravity_time;
  for (const int b : system.objects) {
    if (!system.world.active[b] || model.held[b] || (!share.empty() && share[b] < 0)) continue;
    if (by_mean(pressed_[b]) || (level_[b] && pressed_[b] == Pressed::ByEnd))
      for (int i = 0; i < 3; i++) kick_[model.dof_first[b] + i] += half * system.gravity[i];
    level_[b] = by_mean(pressed_[b]);
    if (pressed_[b] == Pressed::No) owed_[b] = 0;
  }
}

void SoftRules::save(std::vector<double>& out) const {
  out.insert(out.end(), level_.begin(), level_.end());
  out.insert(out.end(), owed_.begin(), owed_.end());
}

const double* SoftRules::load(const double* in) {
  level_.assign(in, in + level_.size());
  in += level_.size();
  owed_.assign(in, in + owed_.size());
  return in + owed_.size();
}

void SoftRules::adopt(const SoftRules& old, const std::vector<int>& body) {
  for (size_t b = 0; b < body.size(); b++) {
    level_[b] = body[b] >= 0 ? old.level_[body[b]] : 0;
    owed_[b] = body[b] >= 0 ? old.owed_[body[b]] : 0;
  }
}

}  // namespace hp
