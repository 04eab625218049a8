// Sub-stepping: splits a step that verification rejects into shorter ones (docs/physics.md, "The
// substep", 8).
//
// A step with violations at its end pose is shortened, island by island: bisection finds the largest
// share of it after which every gap is at least ContactCandidate::hard (half of the smaller of its
// starting gap and 0.1 mm, see gap_targets.h) and no shape is beyond the reach of its
// planes. The rest of it is made in pieces, at most kMostPieces, one island after the other, while all
// others stand where they have arrived. Velocities are kept; a step of which less than a quarter is
// possible is not begun but tried at an eighth of its length. Time that is left after that is lost. A
// step at whose end the end check (end_check.h) finds an overlap is shortened likewise, whether it was
// verified or not.
#pragma once
#include "stepping/step_attempts.h"
#include "stepping/strength.h"

namespace hp {

class SubStepping {
 public:
  SubStepping(System& system, Data& data, KinematicBodies& kinematic, StepAttempts& attempts,
              StrengthLimits& strength)
      : system_(system),
        data_(data),
        kinematic_(kinematic),
        attempts_(attempts),
        strength_(strength) {}
  // After an attempt at a step of length h: commits it whole where it is good, else in pieces.
  // Returns the time that is lost [s].
  double make(double h);

 private:
  // Shares of a step that trees make, per body; empty: all make all of it. Only what was not clear at
  // a larger share is looked at while one is searched, everything where one is found.
  std::vector<double> shares(double h);
  void bisect(std::vector<double>& at, const std::vector<char>& hurt, double h);
  std::vector<char> clear(const std::vector<double>& at, double h);
  std::vector<char> possible(const std::vector<double>& at, double h);
  void move_to(const std::vector<double>& at, double h, std::vector<char>& ok);
  void check_ranges(std::vector<char>& ok) const;
  bool check_gap(size_t i, std::vector<char>& ok);
  void refuse(size_t pair, std::vector<char>& ok) const;
  void check_end(std::vector<char>& ok);
  void check_reach(std::vector<char>& ok);
  bool good();
  const std::vector<size_t>& breached();
  void measure_way();
  void stand_back(std::vector<double>& at, double h);
  bool clear_together(const std::vector<double>& share, double least, double h);
  void commit(double h, const std::vector<double>& share);
  void record(double h, const std::vector<double>& share);
  std::vector<char> longest(double h, const std::vector<double>& share);
  double go_on(double h, std::vector<double> share);
  void keep_velocity();
  double catch_up(double h, double left, bool begun);
  void activate(int island, const std::vector<int>& islands, const std::vector<char>& all,
                const std::vector<char>& stood);

  System& system_;
  Data& data_;
  KinematicBodies& kinematic_;
  StepAttempts& attempts_;
  StrengthLimits& strength_;
  std::vector<double> longest_;      // per root body: its longest piece of this substep [s]
  std::vector<double> moved_;        // velocities times shares
  std::vector<double> way_, inner_;  // per shape: travelled, and seen from the root body [m]
  uint64_t way_stamp_ = 0;           // of the end pose that they lead to
  // While shares are searched: candidates, and pairs that overlapped at the end (end_check.h), that kept
  // some share from being clear.
  std::vector<size_t> suspects_, end_suspects_;
};

}  // namespace hp
