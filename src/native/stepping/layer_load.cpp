#include "stepping/layer_load.h"

#include <algorithm>
#include <cmath>

#include "tuning.h"

namespace hp {

namespace {

// Is there a soft layer between the two that touch?
bool soft(const CollisionWorld& world, const Touch& t) {
  if (t.other_static >= 0 && world.statics[t.other_static].layer > 0) return true;
  if (t.other_shape >= 0 && world.shapes[t.other_shape].layer > 0) return true;
  return t.shape >= 0 && world.shapes[t.shape].layer > 0;
}

}  // namespace

double layer_fall(const System& system, const Drive& d, double h) {
  if (!d.footing.on()) return 0;
  return h * d.footing.layers.share() * norm(system.gravity) / d.scale(system.drive_settings, h);
}

namespace {

// (M x)_z / m - x_z: the momentum that the drive of joints makes, per mass [m/s].
double from_nowhere(const System& system, Data& data, const Drive& d) {
  std::vector<double> change(system.model.nv, 0), momentum(system.model.nv, 0);
  d.unhindered(change.data());
  const int first = d.first_dof();
  double most = 0;
  for (int i = first; i < first + d.dof_count(); i++) {
    change[i] = data.step.v_free[i] - change[i];
    most = std::max(most, std::fabs(change[i]));
  }
  if (most < tuning::stepping::kVelocityRounding) return 0;
  data.inertia.compose(system, data.state);
  data.inertia.multiply(system, d, change.data(), momentum.data());
  return momentum[first + 2] / system.model.carried[d.body(0)] - change[first + 2];
}

}  // namespace

void add_layer_load(System& system, Data& data, double h) {
  Step& step = data.step;
  for (Drive& d : system.drives) {
    if (!system.active(d) || !d.footing.on() || !d.footing.layers.carry()) continue;
    d.footing.layers.advance(h);
    const double fall = layer_fall(system, d, h) + from_nowhere(system, data, d);
    const int up = d.first_dof() + 2;
    step.v_free[up] -= fall;
    if (step.load.empty()) step.load.assign(system.model.nv, 0);
    step.load[up] -= fall;
  }
}

void end_layer_frame(System& system, const FrameResult& result, double dt) {
  for (Drive& d : system.drives) {
    if (!d.footing.on()) continue;
    const int root = d.body(0);
    double up = 0;  // impulse on the person [N s]
    Vec3 centre;
    for (const Touch& t : result.touches) {
      const bool first = t.shape >= 0 && system.tree(t.shape) == root;
      const bool second = t.other_shape >= 0 && system.tree(t.other_shape) == root;
      if (first == second || !soft(system.world, t)) continue;
      const double push = std::max(0.0, first ? t.impulse.z : -t.impulse.z);
      up += push;
      centre += (t.weight > 0 ? push / t.weight : push) * t.position;
    }
    const double weight = norm(system.gravity) * system.model.carried[root] * dt;
    const bool any = up > 0 && weight > 0;
    d.footing.layers.pressed(any ? up / weight : 0, any ? (1 / up) * centre : Vec3{}, dt);
  }
}

}  // namespace hp
