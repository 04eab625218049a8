// Impulses by the path through smoothed problems: they obey Coulomb's law wherever there is an answer,
// and what the path costs has a bound.
#include "contact/coulomb_path.h"

#include <random>

#include "check.h"
#include "tuning.h"

namespace {

constexpr double kTolerance = 2.4e-4;  // a micrometre in 1/240 s [m/s]

// Contacts that press on a few degrees of freedom: A = J J^T, beta = J v.
struct Problem {
  hp::Delassus A;
  std::vector<double> beta, p;
  std::vector<hp::LocalContact> contacts;

  Problem(int n, int freedoms, double friction, unsigned seed) : beta(3 * n), p(3 * n, 0.0) {
    std::mt19937 random(seed);
    const auto number = [&] { return random() / 2147483648.0 - 1; };  // in [-1, 1)
    std::vector<double> J(3 * n * freedoms), v(freedoms);
    for (double& x : J) x = number();
    for (double& x : v) x = number();
    A.reserve(n, 0);
    contacts.resize(n);
    for (int i = 0; i < 3 * n; i++) {
      for (int k = 0; k < freedoms; k++) beta[i] += J[i * freedoms + k] * v[k];
      for (int j = 0; j < 3 * n; j++) {
        double sum = i == j ? 1e-9 : 0;
        for (int k = 0; k < freedoms; k++) sum += J[i * freedoms + k] * J[j * freedoms + k];
        A.block(i / 3, j / 3)[(i % 3) * A.stride() + j % 3] = sum;
      }
    }
    for (int i = 0; i < n; i++) {
      hp::Mat3 own;
      for (int q = 0; q < 9; q++) own.m[q] = A.block(i, i)[(q / 3) * A.stride() + q % 3];
      contacts[i].set(own, i % 5 == 0 ? 0.0 : friction);  // some without friction
    }
  }

  // How far p is from Coulomb's law, as a velocity.
  double residual() const {
    const int n = (int)beta.size();
    std::vector<double> w = beta;
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++) w[i] += A.row(i)[j] * p[j];
    double worst = 0;
    for (size_t i = 0; i < contacts.size(); i++)
      worst = std::max(worst, contacts[i].residual(&p[3 * i], &w[3 * i]));
    return worst;
  }
};

// With more freedoms than rows every contact can part from the others: there is an answer.
void answers_obey_the_law() {
  hp::CoulombPath path;
  for (unsigned seed = 0; seed < 100; seed++) {
    const int n = 2 + seed % 11;
    Problem problem(n, 3 * n + 4, 0.2 + 0.1 * (seed % 14), seed);
    hp::WorkBudget budget;
    budget.begin(1e9);
    const bool found = path.follow(problem.A, problem.beta, problem.contacts, kTolerance, 1e300,
                                   budget, problem.p);
    CHECK(found);
    CHECK(problem.residual() < 1.01 * kTolerance);
    CHECK(path.steps() <= hp::tuning::contact::kPathSteps);
    CHECK(budget.work() > 0);
  }
}

// One contact that presses, with an answer in closed form: it stops, or it slips on.
void one_contact_stops() {
  Problem problem(2, 10, 0.0, 1);
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++)
      problem.A.block(i / 3, j / 3)[(i % 3) * problem.A.stride() + j % 3] = i == j ? 2.0 : 0.0;
  problem.beta = {-1.0, 0.3, 0.0, -1.0, 0.0, -3.0};
  hp::Mat3 own;
  for (int q = 0; q < 9; q++) own.m[q] = q % 4 == 0 ? 2.0 : 0.0;
  for (hp::LocalContact& c : problem.contacts) c.set(own, 0.5);
  hp::CoulombPath path;
  hp::WorkBudget budget;
  budget.begin(1e9);
  CHECK(path.follow(problem.A, problem.beta, problem.contacts, 1e-9, 1e300, budget, problem.p));
  const double expected[6] = {0.5, -0.15, 0.0, 0.5, 0.0, 0.25};
  for (int i = 0; i < 6; i++) CHECK(std::fabs(problem.p[i] - expected[i]) < 1e-9);
}

// What is better already stays, and so it does where the budget bears no path.
void nothing_gets_worse() {
  hp::CoulombPath path;
  Problem problem(8, 28, 0.8, 3);
  const std::vector<double> before = problem.p;
  hp::WorkBudget budget;
  budget.begin(1e3);
  CHECK(!path.follow(problem.A, problem.beta, problem.contacts, kTolerance, 1e300, budget,
                     problem.p));
  CHECK(problem.p == before && budget.work() == 0);
  budget.begin(1e9);
  CHECK(
      !path.follow(problem.A, problem.beta, problem.contacts, kTolerance, 1e-6, budget, problem.p));
  CHECK(problem.p == before);
}

// Two contacts between rails that close: there is no answer, and that is found out at a bounded cost.
void what_has_no_answer_ends() {
  Problem problem(2, 10, 0.5, 1);
  for (int i = 0; i < 6; i++)
    for (int j = 0; j < 6; j++)
      problem.A.block(i / 3, j / 3)[(i % 3) * problem.A.stride() + j % 3] =
          i == j                                     ? 1.0
          : (i == 3 && j == 0) || (i == 0 && j == 3) ? -1.0
                                                     : 0.0;
  problem.beta = {-1.0, 0.0, 0.0, -1.0, 0.1, 0.0};
  hp::CoulombPath path;
  hp::WorkBudget budget;
  budget.begin(1e12);
  path.follow(problem.A, problem.beta, problem.contacts, kTolerance, 1e300, budget, problem.p);
  CHECK(budget.work() < 1.01 * hp::tuning::contact::kPathWork);
  for (double x : problem.p) CHECK(std::isfinite(x));
}

}  // namespace

int main() {
  answers_obey_the_law();
  one_contact_stops();
  nothing_gets_worse();
  what_has_no_answer_ends();
  return check::report("test_coulomb_path");
}
