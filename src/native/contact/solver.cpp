#include "contact/solver.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "math/simd.h"
#include "tuning.h"

namespace hp {

namespace tune = tuning::contact;

Vec3 endpoint_velocity(const Model& m, const Kinematics& k, const std::vector<Twist>& twists,
                       const double* qvel, const Endpoint& e) {
  Vec3 v;
  for (int i = 0; i < e.count; i++) {
    const Twist& t = twists[e.body[i]];
    v += e.weight[i] * (t.v + cross(t.w, e.point[i] - k.reference(m, e.body[i])));
  }
  if (e.bends)
    for (const Endpoint::Bend& b : *e.bends) v += qvel[b.dof] * b.rate;
  return v;
}

Vec3 endpoint_turn(const std::vector<Twist>& twists, const Endpoint& e) {
  Vec3 w;
  for (int i = 0; i < e.count; i++) w += e.weight[i] * twists[e.body[i]].w;
  return w;
}

ContactVelocity contact_velocity(const Model& m, const Kinematics& k,
                                 const std::vector<Twist>& twists, const double* qvel,
                                 const Contact& c) {
  const Vec3 u =
      endpoint_velocity(m, k, twists, qvel, c.a) - endpoint_velocity(m, k, twists, qvel, c.b);
  if (norm2(c.inward) == 0) return {u, u};
  return {u, u + cross(endpoint_turn(twists, c.a) - endpoint_turn(twists, c.b), c.inward)};
}

// What acts on the bodies that carry an endpoint where a contact's three impulses are one.
void ContactSolver::push(const System& s, const Endpoint& e, double sign, const Contact& c) {
  const Vec3 axis[3] = {c.n, c.t, c.s};
  for (int l = 0; l < e.count; l++) {
    const int b = e.body[l];
    if (s.m.pushed_dof(b) < 0) continue;
    const Vec3 r = e.point[l] - s.k.reference(s.m, b), slips = r + c.inward;
    Vec3 moment[3], force[3];
    for (int q = 0; q < 3; q++) {
      force[q] = sign * e.weight[l] * axis[q];
      moment[q] = cross(q == 0 ? r : slips, force[q]);
    }
    half_.add_wrench(b, moment, force);
  }
  if (!e.bends) return;
  for (const Endpoint::Bend& b : *e.bends) {
    double force[3];
    for (int q = 0; q < 3; q++) force[q] = sign * dot(axis[q], b.rate);
    half_.add_force(s.m, b.dof, force);
  }
}

// The row of Y of a contact, and its blocks of the Delassus operator with all rows that there are.
void ContactSolver::join(const System& s, const Contact& c, int contact) {
  joined_[contact] = 1;
  Row row;
  row.contact = contact;
  row.first = (int)dof_.size();
  push(s, c.a, 1, c);
  push(s, c.b, -1, c);
  half_.sweep(s.m, s.inertia, dof_, y_);
  row.count = (int)dof_.size() - row.first;
  problem_.A.reserve((int)rows_.size() + 1, (int)rows_.size());
  rows_.push_back(row);
  fill_blocks((int)rows_.size() - 1);

  // The end of a joint's range has one row only; the other two get something regular to divide by.
  const int n = (int)rows_.size() - 1;
  const size_t stride = problem_.A.stride();
  if (c.a.count == 0 && c.b.count == 0)
    for (int q = 1; q < 3; q++) problem_.A.block(n, n)[q * stride + q] += problem_.A.block(n, n)[0];
  if (c.compliance > 0) problem_.A.block(n, n)[0] += c.compliance;
  const double warm[3] = {dot(c.n, c.impulse), dot(c.t, c.impulse), dot(c.s, c.impulse)};
  problem_.add(&demand_[3 * contact], warm, c.friction, c.pair);
}

// A = Y Y^T: the blocks of row n with itself and the rows before it.
void ContactSolver::fill_blocks(int n) {
  const Row& row = rows_[n];
  const size_t stride = problem_.A.stride();
  for (int i = row.first; i < row.first + row.count; i++)
    for (int q = 0; q < 3; q++) scatter_[4 * dof_[i] + q] = y_[4 * i + q];
  problem_.budget.spend(tune::kJoinWork + 4.0 * y_.size());
  for (int j = 0; j <= n; j++) {
    const Row& other = rows_[j];
    double s[12];
    meet(scatter_.data(), &dof_[other.first], &y_[4 * (size_t)other.first], other.count, s);
    for (int p = 0; p < 3; p++)
      for (int q = 0; q < 3; q++) {
        problem_.A.block(n, j)[p * stride + q] = s[4 * p + q];
        problem_.A.block(j, n)[q * stride + p] = s[4 * p + q];
      }
  }
  for (int i = row.first; i < row.first + row.count; i++)
    for (int q = 0; q < 3; q++) scatter_[4 * dof_[i] + q] = 0;
}

// dv = M^-1 J^T p = L^-1 D^-1/2 Y^T p, into dv_, and the bodies' twists that it makes.
void ContactSolver::response(const System& s) {
  const Model& m = s.m;
  std::fill(dv_.begin(), dv_.end(), 0.0);
  for (int i = 0; i < (int)rows_.size(); i++) {
    const double* p = &problem_.p[3 * i];
    if (p[0] == 0) continue;
    for (int e = rows_[i].first; e < rows_[i].first + rows_[i].count; e++)
      dv_[dof_[e]] += y_[4 * e] * p[0] + y_[4 * e + 1] * p[1] + y_[4 * e + 2] * p[2];
  }
  s.inertia.half_solve_back(m, dv_.data(), response_);
}

// Does a contact need an impulse that says that there is no room?
bool ContactSolver::crushes(const Island& at) const {
  double asked = 0, most = 0;
  for (int l = 0; l < at.count; l++) asked = std::max(asked, -demand_[3 * at.contact[l]]);
  for (size_t i = 0; i < rows_.size(); i++) most = std::max(most, problem_.p[3 * i]);
  return most > tune::kCrushing * at.mass * asked;
}

// The worst contacts of every pair, two at most at a time, of those that do not take part, into worst_.
// `violation` says how far a contact is from its demand [m/s], negative where it is violated.
template <typename Violation>
void ContactSolver::find_worst(const Island& at, const std::vector<Contact>& contacts,
                               const Violation& violation) {
  worst_.clear();
  for (int l = 0; l < at.count; l++) {
    const int i = at.contact[l], pair = contacts[i].pair;
    if (joined_[i]) continue;
    const double v = violation(i);
    if (v >= -tune::kJoinShare * at.tolerance) continue;
    int* rival = &worst_of_pair_[2 * pair];
    if (rival[1] < 0) {
      rival[rival[0] < 0 ? 0 : 1] = (int)worst_.size();
      worst_.push_back({i, pair, v});
      continue;
    }
    Waiting& least = worst_[rival[worst_[rival[1]].violation > worst_[rival[0]].violation]];
    if (v < least.violation) least = {i, pair, v};
  }
  for (const Waiting& w : worst_) worst_of_pair_[2 * w.pair] = worst_of_pair_[2 * w.pair + 1] = -1;
}

// They join, the worst first where the budget may end before the last of them. True if any did.
template <typename Violation>
bool ContactSolver::join_worst(const System& s, const Island& at,
                               const std::vector<Contact>& contacts, const Violation& violation) {
  find_worst(at, contacts, violation);
  shut_out_ = false;
  const size_t before = rows_.size();
  if (before + worst_.size() > (size_t)tune::kManyJoined)
    std::stable_sort(worst_.begin(), worst_.end(),
                     [](const Waiting& a, const Waiting& b) { return a.violation < b.violation; });
  for (const Waiting& w : worst_) {
    shut_out_ = !has_room() || problem_.budget.spent();
    if (shut_out_) break;
    join(s, contacts[w.contact], w.contact);
  }
  return rows_.size() > before;
}

// The same in view of the impulses that there are.
bool ContactSolver::join_violated(const System& s, const Island& at,
                                  const std::vector<Contact>& contacts) {
  response(s);
  return join_worst(s, at, contacts, [&](int i) {
    const Contact& c = contacts[i];
    return demand_[3 * i] + dot(c.n, endpoint_velocity(s.m, s.k, response_, dv_.data(), c.a) -
                                         endpoint_velocity(s.m, s.k, response_, dv_.data(), c.b));
  });
}

// The contacts that carried something in the substep before, and those that are violated in spite of
// them. True if there are any of the former.
bool ContactSolver::join_first(const System& s, const Island& at,
                               const std::vector<Contact>& contacts) {
  for (int l = 0; l < at.count && has_room(); l++) {
    const int i = at.contact[l];
    if (norm2(contacts[i].impulse) > 0) join(s, contacts[i], i);
  }
  const bool any = !rows_.empty();
  if ((int)rows_.size() == at.count) return any;
  if (any)
    join_violated(s, at, contacts);
  else
    join_worst(s, at, contacts, [&](int i) { return demand_[3 * i]; });
  return any;
}

// Calls each(body) for the bodies that the contacts of an island lie on.
template <typename Each>
static void for_bodies(const std::vector<Contact>& contacts, const int* ids, int n,
                       const Each& each) {
  for (int l = 0; l < n; l++)
    for (const Endpoint* e : {&contacts[ids[l]].a, &contacts[ids[l]].b})
      for (int q = 0; q < e->count; q++) each(e->body[q]);
}

// Solves one island; the impulses of its contacts are then those of the answer.
void ContactSolver::solve_island(const System& s, const Island& at, std::vector<Contact>& contacts,
                                 SolveReport& report) {
  const Model& m = s.m;
  rows_.clear();
  dof_.clear();
  y_.clear();
  problem_.clear(at.budget);
  problem_.settles = true;
  for (int l = 0; l < at.count; l++) {
    const Contact& c = contacts[at.contact[l]];
    const bool range = c.a.count == 0 && c.b.count == 0;  // of a joint: no body is inside another
    problem_.settles &= range || (c.dist >= 0 && c.closing == 0);
  }
  shut_out_ = false;
  // Roughly while others may join, then properly. What carried something before mostly does so again,
  // and no other: it is solved for properly at once.
  bool rough = !join_first(s, at, contacts);
  // Objects that rest on objects must not creep by what a tolerance allows.
  bool objects = true, squeezed = false;  // by a body on a track
  for_bodies(contacts, at.contact, at.count, [&](int b) {
    objects &= m.last_dof[b] < 0 || m.row_size[m.last_dof[b]] <= 6;
    squeezed |= at.mass > 0 && m.held[b] != 0;
  });
  const double fine = (objects ? tune::kRestGoal : tune::kSettleGoal) * at.tolerance;
  const double roughly = tune::kRoughGoal * at.tolerance;
  SolveReport mine;
  answered_ = false;
  for (int round = 0;; round++) {
    rough = rough && round < tune::kJoinRounds && (int)rows_.size() < at.count;
    problem_.solve(rough ? roughly : at.tolerance, rough ? roughly : fine, at.max_sweeps, mine);
    if (squeezed && crushes(at)) {
      report.crushed = true;
      break;
    }
    if (round >= tune::kJoinRounds || (int)rows_.size() == at.count || mine.exhausted) break;
    const bool joined = join_violated(s, at, contacts);
    answered_ = !joined && !rough;
    if (answered_) break;
    rough = joined;
  }
  report.exhausted |= mine.exhausted || shut_out_;
  report.work += problem_.budget.work();
  report.crushed |= squeezed && mine.normal > tune::kUnsolved * at.tolerance;
  for (int l = 0; l < at.count; l++) contacts[at.contact[l]].impulse = {};
  for (size_t i = 0; i < rows_.size(); i++) {
    Contact& c = contacts[rows_[i].contact];
    const double* p = &problem_.p[3 * i];
    c.impulse = p[0] * c.n + p[1] * c.t + p[2] * c.s;
  }
  report.sweeps += mine.sweeps;
  report.points += (int)rows_.size();
  report.residual = std::max(report.residual, mine.residual);
  report.friction = std::max(report.friction, mine.friction);
}

// beta of every contact: its velocity without contact, less the normal velocity that it demands.
void ContactSolver::find_demands(const System& s, double h, const double* v_free,
                                 const std::vector<Contact>& contacts) {
  demand_.resize(3 * contacts.size());
  body_twists(s.m, s.k, v_free, twists_);
  int pairs = 0;
  for (const Contact& c : contacts) pairs = std::max(pairs, c.pair + 1);
  worst_of_pair_.resize(2 * (size_t)std::max(pairs, (int)worst_of_pair_.size() / 2), -1);
  for (size_t i = 0; i < contacts.size(); i++) {
    const Contact& c = contacts[i];
    const ContactVelocity u = contact_velocity(s.m, s.k, twists_, v_free, c);
    demand_[3 * i] =
        dot(c.n, u.point) -
        (c.compliance > 0 ? c.yielding : std::max((c.target - c.dist + c.shift) / h, c.bounce));
    demand_[3 * i + 1] = dot(c.t, u.slip + h * c.curve);
    demand_[3 * i + 2] = dot(c.s, u.slip + h * c.curve);
  }
}

// Islands are trees that contacts connect: root_island_ (by body) is a forest over the trees' roots.
// order_ has the contacts of one island after the other.
void ContactSolver::find_islands(const Model& m, const std::vector<Contact>& contacts) {
  root_island_.resize(m.nbody);
  std::iota(root_island_.begin(), root_island_.end(), 0);
  for (const Contact& c : contacts)
    for (const Endpoint* e : {&c.a, &c.b})
      for (int l = 0; l < e->count; l++)
        if (m.pushed_dof(e->body[l]) >= 0)
          root_island_[island_of(m.root[e->body[l]])] = island_of(any_root(m, c));
  order_.resize(contacts.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::stable_sort(order_.begin(), order_.end(), [&](int i, int j) {
    return island_of(any_root(m, contacts[i])) < island_of(any_root(m, contacts[j]));
  });
}

int ContactSolver::island_of(int root) {
  int b = root;
  while (root_island_[b] != b) b = root_island_[b] = root_island_[root_island_[b]];
  return b;
}

// The root of a tree that a contact pushes.
int ContactSolver::any_root(const Model& m, const Contact& c) {
  for (const Endpoint* e : {&c.a, &c.b})
    for (int l = 0; l < e->count; l++)
      if (m.pushed_dof(e->body[l]) >= 0) return m.root[e->body[l]];
  // The end of a joint's range moves with that joint alone.
  return c.a.bends ? m.root[m.dof_body[c.a.bends->front().dof]] : 0;
}

SolveReport ContactSolver::solve(const Model& m, const Kinematics& k, const InertiaFactor& inertia,
                                 double h, const double* v_free, double* v,
                                 std::vector<Contact>& contacts, double tolerance, int max_sweeps,
                                 double mass, double budget) {
  const System s{m, k, inertia};
  const int n = (int)contacts.size();
  std::memcpy(v, v_free, sizeof(double) * m.nv);
  SolveReport report;
  if (n == 0) return report;
  half_.begin(m);
  joined_.assign(n, 0);
  scatter_.resize(4 * (size_t)m.nv, 0.0);
  dv_.resize(m.nv);
  find_demands(s, h, v_free, contacts);
  find_islands(m, contacts);
  const auto island = [&](int i) { return island_of(any_root(m, contacts[order_[i]])); };
  for (int first = 0; first < n;) {
    int last = first + 1;
    while (last < n && island(last) == island(first)) last++;
    solve_island(s, {&order_[first], last - first, tolerance, max_sweeps, mass, budget}, contacts,
                 report);
    if (!answered_) response(s);
    for (int i = 0; i < m.nv; i++) v[i] += dv_[i];
    first = last;
  }
  return report;
}

}  // namespace hp
