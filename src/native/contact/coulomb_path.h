// Contacts with Coulomb friction by a path through smoothed problems: for those that sweeps and Newton
// steps do not settle (near jamming the merit has valleys that end nowhere).
//
// Each contact is scaled to friction 1: x = (p_n, p_t / mu) and w = (w_n, mu w_t), both without
// dimension. With y = (w_n + |w_t|, w_t) Coulomb's law says that x and y lie in the cone z_0 >=
// |(z_1, z_2)| and are orthogonal in it (De Saxce and Feng 1998), or
//     F(x) = (x + y - sqrt((x - y)^2)) / 2 = 0,
// square and root in the Jordan algebra of that cone. Smoothed by c > 0, in
//     F(x, c) = (x + y - sqrt((x - y)^2 + 4 c^2)) / 2,   |w_t| as sqrt(w_t^2 + c^2) - c,
// impulses fade over distances instead of ending at them (Chen and Harker 1993, Kanzow 1996;
// Fukushima, Luo and Tseng 2002). The path
//     F(x, c) = c F(x_0, 1),
// begins at x_0 with c = 1 and ends at an answer, c = 0. It need not get there without c growing in
// between, where contacts jam: it is followed by its own length in (x, ln c) (Keller 1977), by secants
// and Newton steps back onto it.
#pragma once
#include <vector>

#include "contact/coulomb.h"
#include "contact/delassus.h"
#include "contact/work_budget.h"

namespace hp {

class CoulombPath {
 public:
  // Newton steps that it took.
  int steps() const { return steps_; }
  // Looks for impulses within `tolerance` [m/s] of an answer. p, which misses it by `missed`, becomes
  // the best that was met; false if that was p itself.
  bool follow(const Delassus& A, const std::vector<double>& beta,
              const std::vector<LocalContact>& contacts, double tolerance, double missed,
              WorkBudget& budget, std::vector<double>& p);

 private:
  // A point of the path: x, then ln c.
  using Point = std::vector<double>;

  bool begin(const Delassus& A, const std::vector<double>& beta,
             const std::vector<LocalContact>& contacts);
  double walk(const std::vector<LocalContact>& contacts, double tolerance, double least,
              WorkBudget& budget, std::vector<double>& p);
  bool advance(double length, WorkBudget& budget);
  double evaluate(const Point& at);
  void smooth(int i, double c, const double* x);
  bool newton(WorkBudget& budget);
  double residual(const std::vector<LocalContact>& contacts);
  double cost() const;

  int n_ = 0, steps_ = 0;
  double speed_ = 0;                     // [m/s]: one unit of w
  std::vector<double> unit_, mu_;        // per row: p of one unit of x [N s]; per contact
  std::vector<double> delassus_, beta_;  // without dimension
  std::vector<double> w_, start_, p_;    // start_: F(x_0, 1)
  std::vector<double> value_, matrix_;   // of F(x, c) - c start_, and its derivatives
  Point here_, trial_, direction_;
};

}  // namespace hp
