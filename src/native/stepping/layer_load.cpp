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

// With which sign touches push a person (its root body) in the impulses that they give; 0: not, or it is within itself.
double pushes(const System& system, const Touch& t, int root) {
  const bool first = t.shape >= 0 && system.tree(t.shape) == root;
  const bool second = t.other_shape >= 0 && system.tree(t.other_shape) == root;
  return (double)first - (double)second;
}

// What has pushed a person upwards in the frame so far.
OnLayers::Pushes pushed_up(const System& system, const FrameResult& result, int root) {
  OnLayers::Pushes sum;
  for (const Touch& t : result.touches) {
    const double sign = pushes(system, t, root);
    if (sign != 0) (soft(system.world, t) ? sum.soft : sum.hard) += sign * t.impulse.z;
  }
  return sum;
}

}  // namespace

double layer_fall(const System& system, const Drive& d, double h) {
  if (!d.footing.on()) return 0;
  return h * d.footing.layers.share() * norm(system.gravity) / d.scale(system.drive_settings, h);
}

void add_layer_load(System& system, Data& data, double h) {
  Step& step = data.step;
  for (Drive& d : system.drives) {
    if (!system.active(d) || !d.footing.on() || !d.footing.layers.carry()) continue;
    balance_on_layers(system, data, d, h);
    d.footing.layers.advance(h);
    const double fall = d.footing.sinks() * layer_fall(system, d, h);
    const int up = d.first_dof() + 2;
    step.v_free[up] -= fall;
    if (step.load.empty()) step.load.assign(system.model.nv, 0);
    step.load[up] -= fall;
  }
}

void begin_layer_frame(System& system, Data& data) {
  std::vector<double> change, momentum;
  data.inertia.forget();  // of the last substep's start
  for (Drive& d : system.drives) {
    if (!system.active(d) || !d.footing.on()) continue;
    d.footing.layers.begin_frame();
    if (system.drive_settings.time_constant == 0 || !d.footing.layers.carry()) continue;
    const int up = d.first_dof() + 2;
    change.assign(system.model.nv, 0), momentum.assign(system.model.nv, 0);
    d.reference_change(change.data());
    data.inertia.compose(system, data.state);
    data.inertia.multiply(system, d, change.data(), momentum.data());
    const double rise = d.motion.frame_length() * momentum[up] / system.model.carried[d.body(0)];
    d.rise_faster(-d.footing.sinks() * d.footing.layers.share() * rise);
  }
}

void end_layer_substep(System& system, Data& data, double h) {
  for (Drive& d : system.drives) {
    if (!system.active(d) || !d.footing.on() || !d.footing.layers.carry()) continue;
    OnLayers& layers = d.footing.layers;
    const OnLayers::Pushes by = layers.since(pushed_up(system, data.result, d.body(0)));
    const double mass = system.model.carried[d.body(0)];
    const double fall = h * layers.share() * norm(system.gravity);
    double rise = (by.soft + by.hard) / mass - fall;
    if (by.hard > 0 && rise > 0) rise = std::max(0.0, by.soft / mass - fall);
    const double left = 1 - 1 / d.scale(system.drive_settings, h);
    data.state.qvel[d.first_dof() + 2] += d.footing.sinks() * left * rise;
  }
}

void end_layer_frame(System& system, const FrameResult& result, double dt) {
  for (Drive& d : system.drives) {
    if (!d.footing.on()) continue;
    const int root = d.body(0);
    double up = 0;  // impulse on the person [N s]
    Vec3 centre;
    for (const Touch& t : result.touches) {
      const double sign = pushes(system, t, root);
      if (sign == 0 || !soft(system.world, t)) continue;
      const double push = std::max(0.0, sign * t.impulse.z);
      up += push;
      centre += (t.weight > 0 ? push / t.weight : push) * t.position;
    }
    const double weight = norm(system.gravity) * system.model.carried[root] * dt;
    const bool any = up > 0 && weight > 0;
    d.footing.layers.pressed(any ? up / weight : 0, any ? (1 / up) * centre : Vec3{}, dt);
  }
}

}  // namespace hp
