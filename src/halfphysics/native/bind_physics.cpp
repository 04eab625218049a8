// Python face of the stepper. Arrays are copied in once; frames run without the GIL.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

#include "module.h"
#include "stepper.h"

using namespace hp;

namespace {

using Doubles = f64<nb::ndim<1>>;
using Ints = i32<nb::ndim<1>>;
using Rows3 = f64<nb::shape<-1, 3>>;
using Rows4 = f64<nb::shape<-1, 4>>;
using Faces = i32<nb::shape<-1, 3>>;
using Square = f64<nb::shape<-1, -1>>;
using Indices = nb::ndarray<int32_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

std::vector<Vec3> vectors(const Rows3& a) {
  std::vector<Vec3> out(a.shape(0));
  for (size_t i = 0; i < out.size(); i++) out[i] = load3(a.data() + 3 * i);
  return out;
}

std::vector<Quat> quats(const Rows4& a) {
  std::vector<Quat> out(a.shape(0));
  for (size_t i = 0; i < out.size(); i++) out[i] = load4(a.data() + 4 * i);
  return out;
}

template <typename T, typename A>
std::vector<T> list(const A& a) {
  return {a.data(), a.data() + a.shape(0)};
}

auto array(std::vector<size_t> shape, const std::vector<double>& values) {
  double* data = new double[values.size() + 1];
  std::copy(values.begin(), values.end(), data);  // memcpy may not be given the null of none
  nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return nb::ndarray<nb::numpy, double>(data, shape.size(), shape.data(), owner);
}

auto array(const std::vector<double>& v) { return array({v.size()}, v); }

void push(std::vector<double>& out, Vec3 v) { out.insert(out.end(), {v.x, v.y, v.z}); }

void need(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(what);
}

// `rim` is the axis of the disc times its radius; zero: none.
Convex convex(const Rows3& vertices, double radius, const Doubles& rim,
              std::vector<Vec3> normals = {}) {
  need(vertices.shape(0) > 0, "a shape needs at least one vertex");
  need(rim.shape(0) == 3, "rim: expected (3,)");
  Convex c;
  c.vertices = vectors(vertices);
  c.normals = std::move(normals);
  c.radius = radius;
  Vec3 r = load3(rim.data());
  c.rim = norm(r);
  if (c.rim > 0) c.axis = (1 / c.rim) * r;
  c.finish();
  return c;
}

// The tree of a static mesh in the world frame, shared by whoever asks for the same triangles.
struct MeshTree {
  std::shared_ptr<const TriangleTree> tree;
};

void set_model(Stepper& s, Ints parent, Ints jnt_first, Ints jnt_count, Ints dof_first,
               Ints dof_count, Rows3 pos, Rows4 quat, Rows3 ipos, Rows4 iquat, Doubles mass,
               Rows3 inertia, Ints jnt_type, Ints jnt_qpos, Ints jnt_dof, Ints jnt_body,
               Rows3 jnt_pos, Rows3 jnt_axis, Doubles qpos0, Doubles armature) {
  Model& m = s.model;
  m = {};
  m.nbody = (int)parent.shape(0);
  m.njnt = (int)jnt_type.shape(0);
  m.nq = (int)qpos0.shape(0);
  m.nv = (int)armature.shape(0);
  m.parent = list<int>(parent);
  m.jnt_first = list<int>(jnt_first);
  m.jnt_count = list<int>(jnt_count);
  m.dof_first = list<int>(dof_first);
  m.dof_count = list<int>(dof_count);
  m.pos = vectors(pos);
  m.quat = quats(quat);
  m.ipos = vectors(ipos);
  m.iquat = quats(iquat);
  m.mass = list<double>(mass);
  m.inertia = vectors(inertia);
  for (int t : list<int>(jnt_type)) m.jnt_type.push_back(static_cast<Joint>(t));
  m.jnt_qpos = list<int>(jnt_qpos);
  m.jnt_dof = list<int>(jnt_dof);
  m.jnt_body = list<int>(jnt_body);
  m.jnt_pos = vectors(jnt_pos);
  m.jnt_axis = vectors(jnt_axis);
  m.qpos0 = list<double>(qpos0);
  m.armature = list<double>(armature);
  m.finish();
}

// Columns: mover, other static, other mover, position, normal, impulse.
void touch_rows(const std::vector<Touch>& touches, std::vector<double>& out) {
  for (const Touch& t : touches) {
    out.insert(out.end(), {(double)t.mover, (double)t.other_static, (double)t.other_mover});
    double length = norm(t.normal);
    push(out, t.weight > 0 ? (1 / t.weight) * t.position : t.position);
    push(out, length > 0 ? (1 / length) * t.normal : t.normal);
    push(out, t.impulse);
  }
}

void pose_of(Stepper& s, const Doubles& qpos, Poses& p) {
  need((int)qpos.shape(0) == s.model.nq, "bad length of qpos");
  p.kin.resize(s.model);
  p.kin.update(s.model, qpos.data());
  p.kin.update_dofs(s.model, qpos.data());
  s.world.start_poses(p);
}

void inside_rows(const World& world, std::vector<double>& out) {
  for (const Inside& in : world.inside())
    out.insert(out.end(), {(double)in.mover, (double)in.other_static, (double)in.other_mover,
                           in.depth()});
}

nb::dict contact_rows(const std::vector<Contact>& contacts) {
  std::vector<double> n, t, u, imp, dist, target, shift, mu, bounce;
  for (const Contact& c : contacts) {
    push(n, c.n);
    push(t, c.t);
    push(u, c.s);
    push(imp, c.impulse);
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
  d["dist"] = array(dist);
  d["target"] = array(target);
  d["shift"] = array(shift);
  d["friction"] = array(mu);
  d["bounce"] = array(bounce);
  // Of both sides: the bodies that carry the point, 0: none more; its place on each, and their weights.
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

}  // namespace

void bind_physics(nb::module_& m) {
  nb::class_<MeshTree>(m, "MeshTree")
      .def("__init__",
           [](MeshTree* self, Rows3 vertices, Faces faces) {
             std::shared_ptr<const TriangleTree> tree;
             {
               nb::gil_scoped_release release;
               tree = TriangleTree::shared(vertices.data(), (int)vertices.shape(0), faces.data(),
                                           (int)faces.shape(0));
             }
             new (self) MeshTree{std::move(tree)};
           })
      .def("__len__", [](const MeshTree& t) { return t.tree->size(); })
      // How many hold the tree, this one included.
      .def_prop_ro("shares", [](const MeshTree& t) { return t.tree.use_count(); });

  nb::class_<Stepper>(m, "Stepper")
      .def(nb::init<>())
      .def("set_model", &set_model)
      .def("add_mover",
           [](Stepper& s, int body, int name, int person, int part, Rows3 vertices, Rows3 normals,
              double radius, Doubles rim) {
             Mover v;
             v.body = body, v.name = name, v.person = person, v.part = part;
             v.shape = convex(vertices, radius, rim, vectors(normals));
             s.world.movers.push_back(std::move(v));
           })
      .def("add_skin",
           // bend: (vertices, 3, features), or of no vertices: no pose blend shapes.
           [](Stepper& s, Ints body, Ints parent, Rows3 joint, Rows3 rest, Ints first, Ints at,
              Doubles weight, f64<nb::ndim<3>> bend) {
             auto skin = std::make_shared<Skin>();
             skin->body = list<int>(body), skin->parent = list<int>(parent);
             skin->joint = vectors(joint), skin->rest = vectors(rest);
             skin->first = list<int>(first), skin->at = list<int>(at);
             skin->weight = list<double>(weight);
             const size_t n = rest.shape(0), joints = joint.shape(0);
             need(body.shape(0) == joints && parent.shape(0) == joints && first.shape(0) == n + 1 &&
                      at.shape(0) == weight.shape(0) && (size_t)skin->first[n] == at.shape(0),
                  "add_skin: arrays that do not fit together");
             for (int b : skin->body) {
               need(b > 0 && b < s.model.nbody, "add_skin: no such body");
               skin->dof.push_back(s.model.dof_first[b]);
             }
             for (int j : skin->at) need(j >= 0 && (size_t)j < joints, "add_skin: no such joint");
             need(bend.shape(0) == 0 || (bend.shape(0) == n && bend.shape(1) == 3 &&
                                         bend.shape(2) == (size_t)skin->features()),
                  "add_skin: bend has the wrong shape");
             skin->bend.assign(bend.data(), bend.data() + bend.size());
             s.skins.push_back(std::move(skin));
             return (int)s.skins.size() - 1;
           })
      .def("add_skin_mover",
           [](Stepper& s, int skin, int name, int person, int part, Ints vertices) {
             Mover v;
             v.skin = s.skins.at(skin);
             v.name = name, v.person = person, v.part = part;
             v.vertex = list<int>(vertices);
             need(!v.vertex.empty(), "add_skin_mover: a hull needs at least one vertex");
             for (int i : v.vertex)
               need(i >= 0 && (size_t)i < v.skin->rest.size(), "add_skin_mover: no such vertex");
             v.finish();
             s.world.movers.push_back(std::move(v));
           })
      .def("add_half_space",
           [](Stepper& s, int name, Doubles n, double offset) {
             Static v;
             v.name = name, v.n = load3(n.data()), v.offset = offset;
             s.world.statics.push_back(std::move(v));
           })
      .def("add_hull",
           [](Stepper& s, int name, Rows3 vertices, Rows3 normals, double radius, Doubles rim) {
             Static v;
             v.kind = Static::Kind::Hull;
             v.name = name;
             v.shape = convex(vertices, radius, rim, vectors(normals));
             s.world.statics.push_back(std::move(v));
           })
      .def("add_mesh",
           [](Stepper& s, int name, const MeshTree& mesh) {
             Static v;
             v.kind = Static::Kind::Mesh;
             v.name = name;
             v.tree = mesh.tree;
             s.world.statics.push_back(std::move(v));
           })
      .def("set_pairings",
           [](Stepper& s, Square friction, Square restitution, Square ignore) {
             size_t n = friction.shape(0);
             need(friction.shape(1) == n && restitution.shape(0) == n &&
                      restitution.shape(1) == n && ignore.shape(0) == n && ignore.shape(1) == n,
                  "pairings must be square and of one size");
             s.world.n_names = (int)n;
             s.world.pairings.resize(n * n);
             for (size_t i = 0; i < n * n; i++)
               s.world.pairings[i] = {friction.data()[i], restitution.data()[i],
                                      ignore.data()[i] != 0};
           })
      .def("set_settings",
           [](Stepper& s, double stiffness, double drive_time, double recovery_rate,
              bool recover_root, double root_speed, double clearance, double clearance_range,
              double depenetration_speed, double tolerance, int max_sweeps, Doubles gravity) {
             s.drive_settings = {stiffness, drive_time, recovery_rate, recover_root, root_speed};
             s.world.settings = {clearance, depenetration_speed, tolerance, max_sweeps};
             s.clearance_range = clearance_range;
             s.gravity = load3(gravity.data());
           })
      .def("finish",
           [](Stepper& s, std::vector<int> person_roots) {
             // Hulls point at their own shapes: only now do the statics stop moving in memory.
             for (Static& v : s.world.statics)
               if (v.kind == Static::Kind::Hull) v.placed.place(v.shape, {}, {});
             s.finish(person_roots);
           })
      .def("reset",
           [](Stepper& s, Doubles qpos, Doubles qvel) {
             need((int)qpos.shape(0) == s.model.nq && (int)qvel.shape(0) == s.model.nv,
                  "reset: bad length of qpos or qvel");
             s.reset(qpos.data(), qvel.data());
           })
      .def("frame",
           [](Stepper& s, Doubles targets, double dt, int n, bool record) {
             int want = 0;
             for (int p = 0; p < s.person_count(); p++) want += s.person_qpos_count(p);
             need((int)targets.shape(0) == want, "frame: bad length of targets");
             std::vector<double> poses;
             {
               nb::gil_scoped_release release;
               s.frame(targets.data(), dt, n, record ? &poses : nullptr);
             }
             const size_t nq = s.model.nq;
             return array({poses.size() / std::max<size_t>(nq, 1), nq}, poses);
           })
      .def("run",
           [](Stepper& s, Square targets, double dt, int n, bool record, double seconds) {
             // As many frames as fit into `seconds` of wall time, one at least.
             int want = 0;
             for (int p = 0; p < s.person_count(); p++) want += s.person_qpos_count(p);
             need((int)targets.shape(1) == want && targets.shape(0) > 0, "run: bad shape of targets");
             std::vector<double> qpos, poses, clearance, lost, touches, counts, numbers, inside,
                 inside_counts;
             size_t done = 0;
             {
               nb::gil_scoped_release release;
               const auto begin = std::chrono::steady_clock::now();
               auto spent = [&]() {
                 return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
                     .count();
               };
               do {
                 s.frame(targets.data() + done * want, dt, n, record ? &poses : nullptr);
                 qpos.insert(qpos.end(), s.qpos().begin(), s.qpos().end());
                 clearance.push_back(s.clearance());
                 const Diagnostics& g = s.diagnostics();
                 lost.push_back(g.lost_time);
                 numbers.insert(numbers.end(),
                                {(double)g.candidates, (double)g.contacts, (double)g.passes,
                                 (double)g.sweeps, (double)g.shortened, g.residual});
                 counts.push_back((double)s.touches().size());
                 touch_rows(s.touches(), touches);
                 inside_counts.push_back((double)s.world.inside().size());
                 inside_rows(s.world, inside);
                 done++;
               } while (done < targets.shape(0) && spent() < seconds);
             }
             size_t nq = s.model.nq;
             nb::dict d;
             d["qpos"] = array({done, nq}, qpos);
             d["clearance"] = array(clearance);
             d["lost_time"] = array(lost);
             // planes, contacts, passes, sweeps, shortened, residual
             d["diagnostics"] = array({done, 6}, numbers);
             d["touch_count"] = array(counts);
             d["touches"] = array({touches.size() / 12, 12}, touches);
             d["inside_count"] = array(inside_counts);
             d["inside"] = array({inside.size() / 4, 4}, inside);
             d["substeps"] = array({poses.size() / std::max<size_t>(nq, 1), nq}, poses);
             return d;
           })
      .def("person_qpos", &Stepper::person_qpos)
      .def("person_qpos_count", &Stepper::person_qpos_count)
      .def("qpos", [](Stepper& s) { return array(s.qpos()); })
      .def("qvel", [](Stepper& s) { return array(s.qvel()); })
      .def("clearance",
           [](Stepper& s) {
             nb::gil_scoped_release release;
             return s.clearance();
           })
      // Of poses (T, nq): distances (T, movers); `nearest` (T, movers) is filled with statics.
      .def("clearances",
           [](Stepper& s, Square qpos, double range, std::optional<Indices> nearest) {
             const size_t poses = qpos.shape(0), n = s.world.movers.size();
             need((int)qpos.shape(1) == s.model.nq, "clearances: bad shape of qpos");
             need(!nearest || (nearest->shape(0) == poses && nearest->shape(1) == n),
                  "clearances: bad shape of nearest");
             std::vector<double> dist(poses * n);
             std::vector<int> others(nearest ? 0 : poses * n);
             {
               nb::gil_scoped_release release;
               s.clearances(qpos.data(), poses, range, dist.data(),
                            nearest ? nearest->data() : others.data());
             }
             return array({poses, n}, dist);
           },
           nb::arg("qpos"), nb::arg("range"), nb::arg("nearest") = nb::none())
      .def("touches",
           [](Stepper& s) {
             std::vector<double> out;
             touch_rows(s.touches(), out);
             return array({s.touches().size(), 12}, out);
           })
      .def("diagnostics",
           [](Stepper& s) {
             const Diagnostics& d = s.diagnostics();
             nb::dict out;
             out["planes"] = d.candidates;
             out["contacts"] = d.contacts;
             out["passes"] = d.passes;
             out["sweeps"] = d.sweeps;
             out["shortened"] = d.shortened;
             out["residual"] = d.residual;
             out["lost_time"] = d.lost_time;
             return out;
           })
      // Who started inside something and is not out yet: mover, static, other mover, depth [m].
      .def("inside",
           [](Stepper& s) {
             std::vector<double> out;
             inside_rows(s.world, out);
             return array({out.size() / 4, 4}, out);
           })
      .def("save", [](Stepper& s) { return array(s.save()); })
      .def("load", [](Stepper& s, Doubles state) { s.load(list<double>(state)); })
      .def("keep_pieces", [](Stepper& s, bool on) { s.keep_pieces = on; })
      .def("keep_times", [](Stepper& s, bool on) { s.keep_times = on; })
      .def("solve_times", [](Stepper& s) { return array(s.solve_times); })
      .def("keep_trace", [](Stepper& s, bool on) { s.keep_trace = on; })
      .def("trace",
           [](Stepper& s) {
             nb::dict d;
             d["qpos"] = array(s.trace.qpos);
             d["qvel"] = array(s.trace.qvel);
             d["v_free"] = array(s.trace.v_free);
             d["v"] = array(s.trace.v);
             d["h"] = s.trace.h;
             d["substep"] = s.trace.k;
             d["contacts"] = contact_rows(s.trace.contacts);
             return d;
           })
      // Kinematics and inertia on their own, for tests against other engines.
      .def("body_frames",
           [](Stepper& s, Doubles qpos) {
             Kinematics k;
             k.resize(s.model);
             k.update(s.model, qpos.data());
             std::vector<double> x, q;
             for (Vec3 p : k.xpos) push(x, p);
             for (Quat r : k.xquat) q.insert(q.end(), {r.w, r.x, r.y, r.z});
             size_t n = s.model.nbody;
             return nb::make_tuple(array({n, 3}, x), array({n, 4}, q));
           })
      .def("inertia_matrix",
           [](Stepper& s, Doubles qpos) {
             const Model& mod = s.model;
             Kinematics k;
             k.resize(mod);
             k.update(mod, qpos.data());
             k.update_dofs(mod, qpos.data());
             Inertia inertia;
             inertia.compose(mod, k);
             size_t n = mod.nv;
             std::vector<double> M(n * n, 0);
             for (size_t i = 0; i < n; i++)
               for (int a = 0; a < mod.row_size[i]; a++) {
                 int j = mod.chain[mod.row_start[i] + a];
                 M[i * n + j] = M[j * n + i] = inertia.M[mod.row_start[i] + a];
               }
             return array({n, n}, M);
           })
      // Vertices of the skin that are a mover's corners; none: it is rigid.
      .def("mover_vertices",
           [](Stepper& s, int mover) {
             const std::vector<int>& v = s.world.movers.at(mover).vertex;
             return array(std::vector<double>(v.begin(), v.end()));
           })
      // Of a mover at a pose: its corners (n, 3), and the Jacobian (3, nv) of one of them.
      .def("mover_points",
           [](Stepper& s, Doubles qpos, int mover) {
             Poses p;
             pose_of(s, qpos, p);
             const Points at = s.world.place(p, mover).points();
             std::vector<double> x;
             for (int i = 0; i < at.n; i++) push(x, at.at(i));
             return array({(size_t)at.n, 3}, x);
           })
      .def("mover_jacobian",
           [](Stepper& s, Doubles qpos, int mover, int corner) {
             Poses p;
             pose_of(s, qpos, p);
             const Mover& m = s.world.movers.at(mover);
             const Placed& at = s.world.place(p, mover);
             const Endpoint e = p.endpoint(m, at, p.material(m, at, at.points().at(corner)));
             const size_t n = s.model.nv;
             std::vector<double> J(3 * n), v(n, 0);
             std::vector<Twist> twists;
             for (size_t i = 0; i < n; i++) {
               v[i] = 1;
               body_twists(s.model, p.kin, v.data(), twists);
               const Vec3 x = endpoint_velocity(s.model, p.kin, twists, v.data(), e);
               for (int k = 0; k < 3; k++) J[k * n + i] = x[k];
               v[i] = 0;
             }
             return array({3, n}, J);
           })
      .def("inertia_solve",
           [](Stepper& s, Doubles qpos, Doubles x) {
             const Model& mod = s.model;
             Kinematics k;
             k.resize(mod);
             k.update(mod, qpos.data());
             k.update_dofs(mod, qpos.data());
             Inertia inertia;
             inertia.compose(mod, k);
             inertia.factor(mod, std::vector<double>(mod.nv, 1), std::vector<double>(mod.nv, 0));
             std::vector<double> y = list<double>(x);
             inertia.solve(mod, y.data());
             return array(y);
           })
      .def("integrate", [](Stepper& s, Doubles qpos, Doubles qvel, double t) {
        std::vector<double> q = list<double>(qpos);
        integrate(s.model, q.data(), qvel.data(), t);
        return array(q);
      });

  // Contacts w = beta + A p on their own: impulses, sweeps and steps, what is left of it all and of the
  // normals alone [m/s].
  m.def("solve_contacts", [](Square A, Doubles beta, Doubles mu, Ints pairs, Doubles warm,
                             double tolerance, double fine, int most) {
    const size_t n = mu.shape(0), n3 = 3 * n;
    need(A.shape(0) == n3 && A.shape(1) == n3 && beta.shape(0) == n3 && warm.shape(0) == n3 &&
             pairs.shape(0) == n,
         "solve_contacts: A (3n, 3n), beta (3n,), mu (n,), pairs (n,), warm (3n,)");
    ContactProblem problem;
    problem.clear((int)n);
    for (size_t i = 0; i < n; i++) {
      for (size_t j = 0; j <= i; j++)
        for (size_t r = 0; r < 3; r++)
          for (size_t c = 0; c < 3; c++) {
            const double a = A.data()[(3 * i + r) * n3 + 3 * j + c];
            problem.A((int)i, (int)j)[r * problem.stride() + c] = a;
            problem.A((int)j, (int)i)[c * problem.stride() + r] = a;
          }
      problem.add(beta.data() + 3 * i, warm.data() + 3 * i, mu.data()[i], pairs.data()[i]);
    }
    SolveReport report;
    {
      nb::gil_scoped_release release;
      problem.solve(tolerance, fine, most, report);
    }
    return nb::make_tuple(array(problem.p), report.sweeps, report.residual, report.normal);
  });
  // Impulses of one contact for each row of r (k, 3); `old` says where to look first.
  m.def("coulomb_contact", [](Square A, double mu, Rows3 r, Rows3 old) {
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
  });
  // Distance of two convex shapes; normals (may be empty) decide the way out of an overlap.
  m.def("convex_distance", [](Rows3 a, Rows3 normals_a, double ra, Doubles rim_a, Rows3 b,
                              Rows3 normals_b, double rb, Doubles rim_b) {
    Convex A = convex(a, ra, rim_a, vectors(normals_a)), B = convex(b, rb, rim_b, vectors(normals_b));
    Placed pa, pb;
    pa.place(A, {}, {});
    pb.place(B, {}, {});
    Separation s = separate(pa, pb);
    std::vector<double> n, x, y;
    push(n, s.n);
    push(x, s.pa);
    push(y, s.pb);
    return nb::make_tuple(s.dist, array(n), array(x), array(y));
  });
  // Planes (normal, offset, distance, triangle) between a convex shape and triangles.
  m.def("triangle_planes", [](Rows3 vertices, Faces faces, Rows3 hull, double radius, Doubles rim,
                              double reach) {
    TriangleTree tree(vertices.data(), (int)vertices.shape(0), faces.data(), (int)faces.shape(0));
    Convex A = convex(hull, radius, rim);
    Placed p;
    p.place(A, {}, {});
    std::vector<Plane> planes;
    tree.planes(p, reach, planes);
    std::vector<double> out;
    for (const Plane& q : planes) {
      push(out, q.n);
      out.insert(out.end(), {q.offset, q.dist, (double)tree.face(q.triangle)});
    }
    return nb::make_tuple(array({planes.size(), 6}, out), tree.distance(p, reach));
  });
}
