#include "stepping/layer_load.h"

#include <algorithm>
#include <cmath>

#include "stepping/layer_balance.h"
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
  return d.footing.sinks() * h * d.footing.layers.share() * norm(system.gravity) /
         d.scale(system.drive_settings, h);
}

void add_layer_load(System& system, Data& data, double h) {
  Step& step = data.step;
  for (Drive& d : system.drives) {
    if (!system.active(d) || !d.footing.on() || !d.footing.layers.carry()) continue;
    balance_on_layers(system, data, d, h);
    d.footing.layers.advance(h);
    const double fall = layer_fall(system, d, h);
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
