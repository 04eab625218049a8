// How a person gives way to contact with itself: where the two touch, and nowhere else.
//
// What is inside a person cannot push all of it, and the motion says where everything goes that nothing is
// in the way of. With M^^-1 a hand on the chest would tilt the trunk, swing the legs and move the root, all
// by a little. So what a person does to itself is solved for first, of all dofs those of the limbs that
// touch free to move: v' = v* + G J^T p, G the inverse of M^ cut down to those dofs, zero elsewhere. What
// the world does to the person goes through M^^-1 as always, and changes what it does to itself: all
// contacts are then solved for together, from v' - M^^-1 J^T p, with p known to answer if nothing else
// pushes. That is symmetric, with Coulomb's conditions on the sum.
//
// With Algorithm 1 a person's own torques (PJSC) push all of it, and so does what they press on.
#include "stepping/stepper.h"

namespace hp {

namespace {

// What carries more of the person than this is trunk, which follows the motion.
constexpr double kLimb = 0.25;
// Of two limbs the lighter one gives way alone where the other has so many times its mass.
constexpr double kHeavier = 2;
// What carries less of the person than this is as hard to bend as if it had so much more inertia [kg m^2],
// while something leaves.
constexpr double kLight = 0.003, kStiff = 0.05;
constexpr double kUnmet = 1e-5;  // demands that miss this cannot be met by the dofs that gave way [m]

}  // namespace

bool Stepper::touches_itself(const Contact& c) const {
  if (c.pair >= (int)candidates_.size()) return false;  // a joint's limit
  const ContactCandidate& k = candidates_[c.pair];
  return k.other_shape >= 0 && tree(k.shape) == tree(k.other_shape);
}

// Frees the dofs by which two bodies of one person make room: those of the limbs that touch or, `whole`,
// of all joints between the two.
void Stepper::make_room(int a, int b, bool whole) {
  const double most = kLimb * model.carried[model.root[a]];
  // Parents come before their children.
  int meet[2] = {a, b};
  while (meet[0] != meet[1]) {
    int& later = meet[meet[0] < meet[1]];
    later = model.parent[later];
  }
  const int ends[2] = {a, b}, common = meet[0];
  int top[2] = {0, 0};  // of each limb; 0: none
  for (int side = 0; side < 2; side++)
    for (int j = ends[side]; j != common && (whole || model.carried[j] <= most); j = model.parent[j])
      top[side] = j;
  for (int side = 0; side < 2; side++) {
    const int other = top[1 - side];
    if (!top[side]) continue;
    if (!whole && other && model.carried[top[side]] > kHeavier * model.carried[other]) continue;
    for (int j = ends[side];; j = model.parent[j]) {
      std::fill_n(gives_.begin() + model.dof_first[j], model.dof_count[j], 1);
      if (j == top[side]) break;
    }
  }
}

// Solves for what people do to themselves alone: v_self_, and the impulses of own_. False if nobody touches
// itself, or if it takes more than the joints between.
bool Stepper::solve_self(double h) {
  own_.clear();
  std::vector<char> touched(model.nbody, 0);
  for (const Contact& c : contacts_)
    if (touches_itself(c)) own_.push_back(c), touched[tree(candidates_[c.pair].shape)] = 1;
  if (own_.empty()) return false;
  for (int b = 1; b < model.nbody; b++) touched[b] = touched[model.root[b]];
  v_self_.resize(model.nv);
  // Hands leave as a whole: fingers are light and would be flung.
  std::vector<double> resist = resist_;
  bool leaves = false;
  for (const Contact& c : own_) leaves |= leaves_itself(candidates_[c.pair]);
  for (int i = 0; leaves && i < model.nv; i++) {
    const int b = model.dof_body[i];
    if (model.carried[b] < kLight * model.carried[model.root[b]]) resist[i] += kStiff;
  }
  giving_.M = inertia_.M;
  for (const bool whole : {false, true}) {
    gives_.assign(model.nv, 0);
    for (const Contact& c : own_) {
      const ContactCandidate& k = candidates_[c.pair];
      make_room(world.shapes[k.shape].body, world.shapes[k.other_shape].body, whole);
    }
    giving_.factor(model, scale_, resist, touched.data(), gives_.data());
    const SolveReport r = solver_.solve(model, start_.kin, giving_, h, v_free_.data(), v_self_.data(), own_,
                                        tolerance_ / h, world.settings.max_sweeps);
    diagnostics_.sweeps += r.sweeps;
    body_twists(model, start_.kin, v_self_.data(), self_twists_);
    bool met = true;
    for (const Contact& c : own_)
      met &= c.dist + h * approach(c, self_twists_, v_self_) - c.shift >= c.target - kUnmet;
    if (met) return true;
  }
  return false;
}

SolveReport Stepper::answer(double h) {
  const std::vector<double>* from = &v_free_;
  if (world.self_contact() && drive_settings.time_constant > 0 && solve_self(h)) {
    size_t next = 0;
    for (Contact& c : contacts_)
      if (touches_itself(c)) c.impulse = own_[next++].impulse;
    if (next == contacts_.size()) {
      v_ = v_self_;
      SolveReport r;
      r.points = (int)next;
      return r;
    }
    // As they are known, they do to all of it what they do to the limbs.
    std::vector<double>& f = pushed_;
    std::fill(f.begin(), f.end(), 0.0);
    for (const Contact& c : own_) push(c, f);
    inertia_.solve(model, f.data());
    for (int i = 0; i < model.nv; i++) v_self_[i] -= f[i];
    from = &v_self_;
  }
  return solver_.solve(model, start_.kin, inertia_, h, from->data(), v_.data(), contacts_, tolerance_ / h,
                       world.settings.max_sweeps, moving_mass());
}

// f += J^T p.
void Stepper::push(const Contact& c, std::vector<double>& f) const {
  for (int side = 0; side < 2; side++) {
    const Endpoint& e = side == 0 ? c.a : c.b;
    const Vec3 p = side == 0 ? c.impulse : -c.impulse;
    for (int l = 0; l < e.count; l++) {
      const int b = e.body[l], last = model.pushed_dof(b);
      if (last < 0) continue;
      const Vec3 linear = e.weight[l] * p;
      const Vec3 moment = cross(e.point[l] - start_.kin.reference(model, b), linear);
      const int* dof = &model.chain[model.row_start[last]];
      for (int a = 0; a < model.row_size[last]; a++) {
        const Twist& axis = start_.kin.cdof[dof[a]];
        f[dof[a]] += dot(moment, axis.w) + dot(linear, axis.v);
      }
    }
    if (e.bends)
      for (const Endpoint::Bend& b : *e.bends) f[b.dof] += dot(p, b.rate);
  }
}

}  // namespace hp
