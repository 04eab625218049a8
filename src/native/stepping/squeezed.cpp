#include "stepping/squeezed.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void SqueezeLimit::begin(const System& system, const Data& data,
                         const std::vector<double>& v_star) {
  any_ = !system.objects.empty() && !data.attempt.contacts.empty() && !data.step.host_v_free;
  found_ = false;
  if (!any_) return;
  island_ = data.islands.all();
  v_star_ = v_star;
}

// At the pose that the last step, or the last piece of one, started from.
void SqueezeLimit::find_speeds(const System& system, const Data& data) {
  found_ = true;
  const Model& model = system.model;
  const Kinematics& start = data.step.end.kin;  // committed poses change places
  body_twists(model, start, v_star_.data(), twists_);
  came_.assign(model.nbody, 0);
  fastest_.assign(model.nbody, 0);
  leader_.assign(model.nbody, -1);
  second_.assign(model.nbody, 0);
  for (const CollisionShape& shape : system.world.shapes) {
    const int root = model.root[shape.body];
    if (!system.world.active[shape.body]) continue;
    came_[root] = std::max(came_[root], system.speed_bound(start, shape, twists_));
  }
  for (int b = 1; b < model.nbody; b++) {
    if (model.root[b] != b || !system.world.active[b]) continue;
    const int k = island_[b];
    if (leader_[k] < 0 || came_[b] > fastest_[k]) {
      second_[k] = fastest_[k];
      fastest_[k] = came_[b], leader_[k] = b;
    } else {
      second_[k] = std::max(second_[k], came_[b]);
    }
  }
}

void SqueezeLimit::cut(const System& system, Data& data) {
  if (!any_) return;
  const Model& model = system.model;
  for (const int b : system.objects) {
    if (!system.world.active[b] || model.held[b]) continue;
    double* v = &data.state.qvel[model.dof_first[b]];
    const double speed = norm(load3(v));
    if (speed <= tune::kLeastSqueezeSpeed) continue;
    if (!found_) find_speeds(system, data);
    const int k = island_[b];
    const double others = leader_[k] == b ? second_[k] : fastest_[k];
    if (others == 0) continue;  // alone
    const double most =
        std::max({came_[b], tune::kSqueezeFactor * others, tune::kLeastSqueezeSpeed});
    for (int i = 0; i < 6 && speed > most; i++) v[i] *= most / speed;
  }
}

}  // namespace hp
