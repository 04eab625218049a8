#include "solver.h"

#include <cstring>

namespace hp {

namespace {

// Friction is settled to this share of the tolerance where few points allow it: what is held
// must not creep.
constexpr double kFriction = 0.01;

// Sweeps that are accelerated; what cycles then settles without.
constexpr int kAccelerated = 25;

// Rounds of normals alone, friction following.
constexpr int kRounds = 8;
constexpr int kPivots = 40;
// Multiplications after which no further round begins.
constexpr double kMostWork = 1e8;
// Redundant points share what they carry as if they gave way by this share of their own inverse
// inertia: at 10 N s on a limb 4e-5 m/s, under the tolerance. Without, their pivots are singular.
constexpr double kCompliance = 1e-8;

// Friction back onto its disc.
void clamp(double* p, double mu) {
  double length = std::hypot(p[1], p[2]), limit = mu * p[0];
  if (length <= limit) return;
  double f = limit > 0 ? limit / length : 0;
  p[1] *= f, p[2] *= f;
}

}  // namespace

Vec3 endpoint_velocity(const Model& m, const Kinematics& k, const std::vector<Twist>& twists,
                       const Endpoint& e) {
  Vec3 v;
  for (int i = 0; i < e.count; i++) {
    const Twist& t = twists[e.body[i]];
    v += e.weight[i] * (t.v + cross(t.w, e.point[i] - k.reference(m, e.body[i])));
  }
  return v;
}

// D^-1/2 L^-T S for the six spatial axes S of a body: what a unit wrench on it does, per dof of
// its chain. Then a row of Y = D^-1/2 L^-T J^T is a combination of six columns.
void ContactSolver::half_solve(const Model& m, const Kinematics& k, const Inertia& inertia,
                               int body) {
  int last = m.last_dof[body];
  const int* dof = &m.chain[m.row_start[last]];
  int n = m.row_size[last];
  body_slot_[body] = (int)body_y_.size();
  body_y_.resize(body_y_.size() + 6 * (size_t)n);
  double* y = &body_y_[body_slot_[body]];
  for (int a = 0; a < n; a++) {
    store3(y + 6 * a, k.cdof[dof[a]].w);
    store3(y + 6 * a + 3, k.cdof[dof[a]].v);
  }
  for (int a = n - 1; a > 0; a--) {
    const double* row = &inertia.L[m.row_start[dof[a]]];
    const double* ya = y + 6 * a;
    for (int c = 0; c < a; c++)
      for (int e = 0; e < 6; e++) y[6 * c + e] -= row[c] * ya[e];
  }
  for (int a = 0; a < n; a++)
    for (int e = 0; e < 6; e++) y[6 * a + e] *= inertia.root_D[dof[a]];
}

void ContactSolver::local(int i) {
  const int n3 = (int)beta_.size();
  const double* A = &A_[(size_t)(3 * i) * n3 + 3 * i];
  double* p = &p_[3 * i];
  double* w = &w_[3 * i];
  double a00 = A[0], a01 = A[1], a02 = A[2], a10 = A[n3], a11 = A[n3 + 1], a12 = A[n3 + 2],
         a20 = A[2 * n3], a21 = A[2 * n3 + 1], a22 = A[2 * n3 + 2];
  // Velocity of this contact without its own impulse.
  Vec3 r{w[0] - (a00 * p[0] + a01 * p[1] + a02 * p[2]),
         w[1] - (a10 * p[0] + a11 * p[1] + a12 * p[2]),
         w[2] - (a20 * p[0] + a21 * p[1] + a22 * p[2])};
  double mu = friction_[i];
  Vec3 q;
  if (mu == 0) {
    q.x = std::max(0.0, -r.x / a00);
  } else {
    q = block_inverse_[i] * (-r);  // sticking
    if (!(q.x >= 0 && q.y * q.y + q.z * q.z <= mu * mu * q.x * q.x)) {
      // Separating, or sliding: friction on the disc's edge against the slip.
      if (r.x >= 0 && p[0] == 0) {
        q = {};
      } else {
        q = {p[0], p[1], p[2]};
        for (int it = 0; it < 12; it++) {
          Vec3 old = q;
          q.x = std::max(0.0, -(r.x + a01 * q.y + a02 * q.z) / a00);
          double u = r.y + a10 * q.x + a11 * q.y + a12 * q.z,
                 v = r.z + a20 * q.x + a21 * q.y + a22 * q.z;
          double y = q.y - tangent_step_[i] * u, z = q.z - tangent_step_[i] * v,
                 length = std::sqrt(y * y + z * z), limit = mu * q.x;
          double f = length > limit ? limit / length : 1;
          q.y = f * y, q.z = f * z;
          if (norm2(q - old) <= 1e-24 * norm2(q)) break;
        }
      }
    }
  }
  Vec3 d{q.x - p[0], q.y - p[1], q.z - p[2]};
  if (d.x == 0 && d.y == 0 && d.z == 0) return;
  p[0] = q.x, p[1] = q.y, p[2] = q.z;
  const double *r0 = &A_[(size_t)(3 * i) * n3], *r1 = r0 + n3, *r2 = r1 + n3;
  double* W = w_.data();
  for (int j = 0; j < n3; j++) W[j] += d.x * r0[j] + d.y * r1[j] + d.z * r2[j];
}

void ContactSolver::product(int n) {
  int n3 = 3 * n;
  w_ = beta_;
  for (int i = 0; i < n3; i++) {
    double f = p_[i];
    if (f == 0) continue;
    const double* row = &A_[(size_t)i * n3];
    for (int j = 0; j < n3; j++) w_[j] += f * row[j];
  }
}

double ContactSolver::residual(int n, bool normal_only) const {
  double worst = 0;
  for (int i = 0; i < n; i++) {
    const double *p = &p_[3 * i], *w = &w_[3 * i];
    worst = std::max(worst, std::fabs(std::min(w[0], p[0] * diagonal_[i])));
    if (normal_only || p[0] <= 0) continue;
    double k = tangent_step_[i], y = p[1] - k * w[1], z = p[2] - k * w[2],
           length = std::sqrt(y * y + z * z), limit = friction_[i] * p[0],
           f = length > limit ? limit / length : 1;
    worst = std::max(worst, std::hypot(f * y - p[1], f * z - p[2]) / k);
  }
  return worst;
}

// Symmetric sweeps, accelerated as nonlinear conjugate gradients (Silcowitz et al. 2010).
void ContactSolver::sweeps(int n, double tolerance, int most, SolveReport& report) {
  const int n3 = 3 * n;
  step_.assign(n3, 0);
  double previous = 0;
  product(n);
  for (int it = 0;; it++, report.sweeps++) {
    report.residual = residual(n, false);
    if (report.residual < tolerance || it == most) return;
    before_ = p_;
    for (int k = 0; k < n; k++) local(it % 2 == 0 ? k : n - 1 - k);
    double gradient = 0;
    for (int i = 0; i < n3; i++) {
      double d = p_[i] - before_[i];
      gradient += d * d * A_[(size_t)i * n3 + i];
    }
    double ratio = previous > 0 && it < kAccelerated ? gradient / previous : 2;
    previous = gradient;
    if (ratio > 1) {
      for (int i = 0; i < n3; i++) step_[i] = p_[i] - before_[i];
      continue;
    }
    for (int i = 0; i < n3; i++) {
      double d = p_[i] - before_[i], extra = ratio * step_[i];
      p_[i] += extra;
      step_[i] = extra + d;
    }
    for (int i = 0; i < n; i++) {
      double* p = &p_[3 * i];
      p[0] = std::max(p[0], 0.0);
      clamp(p, friction_[i]);
    }
    product(n);
  }
}

// 0 <= p_n, A p_n + q >= 0, complementary, with friction held: block principal pivoting (Judice and
// Pires 1994), with single pivots where blocks cycle; the pivots are solved for by Cholesky.
void ContactSolver::normals(int n, double tolerance) {
  const size_t n3 = 3 * (size_t)n;
  q_.resize(n);
  x_.assign(n, 0);
  active_.resize(n);
  for (int i = 0; i < n; i++) {
    const double* row = &A_[3 * i * n3];
    double s = beta_[3 * i];
    for (int j = 0; j < n; j++) s += row[3 * j + 1] * p_[3 * j + 1] + row[3 * j + 2] * p_[3 * j + 2];
    q_[i] = s;
    active_[i] = p_[3 * i] > 0;
  }
  int fewest = n + 1, patience = 3;
  for (int it = 0; it < kPivots; it++) {
    set_.clear();
    for (int i = 0; i < n; i++)
      if (active_[i]) set_.push_back(i);
    const int k = (int)set_.size();
    chol_.resize((size_t)k * k);
    for (int a = 0; a < k; a++) {
      double* row = &chol_[(size_t)a * k];
      for (int b = 0; b <= a; b++) {
        const double* other = &chol_[(size_t)b * k];
        double s = A_[3 * set_[a] * n3 + 3 * set_[b]];
        if (a == b) s *= 1 + kCompliance;
        for (int c = 0; c < b; c++) s -= row[c] * other[c];
        row[b] = a == b ? std::sqrt(std::max(s, 1e-14 * A_[3 * set_[a] * (n3 + 1)])) : s / other[b];
      }
    }
    x_.assign(n, 0);
    for (int a = 0; a < k; a++) {
      double s = -q_[set_[a]];
      for (int c = 0; c < a; c++) s -= chol_[(size_t)a * k + c] * x_[set_[c]];
      x_[set_[a]] = s / chol_[(size_t)a * (k + 1)];
    }
    for (int a = k - 1; a >= 0; a--) {
      double s = x_[set_[a]];
      for (int c = a + 1; c < k; c++) s -= chol_[(size_t)c * k + a] * x_[set_[c]];
      x_[set_[a]] = s / chol_[(size_t)a * (k + 1)];
    }
    int wrong = 0, last = -1;
    wrong_.assign(n, 0);
    // Redundant points trade rounding among themselves: that is no reason to pivot.
    double largest = 0;
    for (double x : x_) largest = std::max(largest, std::fabs(x));
    for (int i = 0; i < n; i++) {
      if (active_[i]) {
        wrong_[i] = x_[i] < -1e-5 * largest;
      } else {
        double y = q_[i];
        for (int j : set_) y += A_[3 * i * n3 + 3 * j] * x_[j];
        wrong_[i] = y < -tolerance;
      }
      if (wrong_[i]) wrong++, last = i;
    }
    if (wrong == 0) break;
    bool all = wrong < fewest || patience > 0;
    if (wrong < fewest)
      fewest = wrong, patience = 3;
    else
      patience--;
    for (int i = 0; i < n; i++)
      if (wrong_[i] && (all || i == last)) active_[i] = !active_[i];
  }
  for (int i = 0; i < n; i++) p_[3 * i] = std::max(x_[i], 0.0);
}

SolveReport ContactSolver::solve(const Model& m, const Kinematics& k, const Inertia& inertia,
                                 double h, const double* v_free, double* v,
                                 std::vector<Contact>& contacts, double tolerance,
                                 int max_sweeps) {
  const int n = (int)contacts.size(), n3 = 3 * n;
  std::memcpy(v, v_free, sizeof(double) * m.nv);
  if (n == 0) return {};

  // Y, one row per touched dof, three columns per contact.
  body_slot_.assign(m.nbody, -1);
  body_y_.clear();
  dof_row_.assign(m.nv, -1);
  touched_.clear();
  for (const Contact& c : contacts)
    for (const Endpoint* e : {&c.a, &c.b})
      for (int i = 0; i < e->count; i++) {
        int b = e->body[i], last = m.last_dof[b];
        if (last < 0 || body_slot_[b] >= 0) continue;
        half_solve(m, k, inertia, b);
        for (int a = 0; a < m.row_size[last]; a++) {
          int d = m.chain[m.row_start[last] + a];
          if (dof_row_[d] < 0) dof_row_[d] = (int)touched_.size(), touched_.push_back(d);
        }
      }
  Y_.assign(touched_.size() * (size_t)n3, 0);
  body_twists(m, k, v_free, twists_);
  beta_.resize(n3);
  p_.resize(n3);
  friction_.resize(n);
  for (int i = 0; i < n; i++) {
    Contact& c = contacts[i];
    const Vec3 axis[3] = {c.n, c.t, c.s};
    for (int side = 0; side < 2; side++) {
      const Endpoint& e = side == 0 ? c.a : c.b;
      for (int l = 0; l < e.count; l++) {
        int b = e.body[l], last = m.last_dof[b];
        if (last < 0) continue;
        Vec3 r = e.point[l] - k.reference(m, b);
        double weight = side == 0 ? e.weight[l] : -e.weight[l];
        const double* y = &body_y_[body_slot_[b]];
        const int* dof = &m.chain[m.row_start[last]];
        Vec3 moment[3];
        for (int q = 0; q < 3; q++) moment[q] = weight * cross(r, axis[q]);
        for (int a = 0; a < m.row_size[last]; a++, y += 6) {
          double* out = &Y_[(size_t)dof_row_[dof[a]] * n3 + 3 * i];
          Vec3 yw = load3(y), yv = load3(y + 3);
          for (int q = 0; q < 3; q++) out[q] += dot(moment[q], yw) + weight * dot(axis[q], yv);
        }
      }
    }
    Vec3 u = endpoint_velocity(m, k, twists_, c.a) - endpoint_velocity(m, k, twists_, c.b);
    double demand = std::max((c.target - c.dist + c.shift) / h, c.bounce);
    for (int q = 0; q < 3; q++) {
      beta_[3 * i + q] = dot(axis[q], u);
      p_[3 * i + q] = dot(axis[q], c.impulse);
    }
    beta_[3 * i] -= demand;
    friction_[i] = c.friction;
    p_[3 * i] = std::max(p_[3 * i], 0.0);
    clamp(&p_[3 * i], c.friction);
  }

  // A = Y^T Y: the upper half, then mirrored.
  A_.assign((size_t)n3 * n3, 0);
  for (size_t r = 0; r < touched_.size(); r++) {
    const double* y = &Y_[r * n3];
    for (int i = 0; i < n3; i++) {
      double f = y[i];
      if (f == 0) continue;
      double* row = &A_[(size_t)i * n3];
      for (int j = i; j < n3; j++) row[j] += f * y[j];
    }
  }
  for (int i = 0; i < n3; i++)
    for (int j = 0; j < i; j++) A_[(size_t)i * n3 + j] = A_[(size_t)j * n3 + i];
  block_inverse_.resize(n);
  tangent_step_.resize(n);
  diagonal_.resize(n);
  for (int i = 0; i < n; i++) {
    double* a = &A_[(size_t)(3 * i) * n3 + 3 * i];
    double floor = 1e-12 * std::max(a[0], 1e-9);  // a contact between immovable things
    for (int q = 0; q < 3; q++) a[q * (n3 + 1)] += floor;
    Mat3 B;
    for (int q = 0; q < 9; q++) B.m[q] = a[(q / 3) * n3 + q % 3];
    // Inverse by columns.
    for (int q = 0; q < 3; q++) {
      Vec3 e;
      e[q] = 1;
      Vec3 x = solve3(B, e);
      for (int l = 0; l < 3; l++) block_inverse_[i].m[3 * l + q] = x[l];
    }
    diagonal_[i] = a[0];
    double b = a[n3 + 1], c = a[2 * n3 + 2], d = a[n3 + 2];
    // Largest eigenvalue of the tangential block: the projected step is stable.
    tangent_step_[i] = 1 / (0.5 * (b + c) + std::sqrt(0.25 * (b - c) * (b - c) + d * d));
  }

  // Where friction on many redundant points is slow to settle, it is held and the normal impulses
  // are solved for alone: nothing penetrates, and the next substep starts warm.
  SolveReport report;
  sweeps(n, kFriction * tolerance, max_sweeps, report);
  if (report.residual >= tolerance) report.residual = residual(n, true);
  before_ = p_;  // the best so far: pivots that do not end must not count
  const double work = (double)n * n * n * kPivots / 6;  // of a round, at most
  for (int round = 0; round < kRounds && report.residual >= tolerance; round++) {
    if (round * work > kMostWork) break;
    normals(n, 1e-3 * tolerance);
    // A normal impulse that got smaller takes its friction along.
    for (int i = 0; i < n; i++) clamp(&p_[3 * i], friction_[i]);
    product(n);
    double after = residual(n, true);
    report.sweeps++;
    if (after < report.residual) before_ = p_, report.residual = after;
  }
  p_ = before_;
  // A point that touches nothing else that moves has an answer of its own, and gets it exactly:
  // what rests in one corner must not feel how well another corner is solved.
  product(n);
  for (int i = 0; i < n; i++) {
    const double* row = &A_[(size_t)(3 * i) * n3];
    bool alone = true;
    for (int j = 0; j < n3 && alone; j++)
      alone = j / 3 == i || (row[j] == 0 && row[n3 + j] == 0 && row[2 * n3 + j] == 0);
    if (alone) local(i);
  }

  // v = v_free + M^-1 J^T p = v_free + L^-1 D^-1/2 Y p.
  std::vector<double>& dv = before_;
  dv.assign(m.nv, 0);
  for (size_t r = 0; r < touched_.size(); r++) {
    const double* y = &Y_[r * n3];
    double s = 0;
    for (int j = 0; j < n3; j++) s += y[j] * p_[j];
    dv[touched_[r]] = s * inertia.root_D[touched_[r]];
  }
  inertia.half_solve_back(m, dv.data());
  for (int i = 0; i < m.nv; i++) v[i] += dv[i];
  for (int i = 0; i < n; i++) {
    Contact& c = contacts[i];
    c.impulse = p_[3 * i] * c.n + p_[3 * i + 1] * c.t + p_[3 * i + 2] * c.s;
  }
  return report;
}

}  // namespace hp
