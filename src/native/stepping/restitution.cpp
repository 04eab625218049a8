#include "stepping/restitution.h"

#include <algorithm>

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

bool Rebounds::demand(const System& system, Data& data) {
  const Model& model = system.model;
  const Kinematics& kin = data.state.pose.kin;
  const Step& step = data.step;
  const double time = step.gravity_time;
  const auto pressed = [](const Contact& c) {
    return c.restitution > 0 && dot(c.impulse, c.n) > 0;
  };
  const std::vector<Contact>& all = data.attempt.contacts;
  if (std::none_of(all.begin(), all.end(), pressed)) return false;
  // (On this grid a parabola's own speed is half a substep's gravity from the velocity.)
  before_ = step.v_free;
  for (int b : system.objects)
    for (int i = 0; i < 3 && !model.held[b]; i++)
      before_[model.dof_first[b] + i] -= time * system.gravity[i];
  for (int i : system.articulations.dofs())
    if (time > 0) before_[i] -= step.joint_pull[i];
  if (time > 0)
    for (size_t i = 0; i < step.load.size(); i++) before_[i] -= step.load[i];
  // Nor is the velocity in mid-step what it ends with where objects spin fast.
  for (int i = 0; i < model.nv; i++) before_[i] += step.spin[i];
  body_twists(model, kin, step.v_free.data(), free_);
  body_twists(model, kin, step.spin.data(), spun_);
  body_twists(model, kin, before_.data(), arrived_);
  bool any = false;
  for (Contact& c : data.attempt.contacts) {
    if (!pressed(c)) continue;
    const double arriving = approach(model, kin, c, arrived_, before_);
    if (arriving > -tune::kBounceSpeed) continue;
    const double turned = approach(model, kin, c, spun_, step.spin);
    const double pull =
        std::max(0.0, arriving - turned - approach(model, kin, c, free_, step.v_free));
    const double height = time > 0 ? 2 * pull * std::max(0.0, c.dist - c.target) / time : 0;
    const double met = arriving - 0.5 * pull;
    const double back = c.restitution * c.restitution * (met * met + height) - height;
    c.rebound = std::sqrt(std::max(0.0, back));
    c.bounce = c.rebound - 0.5 * pull - turned;
    data.attempt.islands[data.attempt.candidates[c.pair].island].state =
        IslandProgress::State::Open;
    any = true;
  }
  share_.assign(model.nbody, 1);
  return any;
}

// Per island: do its impulses work? True if those of one that rebounds do.
bool Rebounds::find_gains(const System& system, Data& data) {
  const Model& model = system.model;
  const Kinematics& kin = data.state.pose.kin;
  const Attempt& attempt = data.attempt;
  std::vector<double> after(data.step.v);
  for (int i = 0; i < model.nv; i++) after[i] += data.step.spin[i];
  body_twists(model, kin, after.data(), spun_);
  work_.assign(model.nbody, 0);
  moved_.assign(model.nbody, 0);
  const auto work = [&](const Contact& c, const std::vector<Twist>& t,
                        const std::vector<double>& v) {
    const ContactVelocity u = contact_velocity(model, kin, t, v.data(), c);
    return dot(c.impulse, u.slip) + dot(c.impulse, c.n) * dot(c.n, u.point - u.slip);
  };
  for (const Contact& c : attempt.contacts) {
    if (norm2(c.impulse) == 0 || c.pair >= (int)attempt.candidates.size()) continue;
    const int island = data.islands.of(system, attempt.candidates[c.pair]);
    const double before = work(c, arrived_, before_);
    const double now = work(c, spun_, after);
    work_[island] += 0.5 * (before + now);
    moved_[island] += std::fabs(before) + std::fabs(now);
  }
  bool any = false;
  for (const Contact& c : attempt.contacts)
    if (c.rebound > 0) {
      const int island = data.islands.of(system, attempt.candidates[c.pair]);
      any |= work_[island] > tune::kWorkRounding * moved_[island];
    }
  return any;
}

void Rebounds::scale(const System& system, Data& data, const std::vector<double>& share) {
  for (Contact& c : data.attempt.contacts) {
    if (c.rebound == 0) continue;
    const int island = data.islands.of(system, data.attempt.candidates[c.pair]);
    c.bounce += (share[island] - share_[island]) * c.rebound;
  }
  share_ = share;
}

void Rebounds::bound_energy(const System& system, Data& data, const std::function<void()>& solve) {
  data.islands.find(system, data.attempt.candidates);
  if (!find_gains(system, data)) return;
  std::vector<double> good(share_.size(), 0), bad(share_), next(share_);
  const auto gains = [&](size_t b) { return work_[b] > tune::kWorkRounding * moved_[b]; };
  std::vector<char> cut(share_.size(), 0);
  std::vector<size_t> closed;  // meanwhile
  for (size_t b = 0; b < cut.size(); b++) {
    cut[b] = gains(b);
    if (cut[b] || !data.attempt.islands[b].open()) continue;
    closed.push_back(b);
    data.attempt.islands[b].state = IslandProgress::State::Stuck;
  }
  for (int k = 0; k < tune::kEnergyBisections; k++) {
    for (size_t b = 0; b < cut.size(); b++)
      if (cut[b]) next[b] = 0.5 * (good[b] + bad[b]);
    scale(system, data, next);
    solve();
    find_gains(system, data);
    for (size_t b = 0; b < cut.size(); b++)
      if (cut[b]) (gains(b) ? bad[b] : good[b]) = next[b];
  }
  for (size_t b = 0; b < cut.size(); b++)
    if (cut[b]) next[b] = good[b];
  scale(system, data, next);
  solve();
  for (const size_t b : closed) data.attempt.islands[b].state = IslandProgress::State::Open;
}

}  // namespace hp
