#include "stepping/substep.h"

#include "stepping/exit_motion.h"
#include "stepping/layer_load.h"
#include "stepping/sleeping.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void Substep::finish() {
  load_.finish(system_.model);
  strength_.finish(system_.model);
}

void Substep::run(int k, double h) {
  begin(h);
  data_.step.index = k;
  free_velocity(k, h);
  strength_.begin(system_, data_.step);
  attempts_.run(h);
  while (again(h)) attempts_.run(h);
  trace(k, h);
  squeezed_.begin(system_, data_, data_.step.v_free);
  const double lost = sub_stepping_.make(h);
  end(h, lost);
}

void Substep::lose(double h) {
  for (int b = 1; b < system_.model.nbody; b++) kinematic_.set_late(b, h);
  kinematic_.pass_time(system_.model, h);
  // Nobody is where the frame was to take them: none is put at its end (free_paths.h).
  for (const Drive& d : system_.drives)
    if (system_.active(d)) data_.result.disturbed[d.body(0)] = 1;
  data_.result.diagnostics.shortened++;
  data_.result.diagnostics.lost_time += h;
}

void Substep::begin(double h) {
  World& world = system_.world;
  const Model& model = system_.model;
  State& state = data_.state;
  Probe& probe = data_.probe;
  data_.inertia.forget();
  data_.step.pushed.assign(model.nbody, 0);
  data_.step.yielded_before.assign(model.nbody, 0);
  data_.step.resistance.begin(model, system_.drives.size());
  data_.step.length = data_.step.gravity_time = h;
  data_.cache.begin_substep();
  world.narrow_phase.begin_substep();
  if (world.depenetration.any() && !data_.budget.frame_out() &&
      world.depenetration.reroute(model, state.pose))
    world.broad_phase.invalidate();
  data_.budget.spend(tune::kTestWork * world.take_tests());
  if (world.self_contact()) world.self_depenetration.update(model, state.pose);
  if (probe.keep_times) probe.solve_times.push_back(0);
  probe.tracing = probe.keep_trace;
  probe.trace.overcome.clear();
  // Twists need the dofs' axes.
  state.pose.kin.update_dofs(model, state.qpos.data(), world.active.data());
  Articulations& objects = system_.articulations;
  if (!objects.joints.motors.empty()) {
    data_.inertia.compose(system_, state);
    objects.find_efforts(model, world.active, data_.inertia.inertia(), state.qpos.data(),
                         state.qvel.data(), h);
  }
  kinematic_.gain_pace();
  world.parting.update(state.pose);
}

void Substep::free_velocity(int k, double h) {
  Step& step = data_.step;
  step.load.clear();
  free_.drive(system_, data_, internal_, k, h);
  if (step.host_v_free) {
    for (int i = 0; i < system_.model.nv; i++)
      if (!system_.is_person(system_.model.dof_body[i])) step.v_free[i] = step.host_v_free[i];
    strength_.limit(system_, data_, h);
    return add_layer_load(system_, data_, h);
  }
  standing_.wake(system_, data_);
  load_.find(system_, data_.state, h);
  strength_.limit(system_, data_, h);
  load_.bear(system_, data_, h);
  part_people(system_, data_);
  object_velocity(system_, data_.state, step, h);
  data_.soft.ease_gravity(system_, data_, h);
  standing_.add(system_, data_, h);
  add_layer_load(system_, data_, h);
  hold_asleep(system_, step);
  kinematic_.set_velocity(system_.model, data_.state, step, h);
}

// Is the attempt to be repeated, with kinematic bodies that go slower or joints that resist less?
bool Substep::again(double h) {
  if (!data_.budget.out() && kinematic_.slow_down(system_, data_)) {
    kinematic_.set_velocity(system_.model, data_.state, data_.step, h);
    return true;
  }
  return strength_.give_in(system_, data_, h);
}

void Substep::trace(int k, double h) {
  Probe& probe = data_.probe;
  const Attempt& attempt = data_.attempt;
  int& most = data_.result.diagnostics.contacts;
  most = std::max(most, (int)attempt.contacts.size());
  if (!probe.tracing) return;
  probe.tracing = false;  // of the whole step only
  Probe::Trace& trace = probe.trace;
  const JointResistance& resistance = data_.step.resistance;
  trace.qpos = data_.state.qpos, trace.qvel = data_.state.qvel;
  trace.v_free = data_.step.v_free, trace.v = data_.step.v;
  if (attempt.contacts.empty()) trace.contacts.clear();
  if (attempt.ranges.empty()) trace.ranges.clear();
  trace.touched = resistance.touched;
  for (size_t p = 0; p < system_.drives.size(); p++)
    for (int i = 0; i < system_.drives[p].ball_count() && !resistance.holds[p]; i++)
      trace.touched[system_.drives[p].body(i)] = 1;
  trace.h = h, trace.k = k;
}

void Substep::end(double h, double lost) {
  const Model& model = system_.model;
  State& state = data_.state;
  Diagnostics& diagnostics = data_.result.diagnostics;
  lost = std::max(lost, kinematic_.pass_time(model, h));
  if (lost > 0) diagnostics.shortened++;
  diagnostics.lost_time += lost;
  diagnostics.residual = std::max(diagnostics.residual, -data_.attempt.worst);
  data_.cache.end_substep();
  data_.soft.end_substep(h);
  state.qvel = data_.step.v_free;
  squeezed_.cut(system_, data_);
  if (system_.world.parting.any()) finish_parting(system_, data_, h);
  for (int b : system_.objects)
    if (system_.world.active[b])
      for (int i = model.dof_first[b] + 3; i < model.dof_first[b] + 6; i++)
        state.qvel[i] += data_.step.spin[i];
  strength_.tally(system_, data_, h);
  for (Drive& d : system_.drives)
    if (system_.active(d)) d.end_substep(state.qvel.data(), h, data_.step.pushed);
}

int Substep::parts(double h) const {
  const World& world = system_.world;
  const std::vector<double>& qvel = data_.state.qvel;
  double fastest = system_.articulations.fastest(system_.model, world.active, qvel.data());
  for (int b : system_.objects)
    if (world.active[b])
      fastest = std::max(fastest, norm(load3(&qvel[system_.model.dof_first[b] + 3])));
  if (fastest * h <= tune::kMostTurn) return 1;
  const double parts = std::ceil(4 * fastest * h / tune::kMostTurn);
  return (int)std::min<double>(tune::kMostTurnParts, parts);  // before it is an int: it may be huge
}

}  // namespace hp
