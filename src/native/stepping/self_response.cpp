#include "stepping/self_response.h"

#include "tuning.h"

namespace hp {

namespace tune = tuning::stepping;

bool SelfResponse::is_own(const System& system, const Attempt& attempt, const Contact& c) const {
  if (c.pair >= (int)attempt.candidates.size()) return false;  // no candidate's row
  const ContactCandidate& k = attempt.candidates[c.pair];
  return k.other_shape >= 0 && system.tree(k.shape) == system.tree(k.other_shape);
}

void SelfResponse::find_own(const System& system, const Attempt& attempt,
                            const std::vector<Contact>& contacts) {
  const Model& model = system.model;
  own_.clear();
  touches_.assign(model.nbody, 0);
  for (const Contact& c : contacts)
    if (is_own(system, attempt, c))
      own_.push_back(c), touches_[system.tree(attempt.candidates[c.pair].shape)] = 1;
  for (int b = 1; b < model.nbody; b++) touches_[b] = touches_[model.root[b]];
}

// Frees the dofs by which two bodies of one person make room: those of the limbs that touch or,
// `whole`, of all joints between the two.
void SelfResponse::make_room(const Model& m, int a, int b, bool whole) {
  const double most = tune::kLimbMass * m.carried[m.root[a]];
  // Parents come before their children.
  int meet[2] = {a, b};
  while (meet[0] != meet[1]) {
    int& later = meet[meet[0] < meet[1]];
    later = m.parent[later];
  }
  const int ends[2] = {a, b}, common = meet[0];
  int top[2] = {0, 0};  // of each limb; 0: none
  for (int side = 0; side < 2; side++)
    for (int j = ends[side]; j != common && (whole || m.carried[j] <= most); j = m.parent[j])
      top[side] = j;
  for (int side = 0; side < 2; side++) {
    const int other = top[1 - side];
    if (!top[side]) continue;
    if (!whole && other && m.carried[top[side]] > tune::kLighterLimb * m.carried[other]) continue;
    for (int j = ends[side];; j = m.parent[j]) {
      std::fill_n(free_.begin() + m.dof_first[j], m.dof_count[j], 1);
      if (j == top[side]) break;
    }
  }
}

// X of M^, and more for fingers while shapes separate: hands leave as a whole, fingers are light
// and would be flung.
std::vector<double> SelfResponse::resistance(const System& system, const Data& data) const {
  const Model& model = system.model;
  std::vector<double> resist = data.inertia.added();
  bool leaves = false;
  for (const Contact& c : own_) leaves |= system.self_overlap(data.attempt.candidates[c.pair]);
  for (int i = 0; leaves && i < model.nv; i++) {
    const int b = model.dof_body[i];
    if (model.carried[b] < tune::kFingerMass * model.carried[model.root[b]])
      resist[i] += tune::kFingerResistance;
  }
  return resist;
}

bool SelfResponse::met(const System& system, const State& state, double h) {
  body_twists(system.model, state.pose.kin, v_.data(), twists_);
  bool met = true;
  for (const Contact& c : own_)
    met &= c.dist + h * approach(system.model, state.pose.kin, c, twists_, v_) - c.shift >=
           c.target - tune::kSelfContactMiss;
  return met;
}

namespace {

// f += J^T p.
void add_impulse(const Model& model, const Kinematics& kin, const Contact& c,
                 std::vector<double>& f) {
  for (int side = 0; side < 2; side++) {
    const Endpoint& e = side == 0 ? c.a : c.b;
    const Vec3 p = side == 0 ? c.impulse : -c.impulse;
    for (int l = 0; l < e.count; l++) {
      const int b = e.body[l], last = model.pushed_dof(b);
      if (last < 0) continue;
      const Vec3 linear = e.weight[l] * p, normal = e.weight[l] * dot(p, c.n) * c.n;
      const Vec3 moment =
          cross(e.point[l] - kin.reference(model, b), linear) + cross(c.inward, linear - normal);
      const int* dof = &model.chain[model.row_start[last]];
      for (int a = 0; a < model.row_size[last]; a++) {
        const Twist& axis = kin.cdof[dof[a]];
        f[dof[a]] += dot(moment, axis.w) + dot(linear, axis.v);
      }
    }
    if (e.bends)
      for (const Endpoint::Bend& b : *e.bends) f[b.dof] += dot(p, b.rate);
  }
}

}  // namespace

void SelfResponse::find_impulse(const System& system, const Data& data) {
  impulse_.assign(system.model.nv, 0.0);
  for (const Contact& c : own_) add_impulse(system.model, data.state.pose.kin, c, impulse_);
}

bool SelfResponse::solve(const System& system, Data& data, const std::vector<Contact>& contacts,
                         double tolerance, ContactSolver& solver, double h) {
  const Model& model = system.model;
  const Attempt& attempt = data.attempt;
  find_own(system, attempt, contacts);
  if (own_.empty()) return false;
  v_.resize(model.nv);
  const std::vector<double> resist = resistance(system, data);
  for (const bool whole : {false, true}) {
    free_.assign(model.nv, 0);
    for (const Contact& c : own_) {
      const ContactCandidate& k = attempt.candidates[c.pair];
      make_room(model, system.world.shapes[k.shape].body, system.world.shapes[k.other_shape].body,
                whole);
    }
    factor_.factor(model, data.inertia.inertia(), data.inertia.scale(), resist, touches_.data(),
                   free_.data());
    const SolveReport r =
        solver.solve(model, data.state.pose.kin, factor_, h, data.step.v_free.data(), v_.data(),
                     own_, tolerance, system.world.settings.max_sweeps, 0, data.budget.solve());
    data.budget.spend(r.work);
    data.result.diagnostics.sweeps += r.sweeps;
    friction_ = r.friction;
    if (!met(system, data.state, h)) continue;
    find_impulse(system, data);
    return true;
  }
  return false;
}

void SelfResponse::brace(const System& system, const Data& data, std::vector<double>& out) {
  const int nv = system.model.nv;
  change_.resize(nv), momentum_.resize(nv), out.resize(nv, 0);
  for (int i = 0; i < nv; i++) change_[i] = v_[i] - data.step.v_free[i];
  const std::vector<double>&scale = data.inertia.scale(), &added = data.inertia.added();
  for (const Drive& d : system.drives) {
    if (!touches_[d.body(0)]) continue;
    data.inertia.multiply(system, d, change_.data(), momentum_.data());
    for (int i = d.first_dof(); i < d.first_dof() + d.dof_count(); i++)
      out[i] = free_[i] ? 0 : scale[i] * (momentum_[i] + added[i] * change_[i]) - impulse_[i];
  }
}

const std::vector<double>& SelfResponse::without_own(const System& system, const Data& data) {
  data.inertia.solve(system.model, impulse_.data());
  for (int i = 0; i < system.model.nv; i++) v_[i] -= impulse_[i];
  return v_;
}

}  // namespace hp
