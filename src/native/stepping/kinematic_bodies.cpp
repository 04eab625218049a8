#include "stepping/kinematic_bodies.h"

#include <algorithm>
#include <stdexcept>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

void Trajectory::at(double time, Vec3& p, Quat& q) const {
  const int n = (int)position.size();
  double frame = time * fps;
  if (loop) frame = std::max(frame - n * std::floor(frame / n), 0.0);  // rounding of a long time
  // A time that is a rounding away from a pose is at it.
  if (std::fabs(frame - std::round(frame)) < 1e-9) frame = std::round(frame);
  int i = (int)std::floor(frame), j = i + 1;
  double share = frame - i;
  if (loop) {
    i %= n, j %= n;
  } else if (j > n - 1) {
    i = j = n - 1, share = 0;
  }
  p = position[i] + share * (position[j] - position[i]);
  q = share == 0 ? turn[i] : turn[i] * exp_quat(share * log_quat(conjugate(turn[i]) * turn[j]));
}

void KinematicBodies::add(const Model& m, Trajectory t) {
  const bool free = t.body > 0 && t.body < m.nbody && m.jnt_count[t.body] == 1 &&
                    m.jnt_type[m.jnt_first[t.body]] == Joint::Free;
  if (!free || t.position.empty() || t.turn.size() != t.position.size())
    throw std::invalid_argument("add_trajectory: bad trajectory");
  trajectories_.push_back(std::move(t));
}

void KinematicBodies::finish(Model& m) {
  for (const Trajectory& t : trajectories_) m.held[t.body] = 1;
  reset(m);
}

void KinematicBodies::reset(const Model& m) {
  clock_.assign(trajectories_.size(), 0);
  pace_.assign(trajectories_.size(), {});
  late_.assign(m.nbody, 0);
}

void KinematicBodies::gain_pace() {
  for (Pace& p : pace_) {
    if (p.share > 0) {
      p.share = std::min(1.0, tune::kPaceGain * p.share);
      if (p.share == 1) p.patience = 0;
    } else if (--p.wait <= 0) {
      p.share = tune::kLeastBodyPace;
    }
  }
}

void KinematicBodies::set_velocity(const Model& m, const State& state, Step& step, double h) const {
  for (size_t i = 0; i < trajectories_.size(); i++) {
    const Trajectory& t = trajectories_[i];
    const int q = m.jnt_qpos[m.jnt_first[t.body]], d = m.dof_first[t.body];
    Vec3 p;
    Quat turn;
    t.at(clock_[i] + pace_[i].share * h, p, turn);
    store3(&step.v_free[d], (1 / h) * (p - load3(&state.qpos[q])));
    store3(&step.v_free[d + 3], (1 / h) * log_quat(conjugate(load4(&state.qpos[q + 3])) * turn));
    store3(&step.spin[d + 3], {});
  }
}

bool KinematicBodies::slow_down(const System& system, Data& data) {
  const Attempt& attempt = data.attempt;
  if (attempt.good || trajectories_.empty()) return false;
  const std::vector<char> slow = slowed(system, data);
  std::vector<char> squeezed(system.model.nbody, 0);
  for (size_t i = 0; i < attempt.violated.size(); i++) {
    const int island = attempt.candidates[i].island;
    if (attempt.violated[i] && (slow[island] || attempt.islands[island].crushed))
      squeezed[island] = 1;
  }
  bool any = false;
  for (size_t i = 0; i < trajectories_.size(); i++) {
    Pace& p = pace_[i];
    if (p.share == 0 || !squeezed[data.islands.of_tree(trajectories_[i].body)]) continue;
    any = true;
    p.share = p.share > tune::kLeastBodyPace
                  ? std::max(tune::kLeastBodyPace, tune::kPaceCut * p.share)
                  : 0;
    if (p.share > 0) continue;
    p.patience = std::min(tune::kMostPaceWait, std::max(1, 2 * p.patience));
    p.wait = p.patience;
  }
  return any;
}

std::vector<char> KinematicBodies::slowed(const System& system, const Data& data) const {
  std::vector<char> slow(system.model.nbody, 0);
  for (size_t i = 0; i < trajectories_.size(); i++)
    if (pace_[i].share < 1 && system.world.active[trajectories_[i].body])
      slow[data.islands.of_tree(trajectories_[i].body)] = 1;
  return slow;
}

void KinematicBodies::give_up_clearance(const System& system, Data& data) const {
  if (trajectories_.empty()) return;
  const std::vector<char> slow = slowed(system, data);
  for (int b = 1; b < system.model.nbody; b++)
    data.attempt.relaxed[b] = slow[data.islands.of_tree(system.model.root[b])];
}

void KinematicBodies::drop_friction(const System& system, Data& data) const {
  if (trajectories_.empty()) return;
  const std::vector<char> slow = slowed(system, data);
  Attempt& attempt = data.attempt;
  for (Contact& c : attempt.contacts) {
    const ContactCandidate& k = attempt.candidates[c.pair];
    const int root = system.tree(k.shape);
    if (slow[k.island] && system.person[root] && attempt.relaxed[root]) c.friction = 0;
  }
}

double KinematicBodies::pushable_mass(const System& system, const Islands& islands,
                                      int island) const {
  const Model& m = system.model;
  double mass = 0;
  for (int b = 1; b < m.nbody && !trajectories_.empty(); b++)
    if (system.world.active[b] && !m.held[m.root[b]] && islands.of_tree(m.root[b]) == island)
      mass += m.mass[b];
  return mass;
}

double KinematicBodies::pass_time(const Model& m, double h) {
  double most = 0;
  for (size_t i = 0; i < trajectories_.size(); i++) {
    const double on = pace_[i].share * (h - late_[trajectories_[i].body]);
    clock_[i] += on;
    most = std::max(most, h - on);
  }
  late_.assign(m.nbody, 0);
  return most;
}

void KinematicBodies::save(std::vector<double>& out) const {
  out.insert(out.end(), clock_.begin(), clock_.end());
  for (const Pace& p : pace_) out.insert(out.end(), {p.share, (double)p.wait, (double)p.patience});
}

const double* KinematicBodies::load(const double* in) {
  clock_.assign(in, in + clock_.size());
  in += clock_.size();
  for (Pace& p : pace_) {
    p = {in[0], (int)in[1], (int)in[2]};
    in += 3;
  }
  return in;
}

void KinematicBodies::adopt(const KinematicBodies& old, const std::vector<int>& body) {
  for (size_t i = 0; i < trajectories_.size(); i++)
    for (size_t k = 0; k < old.trajectories_.size(); k++)
      if (body[trajectories_[i].body] == old.trajectories_[k].body)
        clock_[i] = old.clock_[k], pace_[i] = old.pace_[k];
}

}  // namespace hp
