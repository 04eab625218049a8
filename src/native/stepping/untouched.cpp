// Joints that nothing touches follow the motion.
//
// Contacts stop the part that they touch, and through M^^-1 whatever hangs on it: a body that runs into a
// wall threw its jaw and its feet about, and went on doing so while it pressed on. In M^ = s (M + X) firmness
// gives a joint lambda times its own inertia; one beyond which nothing touches gets kOwn times that. What
// contacts push gives way as before, and so do all joints between it and the root. With lambda = 0 nothing
// is held, nor with Algorithm 1, which is as the paper has it; nor is who is overcome (strength.cpp).
//
// Whoever has to do with a thing that moves, or with themselves, is not held at all: fingers close about it
// with all that they touch, one after the other, and a ball between two palms was lost where those that did
// not were held.
//
// What touches is what carries an impulse. It is first taken to be what did so lately; if solving finds
// more, that is let go and all is solved for again.
#include "stepping/stepper.h"

namespace hp {

namespace {

constexpr double kOwn = 100;

}  // namespace

// An attempt begins: touched is what contacts pushed lately.
void Stepper::forget_touched() {
  touched_.assign(model.nbody, 0);
  for (const Drive& d : drives_)
    for (int i = 1; i < d.ball_count(); i++) touched_[d.body(i)] = d.lately(i);
  factored_ = false;
}

void Stepper::for_touched(const ContactCandidate& c, const std::function<void(int)>& each) const {
  const int ends[2] = {world.shapes[c.shape].body, c.other_shape < 0 ? 0 : world.shapes[c.other_shape].body};
  for (int side = 0; side < 2; side++) {
    const int body = ends[side], other = ends[1 - side];
    if (!is_person(body)) continue;
    if (other > 0 && (!is_person(other) || model.root[other] == model.root[body])) {
      for (int b = 1; b < model.nbody; b++)
        if (model.root[b] == model.root[body]) each(b);
    }
    for (int b = body; b > 0; b = model.parent[b]) each(b);
  }
}

// Marks what contacts push now, with all that it hangs on. True if any of that was held until now: then
// let_go_ says whose it is (per body that is a root).
bool Stepper::find_touched() {
  if (drive_settings.time_constant == 0) return false;
  let_go_.assign(model.nbody, 0);
  bool found = false;
  const auto touch = [&](int b) {
    if (touched_[b]) return;
    touched_[b] = 1;
    if (model.parent[b] == 0 || model.dof_count[b] == 0 || extra_[model.dof_first[b]] == 0) return;
    let_go_[model.root[b]] = 1;
    found = true;
  };
  for (const ContactCandidate& c : candidates_)
    if (leaves_itself(c)) for_touched(c, touch);
  for (const Contact& c : contacts_) {
    if (norm2(c.impulse) == 0 || c.pair >= (int)candidates_.size()) continue;  // a joint's limit
    for_touched(candidates_[c.pair], touch);
  }
  if (found) factored_ = false;
  return found;
}

// Solves again while that finds more that is touched. Whom it does not concern keeps what was found.
SolveReport Stepper::answer_touched(double h) {
  find_touched();
  build_inertia(step_);
  SolveReport r = answer(h);
  while (find_touched()) {
    find_islands();
    std::vector<char> again(model.nbody, 0);
    for (int b = 1; b < model.nbody; b++)
      if (let_go_[b]) again[island_[b]] = 1;
    const std::vector<Contact> before = contacts_;
    const std::vector<double> v = v_;
    build_inertia(step_);
    r.sweeps += answer(h).sweeps;
    for (size_t i = 0; i < before.size(); i++)
      if (before[i].pair < (int)candidates_.size() && !again[island(candidates_[before[i].pair])])
        contacts_[i].impulse = before[i].impulse;
    for (int i = 0; i < model.nv; i++)
      if (!again[island_[model.root[model.dof_body[i]]]]) v_[i] = v[i];
  }
  return r;
}

void Stepper::hold_untouched() {
  if (drive_settings.time_constant == 0) return;
  for (size_t p = 0; p < drives_.size(); p++) {
    const Drive& d = drives_[p];
    if (!world.active[d.body(0)] || !holds_[p]) continue;
    for (int i = d.first_dof() + 6; i < d.first_dof() + d.dof_count(); i++)
      if (!touched_[model.dof_body[i]]) extra_[i] *= kOwn;
  }
}

}  // namespace hp
