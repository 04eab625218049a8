// The factor of articulated bodies against the one along chains and against plain elimination, and half
// solves of rows against whole solves.
#include "dynamics/inertia_factor.h"

#include <cstdint>
#include <vector>

#include "check.h"
#include "dynamics/half_solve.h"
#include "small_person.h"

namespace {

constexpr double kRounding =
    1e-11;  // of numbers of order one: the person's factor is well conditioned

// A number in [-1, 1) that depends on `seed` alone.
double drawn(uint64_t& seed) {
  seed = seed * 6364136223846793005ull + 1442695040888963407ull;
  return (double)(int64_t)seed / 9.3e18;
}

struct Person {
  hp::Model m = small_person::model();
  hp::Kinematics k;
  hp::Inertia inertia;
  std::vector<double> extra;

  explicit Person(uint64_t seed) {
    m.finish();
    std::vector<double> qpos = m.qpos0, v(m.nv);
    for (double& x : v) x = drawn(seed);
    hp::integrate(m, qpos.data(), v.data(), 1.0);
    k.resize(m);
    k.update(m, qpos.data());
    k.update_dofs(m, qpos.data());
    inertia.compose(m, k);
    for (int i = 0; i < m.nv; i++) extra.push_back(0.5 + 0.5 * drawn(seed));
  }

