// Looks inside the stepper and at its parts on their own: for tests against other engines, judges
// and measures. Nothing here changes a simulation but `blind`.
#include <cstring>
#include <string>

#include "bindings/stepper.h"
#include "geometry/separation.h"
#include "tuning.h"

using namespace hp;

namespace {

void pose_of(Stepper& s, const Doubles& qpos, Kinematics& k) {
  need((int)qpos.shape(0) == s.system.model.nq, "bad length of qpos");
  k.resize(s.system.model);
  k.update(s.system.model, qpos.data());
  k.update_dofs(s.system.model, qpos.data());
}

void pose_of(Stepper& s, const Doubles& qpos, Poses& p) {
  pose_of(s, qpos, p.kin);
  s.system.world.start_poses(p);
}

Inertia inertia_at(Stepper& s, const Doubles& qpos) {
  Kinematics k;
  pose_of(s, qpos, k);
  Inertia inertia;
  inertia.compose(s.system.model, k);
  return inertia;
}

nb::dict contact_rows(const std::vector<Contact>& contacts) {
  std::vector<double> n, t, u, imp, curve, inward, dist, target, shift, mu, bounce;
  for (const Contact& c : contacts) {
    push(n, c.n);
    push(t, c.t);
    push(u, c.s);
    push(imp, c.impulse);
    push(curve, c.curve);
    push(inward, c.inward);
    dist.push_back(c.dist);
    target.push_back(c.target);
    shift.push_back(c.shift);
    mu.push_back(c.friction);
    bounce.push_back(c.bounce);
  }
  size_t k = contacts.size();
  nb::dict d;
  d["normal"] = array({k, 3}, n);
  d["tangent"] = array({k, 3}, t);
  d["binormal"] = array({k, 3}, u);
  d["impulse"] = array({k, 3}, imp);
  d["curve"] = array({k, 3}, curve);
  d["inward"] = array({k, 3}, inward);
  d["dist"] = array(dist);
  d["target"] = array(target);
  d["shift"] = array(shift);
  d["friction"] = array(mu);
  d["bounce"] = array(bounce);
  // Of both sides: the bodies that carry the point, 0: none more; its place on each, and their
  // weights.
  for (const bool second : {false, true}) {
    std::vector<double> body, point, weight;
    for (const Contact& c : contacts) {
      const Endpoint& e = second ? c.b : c.a;
      for (int i = 0; i < Endpoint::kMost; i++) {
        const bool there = i < e.count;
        body.push_back(there ? e.body[i] : 0);
        weight.push_back(there ? e.weight[i] : 0);
        push(point, there ? e.point[i] : Vec3{});
      }
    }
    const size_t most = Endpoint::kMost;
    const char* side = second ? "b" : "a";
    d[(std::string("bodies_") + side).c_str()] = array({k, most}, body);
    d[(std::string("weights_") + side).c_str()] = array({k, most}, weight);
    d[(std::string("points_") + side).c_str()] = array({k, most, 3}, point);
  }
  return d;
}

// Rows of people's joints: first dof, axis, sign, end [rad], the rotation that they are linear at, and, in m,
// what contacts have.
nb::dict range_rows(const Stepper& s, const std::vector<RangeRow>& rows) {
  std::vector<double> dof, ball, axis, sign, limit, at, dist, target, shift, impulse;
  for (const RangeRow& r : rows) {
    dof.push_back(s.system.drives[r.person].ball_dof(r.ball));
    ball.push_back(r.ball);
    axis.push_back(r.axis);
    sign.push_back(r.sign);
    limit.push_back(r.limit);
    at.insert(at.end(), {r.at.w, r.at.x, r.at.y, r.at.z});
    dist.push_back(r.contact.dist);
    target.push_back(r.contact.target);
    shift.push_back(r.contact.shift);
    impulse.push_back(r.contact.impulse.x);
  }
  nb::dict d;
  d["dof"] = array(dof);
  d["ball"] = array(ball);
  d["axis"] = array(axis);
  d["sign"] = array(sign);
  d["limit"] = array(limit);
  d["at"] = array({rows.size(), 4}, at);
  d["dist"] = array(dist);
  d["target"] = array(target);
  d["shift"] = array(shift);
  d["impulse"] = array(impulse);
  return d;
}

nb::dict trace(Stepper& s) {
  const Probe::Trace& t = s.probe.trace;
  const size_t nv = s.system.model.nv;
  nb::dict d;
  d["qpos"] = array(t.qpos);
  d["qvel"] = array(t.qvel);
  d["v_free"] = array(t.v_free);
  d["v"] = array(t.v);
  d["h"] = t.h;
  d["substep"] = t.k;
  d["overcome"] = array({t.overcome.size() / nv, nv}, t.overcome);
  d["contacts"] = contact_rows(t.contacts);
  d["ranges"] = range_rows(s, t.ranges);
  d["touched"] = array(std::vector<double>(t.touched.begin(), t.touched.end()));
  return d;
}

// Positions (bodies, 3) and quaternions (bodies, 4).
auto body_frames(Stepper& s, Doubles qpos) {
  Kinematics k;
  pose_of(s, qpos, k);
  std::vector<double> x, q;
  for (Vec3 p : k.xpos) push(x, p);
  for (Quat r : k.xquat) q.insert(q.end(), {r.w, r.x, r.y, r.z});
  const size_t n = s.system.model.nbody;
  return nb::make_tuple(array({n, 3}, x), array({n, 4}, q));
}

auto inertia_matrix(Stepper& s, Doubles qpos) {
  const Model& m = s.system.model;
  const Inertia inertia = inertia_at(s, qpos);
  const size_t n = m.nv;
  std::vector<double> M(n * n, 0), rows;
  for (const Model::Tree& tree : m.trees) inertia.rows(m, tree, rows);
  for (size_t i = 0; i < n; i++)
    for (int a = 0; a < m.row_size[i]; a++) {
      const int j = m.chain[m.row_start[i] + a];
      M[i * n + j] = M[j * n + i] = rows[m.row_start[i] + a];
    }
  return array({n, n}, M);
}

auto inertia_solve(Stepper& s, Doubles qpos, Doubles x) {
  const Model& m = s.system.model;
  InertiaFactor factor;
  factor.factor(m, inertia_at(s, qpos), std::vector<double>(m.nv, 1), std::vector<double>(m.nv, 0));
  std::vector<double> y = list<double>(x);
  factor.solve(m, y.data());
  return array(y);
}

// Coriolis, centrifugal and gravity forces, of whole trees.
auto bias_forces_at(Stepper& s, Doubles qpos, Doubles qvel) {
  const Model& m = s.system.model;
  Kinematics k;
  pose_of(s, qpos, k);
  std::vector<int> bodies;
  for (int b = 1; b < m.nbody; b++) bodies.push_back(b);
  std::vector<double> out(m.nv);
  bias_forces(m, k, qvel.data(), s.system.gravity, bodies, out.data());
  return array(out);
}

auto integrated(Stepper& s, Doubles qpos, Doubles qvel, double t) {
  std::vector<double> q = list<double>(qpos);
  integrate(s.system.model, q.data(), qvel.data(), t);
  return array(q);
}

// Vertices of the skin that are a shape's corners; none: it is rigid.
auto shape_vertices(Stepper& s, int shape) {
  const std::vector<int>& v = s.system.world.shapes.at(shape).vertex;
  return array(std::vector<double>(v.begin(), v.end()));
}

// A shape's corners (n, 3) at a pose.
auto shape_points(Stepper& s, Doubles qpos, int shape) {
  Poses p;
  pose_of(s, qpos, p);
  (void)s.system.world.shapes.at(shape);  // an IndexError
  const Points at = s.system.world.place(p, shape).points();
  std::vector<double> x;
  for (int i = 0; i < at.n; i++) push(x, at.at(i));
  return array({(size_t)at.n, 3}, x);
}

// The Jacobian (3, nv) of one of them.
auto shape_jacobian(Stepper& s, Doubles qpos, int shape, int corner) {
  Poses p;
  pose_of(s, qpos, p);
  const Model& model = s.system.model;
  const CollisionShape& m = s.system.world.shapes.at(shape);
  const PosedShape& at = s.system.world.place(p, shape);
  const Endpoint e = p.endpoint(m, at, p.material(m, at, at.points().at(corner)));
  const size_t n = model.nv;
  std::vector<double> J(3 * n), v(n, 0);
  std::vector<Twist> twists;
  for (size_t i = 0; i < n; i++) {
    v[i] = 1;
    body_twists(model, p.kin, v.data(), twists);
    const Vec3 x = endpoint_velocity(model, p.kin, twists, v.data(), e);
    for (int k = 0; k < 3; k++) J[k * n + i] = x[k];
    v[i] = 0;
  }
  return array({3, n}, J);
}

// Contacts w = beta + A p on their own: impulses, sweeps and steps, what is left of it all and of
// the normals alone [m/s], the work [multiplications], and if its budget ended before the tolerance.
auto solve_contacts(Square A, Doubles beta, Doubles mu, Ints pairs, Doubles warm, double tolerance,
                    double fine, int most, double budget) {
  const size_t n = mu.shape(0), n3 = 3 * n;
  need(A.shape(0) == n3 && A.shape(1) == n3 && beta.shape(0) == n3 && warm.shape(0) == n3 &&
           pairs.shape(0) == n,
       "solve_contacts: A (3n, 3n), beta (3n,), mu (n,), pairs (n,), warm (3n,)");
  ContactProblem problem;
  problem.clear(budget);
  problem.A.reserve((int)n, 0);
  for (size_t i = 0; i < n; i++) {
    for (size_t j = 0; j <= i; j++)
      for (size_t r = 0; r < 3; r++)
        for (size_t c = 0; c < 3; c++) {
          const double a = A.data()[(3 * i + r) * n3 + 3 * j + c];
          problem.A.block((int)i, (int)j)[r * problem.A.stride() + c] = a;
          problem.A.block((int)j, (int)i)[c * problem.A.stride() + r] = a;
        }
    problem.add(beta.data() + 3 * i, warm.data() + 3 * i, mu.data()[i], pairs.data()[i]);
  }
  SolveReport report;
  {
    nb::gil_scoped_release release;
    problem.solve(tolerance, fine, most, report);
  }
  return nb::make_tuple(array(problem.p), report.sweeps, report.residual, report.normal,
                        report.work, report.exhausted);
}

// Impulses of one contact for each row of r (k, 3); `old` says where to look first.
auto coulomb_contact(Square A, double mu, Rows3 r, Rows3 old) {
  need(A.shape(0) == 3 && A.shape(1) == 3 && old.shape(0) == r.shape(0),
       "coulomb_contact: A (3, 3), r and old (k, 3)");
  Mat3 a;
  std::memcpy(a.m, A.data(), sizeof a.m);
  LocalContact contact;
  contact.set(a, mu);
  std::vector<double> out;
  for (size_t i = 0; i < r.shape(0); i++)
    push(out, contact.solve(load3(r.data() + 3 * i), load3(old.data() + 3 * i)));
  return array({r.shape(0), 3}, out);
}

// Distance of two convex shapes; normals (may be empty) decide the way out of an overlap.
auto convex_distance(Rows3 a, Rows3 normals_a, double ra, Doubles rim_a, Rows3 b, Rows3 normals_b,
                     double rb, Doubles rim_b) {
  Convex A = convex(a, ra, rim_a, vectors(normals_a)), B = convex(b, rb, rim_b, vectors(normals_b));
  PosedShape pa, pb;
  pa.place(A, {}, {});
  pb.place(B, {}, {});
  Separation s = separate(pa, pb);
  std::vector<double> n, x, y;
  push(n, s.n);
  push(x, s.pa);
  push(y, s.pb);
  return nb::make_tuple(s.dist, array(n), array(x), array(y));
}

// Triangles, and a convex shape that asks about them.
struct TreeAndShape {
  TriangleTree tree;
  Convex hull;
  PosedShape posed;
  TreeAndShape(Rows3 vertices, Faces faces, Rows3 points, double radius, Doubles rim)
      : tree(vertices.data(), (int)vertices.shape(0), faces.data(), (int)faces.shape(0)),
        hull(convex(points, radius, rim)) {
    posed.place(hull, {}, {});
  }
};

// Planes (normal, offset, distance, triangle) between a convex shape and triangles, the smallest
// distance, and the reach that the planes hold for.
auto triangle_planes(Rows3 vertices, Faces faces, Rows3 hull, double radius, Doubles rim,
                     double reach) {
  const TreeAndShape at(vertices, faces, hull, radius, rim);
  std::vector<Plane> planes;
  const double holds = at.tree.planes(at.posed, reach, planes);
  std::vector<double> out;
  for (const Plane& q : planes) {
    push(out, q.n);
    out.insert(out.end(), {q.offset, q.dist, (double)at.tree.face(q.triangle)});
  }
  return nb::make_tuple(array({planes.size(), 6}, out), at.tree.distance(at.posed, reach), holds);
}

// Is a triangle nearer to a convex shape than `range`, and the distance of the nearest (`range` if none is)?
auto triangle_nearest(Rows3 vertices, Faces faces, Rows3 hull, double radius, Doubles rim,
                      double range) {
  const TreeAndShape at(vertices, faces, hull, radius, rim);
  size_t tests = 0;
  Plane plane;
  const bool nearer = at.tree.nearer(at.posed, range, tests),
             found = at.tree.nearest(at.posed, range, plane, tests);
  if (nearer != found) throw std::logic_error("triangle_nearest: the two searches differ");
  return nb::make_tuple(nearer, found ? plane.dist : range);
}

// A lower bound of the distance of a convex shape from triangles, or minus its depth; `axes` (n, 3)
// are directions that are tried first.
double triangle_gap(Rows3 vertices, Faces faces, Rows3 hull, double radius, Doubles rim,
                    Rows3 axes) {
  const TreeAndShape at(vertices, faces, hull, radius, rim);
  SeparatingAxes known;
  for (size_t k = 0; k < axes.shape(0) && k < SeparatingAxes::kMost; k++)
    known.n[k] = load3(axes.data() + 3 * k);
  size_t tests = 0;
  return at.tree.gap(at.posed, tuning::collision::kEndLook, known, tests);
}

}  // namespace

