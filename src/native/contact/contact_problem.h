// Coulomb contacts of one island in contact space: w = beta + A p, solved for p.
#pragma once
#include <vector>

#include "contact/coulomb.h"

namespace hp {

struct SolveReport {
  int sweeps = 0;       // block sweeps and Newton steps
  int points = 0;       // contacts that took part
  double residual = 0;  // largest violation, friction's included [m/s]
  double normal = 0;    // largest violation of w_n, p_n >= 0 and p_n w_n = 0 [m/s]
  bool crushed = false;  // something on a track leaves others no room: given up
};

// Each contact has three rows (n, t, s): 0 <= p_n, w_n >= 0, p_n w_n = 0, |p_t| <= mu p_n, slip
// opposed by friction. Contacts may join after a solve: A grows, p stays as the warm start.
class ContactProblem {
 public:
  std::vector<double> beta, p;  // 3 per contact

  int size() const { return (int)local_.size(); }
  void clear(int capacity);
  double* A(int i, int j) { return &delassus_[(size_t)(3 * i) * stride_ + 3 * j]; }
  const double* A(int i, int j) const { return &delassus_[(size_t)(3 * i) * stride_ + 3 * j]; }
  size_t stride() const { return stride_; }
  // Another contact: the caller has filled A(n, 0..n) and A(0..n, n). Contacts of one `pair` are
  // settled among themselves before a sweep goes on: they lie close together and are the slowest
  // to agree.
  void add(const double* beta3, const double* warm3, double mu, int pair);

  // Block sweeps find who carries and who slips; Newton steps then end it. Stops at `tolerance`
  // [m/s] or after `most` sweeps and steps, and takes the best of them; where the normal impulses
  // are not settled by then they are solved for alone. At first it aims at `fine` [m/s] instead.
  void solve(double tolerance, double fine, int most, SolveReport& report);

 private:
  struct Group {
    int pair = 0;
    std::vector<int> rows;
    std::vector<double> A;  // their own block
  };

  void finish_groups();
  void settle(Group& g, double tolerance);
  bool newton(double damping, double bound);
  void normals(double tolerance);
  void product();
  void project();
  double residual(bool normal_only) const;
  double merit() const;

  size_t stride_ = 0;
  std::vector<double> delassus_, w_;
  std::vector<LocalContact> local_;
  std::vector<Group> groups_;
  size_t group_count_ = 0;
  std::vector<double> old_, own_;
  std::vector<double> jacobian_, right_, start_, best_;
  std::vector<double> q_, x_, chol_;
  std::vector<char> active_, wrong_;
  std::vector<int> set_;
};

}  // namespace hp