  // scale_i M_ij + ... as numbers, from products with unit vectors.
  std::vector<double> matrix(const std::vector<double>& scale) const {
    const int n = m.nv;
    std::vector<double> A((size_t)n * n), unit(n, 0.0), column(n);
    for (int j = 0; j < n; j++) {
      unit[j] = 1;
      inertia.multiply(m, m.trees[0], unit.data(), column.data());
      unit[j] = 0;
      for (int i = 0; i < n; i++)
        A[(size_t)i * n + j] = (1 + std::sqrt((scale[i] - 1) * (scale[j] - 1))) * column[i] +
                               (i == j ? scale[i] * extra[i] : 0.0);
    }
    return A;
  }
};

// x <- A^-1 x by elimination without pivots: A is positive definite.
void eliminate(std::vector<double> A, std::vector<double>& x) {
  const size_t n = x.size();
  for (size_t k = 0; k < n; k++)
    for (size_t i = k + 1; i < n; i++) {
      const double f = A[i * n + k] / A[k * n + k];
      for (size_t j = k; j < n; j++) A[i * n + j] -= f * A[k * n + j];
      x[i] -= f * x[k];
    }
  for (size_t k = n; k-- > 0;) {
    for (size_t j = k + 1; j < n; j++) x[k] -= A[k * n + j] * x[j];
    x[k] /= A[k * n + k];
  }
}

void compare_solve(const Person& p, const std::vector<double>& scale, uint64_t seed) {
  hp::InertiaFactor factor;
  factor.factor(p.m, p.inertia, scale, p.extra);
  std::vector<double> x(p.m.nv);
  for (double& e : x) e = drawn(seed);
  std::vector<double> expected = x;
  eliminate(p.matrix(scale), expected);
  factor.solve(p.m, x.data());
  for (int i = 0; i < p.m.nv; i++) CHECK_NEAR(x[i], expected[i], kRounding);
}

// With one scale, and with one for each dof.
void solves_like_elimination() {
  for (uint64_t seed = 1; seed <= 20; seed++) {
    const Person p(seed);
    std::vector<double> scale(p.m.nv, 1.7);
    compare_solve(p, scale, seed);
    for (int i = 0; i < p.m.nv; i++) scale[i] = 1 + 0.05 * i;
    compare_solve(p, scale, seed);
  }
}

// A = Y Y^T of three rows, and Y^T taken back, against solving for each row of J^T.
void compare_half_solve(const Person& p, const std::vector<double>& scale, uint64_t seed,
                        const char* free) {
  const hp::Model& m = p.m;
  hp::InertiaFactor factor;
  factor.factor(m, p.inertia, scale, p.extra, nullptr, free);
  hp::HalfSolve half;
  half.begin(m);
  std::vector<std::vector<double>> J(3, std::vector<double>(m.nv, 0.0));
  for (const int b : {2, 4}) {  // the chest and the shin
    hp::Vec3 moment[3], force[3];
    for (int q = 0; q < 3; q++)
      for (int c = 0; c < 3; c++) moment[q][c] = drawn(seed), force[q][c] = drawn(seed);
    half.add_wrench(b, moment, force);
    for (int a = 0; a < m.row_size[m.last_dof[b]]; a++) {
      const int i = m.chain[m.row_start[m.last_dof[b]] + a];
      for (int q = 0; q < 3; q++)
        J[q][i] += dot(p.k.cdof[i].w, moment[q]) + dot(p.k.cdof[i].v, force[q]);
    }
  }
  const double bend[3] = {0.3, -0.2, 0.7};
  half.add_force(m, 10, bend);
  for (int q = 0; q < 3; q++) J[q][10] += bend[q];
  std::vector<int> dofs;
  std::vector<double> y;
  half.sweep(m, factor, dofs, y);
  CHECK(y.size() == 4 * dofs.size());
  for (int q = 0; q < 3; q++) {
    std::vector<double> x = J[q], back(m.nv, 0.0);
    factor.solve(m, x.data());
    for (int r = 0; r < 3; r++) {
      double whole = 0, halves = 0;
      for (int i = 0; i < m.nv; i++) whole += J[r][i] * x[i];
      for (size_t e = 0; e < dofs.size(); e++) halves += y[4 * e + q] * y[4 * e + r];
      CHECK_NEAR(halves, whole, kRounding);
    }
    for (size_t e = 0; e < dofs.size(); e++) back[dofs[e]] += y[4 * e + q];
    std::vector<hp::Twist> twists, expected;
    factor.half_solve_back(m, back.data(), twists);
    for (int i = 0; i < m.nv; i++) CHECK_NEAR(back[i], x[i], kRounding);
    hp::body_twists(m, p.k, x.data(), expected);
    for (int b = 1; b < m.nbody; b++) CHECK_NEAR(norm(twists[b].v - expected[b].v), 0, kRounding);
  }
}

void half_solves_are_halves() {
  for (uint64_t seed = 1; seed <= 20; seed++) {
    const Person p(seed);
    std::vector<double> scale(p.m.nv, 1.7);
    std::vector<char> free(p.m.nv, 1);
    for (int i = 3; i < 9; i++) free[i] = 0;
    compare_half_solve(p, scale, seed, nullptr);
    compare_half_solve(p, scale, seed, free.data());
    for (int i = 0; i < p.m.nv; i++) scale[i] = 1 + 0.05 * i;
    compare_half_solve(p, scale, seed, nullptr);
    compare_half_solve(p, scale, seed, free.data());
  }
}

// What cannot move does not; what can is solved for as if the other rows and columns were not there.
void held_dofs_stay() {
  const Person p(7);
  const int n = p.m.nv;
  std::vector<char> free(n, 0);
  for (int i = 9; i < n; i++) free[i] = 1;
  for (const double step : {0.0, 0.05}) {
    std::vector<double> scale(n);
    for (int i = 0; i < n; i++) scale[i] = 1.7 + step * i;
    hp::InertiaFactor factor;
    factor.factor(p.m, p.inertia, scale, p.extra, nullptr, free.data());
    std::vector<double> x(n, 1.0), expected(n, 1.0), A = p.matrix(scale);
    factor.solve(p.m, x.data());
    for (int i = 0; i < n; i++)
      for (int j = 0; j < n; j++)
        if (!free[i] || !free[j]) A[(size_t)i * n + j] = i == j;
    eliminate(A, expected);
    for (int i = 0; i < n; i++) CHECK_NEAR(x[i], free[i] ? expected[i] : 0.0, kRounding);
  }
}

}  // namespace

int main() {
  solves_like_elimination();
  half_solves_are_halves();
  held_dofs_stay();
  return check::report("test_inertia_factor");
}
