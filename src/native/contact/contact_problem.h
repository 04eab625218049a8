// The contacts of one island, with Coulomb friction, in contact space.
//
// Each contact has three rows: along its normal n and two tangents t, s. The Delassus operator
//     A = J M^-1 J^T                                                                [1/kg]
// (J: from velocities of the joints to relative velocities at the contacts, M: inertia, both in
// solver.h) says how impulses p [N s] change the relative velocities w [m/s]:
//     w = beta + A p,
// where beta is the velocity without contact, less what the contact demands. Wanted is p with, for
// every contact,
//     0 <= p_n,  w_n >= 0,  p_n w_n = 0             (no penetration, no pull)
//     |p_t| <= mu p_n,  and where w_t is not zero  p_t = -mu p_n w_t / |w_t|.
//
// Method: rounds of two things until the residual is under the tolerance,
//   1. block sweeps (Gauss-Seidel): each contact in turn is solved exactly (coulomb.h), the contacts
//      of one pair among themselves first. Sweeps find which contacts carry and which slip;
//   2. damped Newton steps, which then end it: see newton.cpp.
// Up to kEvenContacts contacts Newton steps are tried first. A sweep leaves those that it solves first something
// else than those that it solves last, within the tolerance, and what it leaves grows: mirrored, where left
// and right come in the other order, people who lie or sit on two points ended 0.7 mm elsewhere.
// Friction on redundant contacts may be slow to settle, and near jamming the merit has valleys that
// end nowhere. What is left over kEnough tolerances is solved by rounds from nothing, then by a path
// through smoothed problems (coulomb_path.h). Where the normal rows are not settled even so, friction
// is held and the normal impulses are solved for alone, by principal pivoting: see
// normal_impulses.cpp. Nothing penetrates then, and the next substep starts from these impulses.
//
// Residuals are velocities [m/s]: of the normal rows |min(w_n, A_nn p_n)|; of friction how far the
// projection of p_t - k w_t onto the disc of radius mu p_n is from p_t, divided by k (the inverse of
// the largest eigenvalue of the contact's tangential block). The merit is the sum of their squares.
//
// Sources: Alart and Curnier 1991 (the natural map and its derivative); Levenberg 1944 and Marquardt
// 1963 (damping); Grippo, Lampariello and Lucidi 1986 (steps that may get worse for a while); Judice
// and Pires 1994 (block principal pivoting). Constants: tuning.h, section contact.
#pragma once
#include <vector>

#include "contact/coulomb.h"
#include "contact/coulomb_path.h"
#include "contact/delassus.h"
#include "contact/work_budget.h"

namespace hp {

struct SolveReport {
  int sweeps = 0;        // block sweeps and Newton steps
  int points = 0;        // contacts that took part
  double residual = 0;   // largest violation, friction's included [m/s]
  double friction = 0;   // largest violation of Coulomb's law of friction [m/s]
  double normal = 0;     // largest violation of w_n, p_n >= 0 and p_n w_n = 0 [m/s]
  double work = 0;       // what it cost [multiplications]
  bool crushed = false;  // a body on a track leaves others no room: given up
  // The budget of rows or of work ended before the tolerance was reached; nothing was given up else.
  bool exhausted = false;
};

// Contacts may join after a solve: A grows, p stays as the warm start.
class ContactProblem {
 public:
  Delassus A;
  std::vector<double> beta, p;  // 3 per contact
  WorkBudget budget;            // of all solves since clear()
  // Friction that rounds do not settle is solved for anew. Not among bodies inside each other, which
  // it would wedge: there it is dropped.
  bool settles = true;

  int size() const { return (int)local_.size(); }
  void clear(double most_work);
  // Another contact: the caller has reserved room and filled the blocks of A, (n, 0..n) and (0..n, n).
  // Contacts of one `pair` are settled among themselves before a sweep goes on: they lie close
  // together and are the slowest to agree.
  void add(const double* beta3, const double* warm3, double mu, int pair);

  // Stops at `tolerance` [m/s] or after `most` sweeps and steps, and takes the best of them. At first
  // it aims at `fine` [m/s] instead of `tolerance`.
  void solve(double tolerance, double fine, int most, SolveReport& report);

 private:
  // The contacts of one pair.
  struct Group {
    int pair = 0;
    std::vector<int> rows;
    std::vector<double> delassus;  // their own part of A
  };
  // How far a solve has come.
  struct Progress {
    double goal = 0;  // residual to reach [m/s]
    int done = 0;     // sweeps and steps
    int most = 0;
    double least = 1e300;  // residual so far, of best_
    const WorkBudget& budget;
    bool goes_on(double residual) const {
      return done < most && residual >= goal && budget.affords(0);
    }
  };

  void finish_groups();
  void judge(Progress& at, SolveReport& report);
  void sweep_round(Progress& at, SolveReport& report);
  void newton_round(Progress& at, SolveReport& report);
  void settle(Group& g, double tolerance);
  void iterate(double tolerance, double fine, int most, SolveReport& report);
  void start_anew(double tolerance, int most, SolveReport& report);
  // newton.cpp
  bool newton_step(double damping, double bound);
  void drop_unloaded();
  struct Slip;
  Slip slip_of(int contact) const;
  int order_unknowns();
  void newton_rows(int symmetric, double damping);
  void slip_rows(int contact, int at);
  bool take_share(const double* step, double bound);
  // normal_impulses.cpp
  void settle_normals(double tolerance, SolveReport& report);
  void drop_driving_friction(double tolerance, SolveReport& report);
  void solve_normals(double tolerance);
  void gather_normals();
  void normal_rows();
  void solve_active();
  int find_wrong(double tolerance, int& last);
  void product();  // w_ = beta + A p
  void project();  // p onto the cones
  double residual(bool normal_only) const;
  double merit() const;

  bool barred_ = false;  // a Newton step of this solve was too dear
  std::vector<double> w_;
  std::vector<LocalContact> local_;
  std::vector<Group> groups_;
  size_t group_count_ = 0;
  CoulombPath path_;
  std::vector<double> best_;       // the impulses with the least residual so far
  std::vector<double> old_, own_;  // of a group: impulses before, and velocities
  // Of a Newton step or of pivoting: the contacts that take part, the equations, where it started.
  std::vector<int> set_;
  std::vector<char> slips_;           // of the set
  std::vector<int> unknown_, place_;  // rows of A of a step's unknowns, and the other way round
  std::vector<double> matrix_, right_, start_;
  // Of the normal rows alone.
  std::vector<double> normals_, q_, x_, least_pivot_;
  std::vector<char> active_, wrong_;
};

}  // namespace hp
