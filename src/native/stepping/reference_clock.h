// The clock of a person's reference: somebody who cannot go on waits (docs/physics.md, "Who is blocked
// stops"), a reference governor (Garone, Di Cairano, Kolmanovsky 2017).
//
// With b how far the root is behind its path, along the way that the reference takes next, and while
// something touches the person, the clock runs at
//
//   rate = 1 up to b = kBehind, less and less, 0 from kBlocked on,
//
// but at kSlowest at least while the motion flies: footing puts feet in the air down. Who is on the way round
// something does not wait. Poses that were asked for meanwhile wait
// in a queue, and the person moves through it as time passes for it. Who has waited for kPatience goes
// on whatever is in the way, until back on the path. It goes on as a person starts to walk: the rate grows by
// kSpeedUp at most. A clock that never lags changes no bit.
//
// The queue is bounded, or an endless simulation would grow for ever: who lags by more than kLate and has
// nothing in the way goes at kCatchUp until the lag is less, and in the last second before kLatest waiting ends:
//
//   rate >= lag - (kLatest - 1 s), 1 at kLatest.
//
// So no pose is left out, and none waits for longer than kLatest.
//
// A clock that slows down takes velocity from the motion, and not from the body: it has its momentum until
// something outside takes it. The drive keeps what the root loses, slowed() of its velocity, as deviation
// (Drive::begin_frame); joints, whose muscles are inside, slow down with the clock.
#pragma once
#include <deque>
#include <vector>

#include "stepping/person_dofs.h"

namespace hp {

class ReferenceClock {
 public:
  bool on = false;

  // Nothing lags; the person is at `target`, its qpos.
  void reset(const PersonDofs& dofs, const double* target);
  // Time dt passes and `target` is asked for at its end. Returns the pose to aim at. `displaced`: of
  // the root from its path [m]; `touched`: something touches the person; `stands`: it could stop in the
  // pose that it is in; `round`: it is on its way round something, and does not wait.
  const double* advance(const PersonDofs& dofs, const double* target, double dt, Vec3 displaced,
                        bool touched, bool stands, bool round);
  // How far the reference is behind [s], and how much of its time has passed in this frame [s].
  double lag() const;
  double passed() const { return passed_; }
  // How fast it goes: 1 as time does, 0 where it stands, over 1 where it catches up.
  double rate() const { return rate_; }
  // Share of its pace at which the person is to go back to its path.
  double eager() const { return eager_; }
  // Share of the motion's velocity that the clock takes away in this frame.
  double slowed() const { return slowed_; }
  // Something is in its way: it waits, or goes on all the same.
  bool blocked() const { return eager_ < 1 || impatient_; }

  void save(std::vector<double>& out) const;
  const double* load(const PersonDofs& dofs, const double* in);

 private:
  struct Asked {
    std::vector<double> qpos;
    double time;  // from the pose before it [s]
  };
  void decide(Vec3 displaced, bool touched, bool stands, bool round, double dt);
  void move_on(const PersonDofs& dofs, double time);

  std::vector<double> reached_;
  std::deque<Asked> ahead_;
  double waited_ = 0, passed_ = 0, untouched_ = 0, rate_ = 1, eager_ = 1;
  double slowed_ = 0;  // of the frame under way
  bool impatient_ = false;
};

}  // namespace hp