void bind_probes(nb::module_& m, StepperClass& stepper) {
  stepper.def("keep_pieces", [](Stepper& s, bool on) { s.probe.keep_pieces = on; })
      .def("keep_times", [](Stepper& s, bool on) { s.probe.keep_times = on; })
      .def("solve_times", [](Stepper& s) { return array(s.probe.solve_times); })
      .def("frame_work", &Stepper::frame_work)
      .def("blind", [](Stepper& s, int how) { s.probe.blind = how; })
      .def("keep_trace", [](Stepper& s, bool on) { s.probe.keep_trace = on; })
      .def("trace", &trace)
      // Kinematics and inertia on their own, for tests against other engines.
      .def("body_frames", &body_frames)
      .def("inertia_matrix", &inertia_matrix)
      .def("inertia_solve", &inertia_solve)
      .def("bias_forces", &bias_forces_at)
      .def("integrate", &integrated)
      .def("shape_vertices", &shape_vertices)
      .def("shape_points", &shape_points)
      .def("shape_jacobian", &shape_jacobian);
  m.def("solve_contacts", &solve_contacts);
  m.def("coulomb_contact", &coulomb_contact);
  m.def("convex_distance", &convex_distance);
  m.def("triangle_planes", &triangle_planes);
  m.def("triangle_nearest", &triangle_nearest);
  m.def("triangle_gap", &triangle_gap);
}
