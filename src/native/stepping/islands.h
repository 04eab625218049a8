// Islands: trees that contact candidates connect (as in Bullet and Jolt). What one island does
// changes nothing in another, not a bit: each is solved with the tolerance and the passes
// that are its own, clearances are given up, and steps shortened, island by island.
//
// Union-find over the trees' root bodies. Only active trees connect: inactive ones stand where they
// are, like static geometry.
#pragma once
#include <limits>
#include <vector>

#include "stepping/system.h"

namespace hp {

// How far an island has come in an attempt.
struct IslandProgress {
  enum class State : char {
    Settled,  // no candidate is violated
    Open,     // to be solved (again)
    Stuck     // it does not settle: its step is to be shortened
  };
  State state = State::Open;
  bool violated = false;       // a candidate is, at the end pose
  double work = 0;             // of the attempt: solves and checks [multiplications]
  int pass = 0;                // solves since the attempt began, or since its clearance gave way
  int stale = 0;               // passes in a row that have not halved `overdue`
  double tolerance = 0;        // of solving [m]
  double worst = 0;            // its largest violation [m], negative
  double overdue = 0;          // its largest violation that solving should have cured [m]
  double least = 0, mark = 0;  // `overdue` at its least since then, and when it was last halved
  double friction = 0;         // what its last solve missed of friction's law [m/s]
  bool ranges_known = false;   // no more rows of joints' ranges are made
  bool ranges_gave = false;    // those that there are have given way in this attempt
  bool crushed = false;        // solving found that a kinematic body leaves others no room

  bool open() const { return state == State::Open; }
  void begin() {
    pass = stale = 0;
    least = mark = std::numeric_limits<double>::infinity();
  }
};

class Islands {
 public:
  void find(const System& system, const std::vector<ContactCandidate>& candidates);
  // The island of the tree with this root body; islands are named by one of their root bodies.
  int of_tree(int root) const { return island_[root]; }
  // The island of a candidate: that of its active side.
  int of(const System& system, const ContactCandidate& c) const {
    const int a = system.tree(c.shape);
    return island_[system.world.active[a] ? a : system.tree(c.other_shape)];
  }
  // The island of a row of a joint's range.
  int of_limit(const System& system, const Contact& limit) const {
    return island_[system.model.root[system.model.dof_body[limit_dof(limit)]]];
  }
  // The island of a row that has no candidate: of a joint's range, or on one body.
  int of_row(const System& system, const Contact& row) const {
    return row.a.count > 0 ? island_[system.model.root[row.a.body[0]]] : of_limit(system, row);
  }
  const std::vector<int>& all() const { return island_; }

 private:
  std::vector<int> island_;  // per body
};

}  // namespace hp
