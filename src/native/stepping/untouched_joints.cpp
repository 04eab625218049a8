#include "stepping/untouched_joints.h"

namespace hp {

void UntouchedJoints::begin(const System& system, JointResistance& resistance,
                            EffectiveInertia& inertia) const {
  resistance.touched.assign(system.model.nbody, 0);
  for (const Drive& d : system.drives)
    for (int i = 1; i < d.ball_count(); i++) resistance.touched[d.body(i)] = d.lately(i);
  inertia.refactor();
}

bool UntouchedJoints::release(const System& system, const Attempt& attempt,
                              JointResistance& resistance, EffectiveInertia& inertia) {
  if (system.drive_settings.time_constant == 0) return false;
  const Model& model = system.model;
  const std::vector<double>& added = inertia.drive_part();
  released_.assign(model.nbody, 0);
  bool found = false;
  const auto touch = [&](int b) {
    if (resistance.touched[b]) return;
    resistance.touched[b] = 1;
    if (model.parent[b] == 0 || model.dof_count[b] == 0 || added[model.dof_first[b]] == 0) return;
    released_[model.root[b]] = 1;
    found = true;
  };
  for (const ContactCandidate& c : attempt.candidates)
    if (system.self_overlap(c)) for_each_pushed(system, c, touch);
  for (const Contact& c : attempt.contacts) {
    // Rows of joint ranges and of who stands on things have no candidate.
    if (norm2(c.impulse) == 0 || c.pair >= (int)attempt.candidates.size()) continue;
    for_each_pushed(system, attempt.candidates[c.pair], touch);
  }
  if (found) inertia.refactor();
  return found;
}

}  // namespace hp
