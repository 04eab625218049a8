#include "stepping/island_response.h"

#include <algorithm>

namespace hp {

void IslandResponse::solve(const System& system, Data& data, const KinematicBodies& kinematic,
                           double h) {
  Attempt& attempt = data.attempt;
  JointResistance& resistance = data.step.resistance;
  island_.clear();
  for (const Contact& c : attempt.contacts)
    island_.push_back(c.pair < (int)attempt.candidates.size() ? attempt.candidates[c.pair].island
                                                              : data.islands.of_row(system, c));
  chosen_.assign(system.model.nbody, 0);
  for (const int k : island_) chosen_[k] = attempt.islands[k].open();
  free_unheld(system, data);
  untouched_.release(system, attempt, resistance, data.inertia);
  data.inertia.build(system, data.state, data.step, data.step.length);
  solve_islands(system, data, kinematic, h);
  while (untouched_.release(system, attempt, resistance, data.inertia)) {
    chosen_.assign(system.model.nbody, 0);
    for (int b = 1; b < system.model.nbody; b++)
      if (untouched_.released()[b]) chosen_[data.islands.of_tree(b)] = 1;
    data.inertia.build(system, data.state, data.step, data.step.length);
    solve_islands(system, data, kinematic, h);
  }
}

// Islands whose rows are gone, as those of a layer that nothing presses any more, move freely: else what the last
// solve gave them would stay, and nobody would know of it.
void IslandResponse::free_unheld(const System& system, Data& data) {
  const Model& m = system.model;
  for (int i = 0; i < m.nv; i++) {
    const int island = data.islands.of_tree(m.root[m.dof_body[i]]);
    if (!chosen_[island] && data.attempt.islands[island].open())
      data.step.v[i] = data.step.v_free[i];
  }
}

void IslandResponse::solve_islands(const System& system, Data& data,
                                   const KinematicBodies& kinematic, double h) {
  for (int k = 0; k < system.model.nbody; k++)
    if (chosen_[k] && data.attempt.islands[k].open())
      solve_island(system, data, k, kinematic.pushable_mass(system, data.islands, k), h);
}

void IslandResponse::solve_island(const System& system, Data& data, int island, double mass,
                                  double h) {
  std::vector<Contact>& all = data.attempt.contacts;
  IslandProgress& progress = data.attempt.islands[island];
  const bool whole = std::count(island_.begin(), island_.end(), island) == (long)all.size();
  SolveReport r;
  const Model& m = system.model;
  std::vector<double>& braced = data.step.braced;
  for (size_t i = 0; i < braced.size(); i++)
    if (data.islands.of_tree(m.root[m.dof_body[i]]) == island) braced[i] = 0;
  if (whole) {
    r = respond(system, data, all, progress.tolerance, mass, h, data.step.v);
  } else {
    own_.clear();
    for (size_t i = 0; i < all.size(); i++)
      if (island_[i] == island) own_.push_back(all[i]);
    v_.resize(data.step.v.size());
    r = respond(system, data, own_, progress.tolerance, mass, h, v_);
    for (size_t i = 0, next = 0; i < all.size(); i++)
      if (island_[i] == island) all[i].impulse = own_[next++].impulse;
    for (int i = 0; i < m.nv; i++)
      if (data.islands.of_tree(m.root[m.dof_body[i]]) == island) data.step.v[i] = v_[i];
  }
  progress.crushed = r.crushed;
  progress.work += r.work;
  progress.friction = r.friction;
  data.result.diagnostics.sweeps += r.sweeps;
}

SolveReport IslandResponse::respond(const System& system, Data& data,
                                    std::vector<Contact>& contacts, double tolerance, double mass,
                                    double h, std::vector<double>& v) {
  const std::vector<double>* from = &data.step.v_free;
  if (system.world.self_contact() && system.drive_settings.time_constant > 0 &&
      self_.solve(system, data, contacts, tolerance / h, solver_, h)) {
    size_t next = 0;
    for (Contact& c : contacts)
      if (self_.is_own(system, data.attempt, c)) c.impulse = self_.own()[next++].impulse;
    self_.brace(system, data, data.step.braced);
    if (next == contacts.size()) {
      v = self_.velocity();
      SolveReport r;
      r.points = (int)next;
      r.friction = self_.friction();
      return r;
    }
    from = &self_.without_own(system, data);
  }
  const SolveReport r = solver_.solve(system.model, data.state.pose.kin, data.inertia.factor(), h,
                                      from->data(), v.data(), contacts, tolerance / h,
                                      system.world.settings.max_sweeps, mass, data.budget.solve());
  data.budget.spend(r.work);
  return r;
}

}  // namespace hp
