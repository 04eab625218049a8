#include "stepping/restitution.h"

#include "tuning.h"

namespace hp {

bool demand_rebounds(const System& system, Data& data, double h) {
  const Model& model = system.model;
  const Kinematics& kin = data.state.pose.kin;
  const Step& step = data.step;
  const double time = step.gravity_time;
  // (On this grid a parabola's own speed is half a substep's gravity from the velocity.)
  std::vector<double> before(step.v_free);
  for (int b : system.objects)
    for (int i = 0; i < 3 && !model.held[b]; i++)
      before[model.dof_first[b] + i] -= time * system.gravity[i];
  for (int i : system.articulations.dofs())
    if (time > 0) before[i] -= step.joint_pull[i];
  // Nor is the velocity in mid-step what it ends with where objects spin fast.
  for (int i = 0; i < model.nv; i++) before[i] += step.spin[i];
  std::vector<Twist> free, arrived, spun;
  body_twists(model, kin, step.v_free.data(), free);
  body_twists(model, kin, step.spin.data(), spun);
  body_twists(model, kin, before.data(), arrived);
  bool any = false;
  for (Contact& c : data.attempt.contacts) {
    if (c.restitution <= 0 || dot(c.impulse, c.n) <= 0) continue;
    const double arriving = approach(model, kin, c, arrived, before);
    if (arriving > -tuning::stepping::kBounceSpeed) continue;
    const double turned = approach(model, kin, c, spun, step.spin);
    const double pull =
        std::max(0.0, arriving - turned - approach(model, kin, c, free, step.v_free));
    const double height = 2 * pull * std::max(0.0, c.dist - c.target) / h;
    const double met = arriving - 0.5 * pull;
    const double back = c.restitution * c.restitution * (met * met + height) - height;
    c.bounce = std::sqrt(std::max(0.0, back)) - 0.5 * pull - turned;
    any = true;
  }
  return any;
}

}  // namespace hp
