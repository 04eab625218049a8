// Python face of the stepper. Arrays are copied in once; frames run without the GIL.
#include <nanobind/stl/optional.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "bindings/arrays.h"
#include "stepping/stepper.h"

using namespace hp;

// Looks inside, for tests and measures (bind_probes.cpp).
void bind_probes(nb::module_& m, nb::class_<Stepper>& stepper);

namespace {

// The tree of a static mesh in the world frame, shared by whoever asks for the same triangles.
struct MeshTree {
  std::shared_ptr<const TriangleTree> tree;
};

void set_model(Stepper& s, Ints parent, Ints jnt_first, Ints jnt_count, Ints dof_first,
               Ints dof_count, Rows3 pos, Rows4 quat, Rows3 ipos, Rows4 iquat, Doubles mass,
               Rows3 inertia, Ints jnt_type, Ints jnt_qpos, Ints jnt_dof, Ints jnt_body,
               Rows3 jnt_pos, Rows3 jnt_axis, Doubles qpos0, Doubles armature) {
  Model& m = s.system.model;
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

void set_stiffness(Stepper& s, const double* lambda) {
  for (int p = 0; p < (int)s.system.drives.size(); lambda += s.system.drives[p].ball_count(), p++)
    s.system.drives[p].set_stiffness(lambda);
}

// Columns: shape, other static, other shape, position, normal, impulse.
void touch_rows(const std::vector<Touch>& touches, std::vector<double>& out) {
  for (const Touch& t : touches) {
    out.insert(out.end(), {(double)t.shape, (double)t.other_static, (double)t.other_shape});
    double length = norm(t.normal);
    push(out, t.weight > 0 ? (1 / t.weight) * t.position : t.position);
    push(out, length > 0 ? (1 / length) * t.normal : t.normal);
    push(out, t.impulse);
  }
}

void inside_rows(const World& world, std::vector<double>& out) {
  for (const Inside& in : world.inside())
    out.insert(out.end(), {(double)in.shape, (double)in.other_static, (double)in.other_shape,
                           in.depth()});
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

  nb::class_<Stepper> stepper(m, "Stepper");
  stepper.def(nb::init<>())
      .def("set_model", &set_model)
      .def("add_mover",
           [](Stepper& s, int body, int name, int person, int part, Rows3 vertices, Rows3 normals,
              double radius, Doubles rim) {
             CollisionShape v;
             v.body = body, v.name = name, v.person = person, v.part = part;
             v.hull = convex(vertices, radius, rim, vectors(normals));
             s.system.world.shapes.push_back(std::move(v));
           })
      // Poses (K, 3), (K, 4) of a body, K of them `fps` to the second; see Trajectory.
      .def("add_trajectory",
           [](Stepper& s, int body, double fps, bool loop, Rows3 position, Rows4 turn) {
             s.add_trajectory({body, fps, loop, vectors(position), quats(turn)});
           })
      .def("start_asleep", &Stepper::start_asleep)
      .def("set_velocity",
           [](Stepper& s, int body, Doubles six) {
             need(six.shape(0) == 6, "set_velocity: expected six numbers");
             s.set_velocity(body, six.data());
           })
      .def("adopt",
           [](Stepper& s, Stepper& old, Ints body, Ints shape) {
             s.adopt(old, list<int>(body), list<int>(shape));
           })
      .def("set_slack",
           // Of the last shape: how far it sticks out of the surface that it stands for [m].
           [](Stepper& s, double slack) {
             need(!s.system.world.shapes.empty() && slack >= 0, "set_slack: no shape, or less than 0");
             s.system.world.shapes.back().slack = slack;
           })
      .def("add_skin",
           // bend: (vertices, 3, features), or of no vertices: no pose blend shapes.
           [](Stepper& s, Ints body, Ints parent, Rows3 joint, Rows3 rest, Ints first, Ints at,
              Doubles weight, f64<nb::ndim<3>> bend) {
             auto skin = std::make_shared<Skin>();
             skin->body = list<int>(body), skin->parent = list<int>(parent);
             skin->joint = vectors(joint), skin->rest = vectors(rest);
             skin->first_weight = list<int>(first), skin->weight_joint = list<int>(at);
             skin->weight = list<double>(weight);
             const size_t n = rest.shape(0), joints = joint.shape(0);
             need(body.shape(0) == joints && parent.shape(0) == joints && first.shape(0) == n + 1 &&
                      at.shape(0) == weight.shape(0) && (size_t)skin->first_weight[n] == at.shape(0),
                  "add_skin: arrays that do not fit together");
             for (int b : skin->body) {
               need(b > 0 && b < s.system.model.nbody, "add_skin: no such body");
               skin->dof.push_back(s.system.model.dof_first[b]);
             }
             for (int j : skin->weight_joint) need(j >= 0 && (size_t)j < joints, "add_skin: no such joint");
             need(bend.shape(0) == 0 || (bend.shape(0) == n && bend.shape(1) == 3 &&
                                         bend.shape(2) == (size_t)skin->features()),
                  "add_skin: bend has the wrong shape");
             skin->pose_blend.assign(bend.data(), bend.data() + bend.size());
             s.system.skins.push_back(std::move(skin));
             return (int)s.system.skins.size() - 1;
           })
      .def("add_skin_mover",
           [](Stepper& s, int skin, int name, int person, int part, Ints vertices) {
             CollisionShape v;
             v.skin = s.system.skins.at(skin);
             v.name = name, v.person = person, v.part = part;
             v.vertex = list<int>(vertices);
             need(!v.vertex.empty(), "add_skin_mover: a hull needs at least one vertex");
             for (int i : v.vertex)
               need(i >= 0 && (size_t)i < v.skin->rest.size(), "add_skin_mover: no such vertex");
             v.finish();
             s.system.world.shapes.push_back(std::move(v));
           })
      .def("add_half_space",
           [](Stepper& s, int name, Doubles n, double offset) {
             Static v;
             v.name = name, v.n = load3(n.data()), v.offset = offset;
             s.system.world.statics.push_back(std::move(v));
           })
      .def("add_hull",
           [](Stepper& s, int name, Rows3 vertices, Rows3 normals, double radius, Doubles rim) {
             Static v;
             v.kind = Static::Kind::Hull;
             v.name = name;
             v.hull = convex(vertices, radius, rim, vectors(normals));
             s.system.world.statics.push_back(std::move(v));
           })
      .def("add_mesh",
           [](Stepper& s, int name, const MeshTree& mesh) {
             Static v;
             v.kind = Static::Kind::Mesh;
             v.name = name;
             v.tree = mesh.tree;
             s.system.world.statics.push_back(std::move(v));
           })
      .def("set_pairings",
           [](Stepper& s, Square friction, Square restitution, Square ignore) {
             size_t n = friction.shape(0);
             need(friction.shape(1) == n && restitution.shape(0) == n &&
                      restitution.shape(1) == n && ignore.shape(0) == n && ignore.shape(1) == n,
                  "pairings must be square and of one size");
             s.system.world.n_names = (int)n;
             s.system.world.pairings.resize(n * n);
             for (size_t i = 0; i < n * n; i++)
               s.system.world.pairings[i] = {friction.data()[i], restitution.data()[i],
                                      ignore.data()[i] != 0};
           })
      .def("set_settings",
           [](Stepper& s, double drive_time, double recovery_rate,
              bool recover_root, double root_speed, double clearance, double clearance_range,
              double depenetration_speed, double tolerance, int max_sweeps, Doubles gravity) {
             s.system.drive_settings = {drive_time, recovery_rate, recover_root, root_speed};
             s.system.world.settings = {clearance, depenetration_speed, tolerance, max_sweeps};
             s.system.clearance_range = clearance_range;
             s.system.gravity = load3(gravity.data());
           })
      // After set_settings: what is there to compare with, see DriveSettings.
      .def("set_ablations",
           [](Stepper& s, bool internal_forces, double joint_damping, double torque_frequency,
              double torque_damping) {
             DriveSettings& d = s.system.drive_settings;
             d.internal_forces = internal_forces, d.joint_damping = joint_damping;
             d.torque_frequency = torque_frequency, d.torque_damping = torque_damping;
           })
      // In the order of set_model: per dof, per joint, per coordinate, and two per joint.
      .def("set_joint_forces",
           [](Stepper& s, Doubles damping, Doubles stiffness, Doubles spring, Ints limited,
              Rows2 range) {
             const Model& m = s.system.model;
             need((int)damping.shape(0) == m.nv && (int)stiffness.shape(0) == m.njnt &&
                      (int)spring.shape(0) == m.nq && (int)limited.shape(0) == m.njnt &&
                      (int)range.shape(0) == m.njnt,
                  "set_joint_forces: arrays that do not fit the model");
             JointForces& f = s.system.articulations.joints;
             f.damping = list<double>(damping), f.stiffness = list<double>(stiffness);
             f.spring = list<double>(spring);
             f.limited.assign(m.njnt, 0), f.lower.assign(m.njnt, 0), f.upper.assign(m.njnt, 0);
             for (int j = 0; j < m.njnt; j++) {
               f.limited[j] = limited.data()[j] != 0;
               f.lower[j] = range.data()[2 * j], f.upper[j] = range.data()[2 * j + 1];
             }
           })
      .def("finish",
           [](Stepper& s, std::vector<int> person_roots) {
             // Hulls point at their own shapes: only now do the statics stop moving in memory.
             for (Static& v : s.system.world.statics)
               if (v.kind == Static::Kind::Hull) v.posed.place(v.hull, {}, {});
             s.finish(person_roots);
           })
      .def("reset",
           [](Stepper& s, Doubles qpos, Doubles qvel) {
             need((int)qpos.shape(0) == s.system.model.nq && (int)qvel.shape(0) == s.system.model.nv,
                  "reset: bad length of qpos or qvel");
             s.reset(qpos.data(), qvel.data());
           })
      .def("frame",
           [](Stepper& s, Doubles targets, double dt, int n, bool record) {
             int want = 0;
             for (int p = 0; p < (int)s.system.drives.size(); p++) want += s.system.drives[p].qpos_count();
             need((int)targets.shape(0) == want, "frame: bad length of targets");
             std::vector<double> poses;
             {
               nb::gil_scoped_release release;
               s.frame(targets.data(), dt, n, record ? &poses : nullptr);
             }
             const size_t nq = s.system.model.nq;
             return array({poses.size() / std::max<size_t>(nq, 1), nq}, poses);
           })
      .def("run",
           [](Stepper& s, Square targets, double dt, int n, bool record, double seconds,
              Square stiffness) {
             // As many frames as fit into `seconds` of wall time, one at least.
             int want = 0;
             for (int p = 0; p < (int)s.system.drives.size(); p++) want += s.system.drives[p].qpos_count();
             need((int)targets.shape(1) == want && targets.shape(0) > 0, "run: bad shape of targets");
             // Firmness of every frame (frames, balls), or (0, 0) to leave it.
             const size_t balls = stiffness.shape(0) ? stiffness.shape(1) : 0;
             need(balls == 0 || (stiffness.shape(0) == targets.shape(0) && (int)balls == s.system.ball_count()),
                  "run: bad shape of stiffness");
             std::vector<double> torques, torque_frames;
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
                 if (balls > 0) set_stiffness(s, stiffness.data() + done * balls);
                 s.frame(targets.data() + done * want, dt, n, record ? &poses : nullptr);
                 if (s.torques(torques)) torque_frames.push_back((double)done);
                 qpos.insert(qpos.end(), s.qpos().begin(), s.qpos().end());
                 clearance.push_back(s.clearance());
                 const Diagnostics& g = s.result().diagnostics;
                 lost.push_back(g.lost_time);
                 numbers.insert(numbers.end(),
                                {(double)g.candidates, (double)g.contacts, (double)g.passes,
                                 (double)g.sweeps, (double)g.shortened, g.residual});
                 counts.push_back((double)s.result().touches.size());
                 touch_rows(s.result().touches, touches);
                 inside_counts.push_back((double)s.system.world.inside().size());
                 inside_rows(s.system.world, inside);
                 done++;
               } while (done < targets.shape(0) && spent() < seconds);
             }
             size_t nq = s.system.model.nq;
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
             d["torque_frames"] = array(torque_frames);
             d["torques"] = array({torque_frames.size(), (size_t)s.system.ball_count(), 3}, torques);
             d["substeps"] = array({poses.size() / std::max<size_t>(nq, 1), nq}, poses);
             return d;
           })
      // Before finish(): people's poses are set, see Forced.
      .def("set_forced",
           [](Stepper& s, int how) {
             need(how >= 0 && how <= 3, "set_forced: no such way");
             s.system.prescribed = static_cast<Prescribed>(how);
             s.system.world.forced = how > 0;
           })
      // In somebody else's world: see Stepper::begin_hosted.
      .def("begin_hosted",
           [](Stepper& s, Doubles targets, double dt) {
             int want = 0;
             for (int p = 0; p < (int)s.system.drives.size(); p++) want += s.system.drives[p].qpos_count();
             need((int)targets.shape(0) == want, "begin_hosted: bad length of targets");
             s.begin_hosted(targets.data(), dt);
           })
      .def("substep_hosted",
           [](Stepper& s, int k, double h, Doubles qpos, Doubles qvel, Doubles free,
              Doubles damping) {
             const size_t nq = s.system.model.nq, nv = s.system.model.nv;
             need(qpos.shape(0) == nq && qvel.shape(0) == nv && free.shape(0) == nv &&
                      damping.shape(0) == nv,
                  "substep_hosted: bad length of qpos, qvel, free or damping");
             nb::gil_scoped_release release;
             s.substep_hosted(k, h, qpos.data(), qvel.data(), free.data(), damping.data());
           })
      .def("end_hosted", &Stepper::end_hosted)
      // Bodies whose tree was touched in the substep before (a person's: in the frame).
      .def("disturbed",
           [](Stepper& s) {
             return array(std::vector<double>(s.result().disturbed.begin(), s.result().disturbed.end()));
           })
      // lambda of every ball joint of all people, in the model's order, roots (ignored) included.
      .def("set_stiffness",
           [](Stepper& s, Doubles lambda) {
             need((int)lambda.shape(0) == s.system.ball_count(), "set_stiffness: bad length");
             set_stiffness(s, lambda.data());
           })
      .def("stiffness",
           [](Stepper& s) {
             std::vector<double> out;
             for (int p = 0; p < (int)s.system.drives.size(); p++)
               out.insert(out.end(), s.system.drives[p].stiffness().begin(), s.system.drives[p].stiffness().end());
             return array(out);
           })
      // Per person the root's force [N], then the torque of every ball joint [N m]; inf: no limit.
      .def("set_strength",
           [](Stepper& s, int person, Doubles limits) {
             need(person >= 0 && person < (int)s.system.drives.size() &&
                      (int)limits.shape(0) == s.system.drives[person].ball_count() + 1,
                  "set_strength: bad person or length");
             s.system.drives[person].limits = list<double>(limits);
           })
      // Of the last frame (balls, 3), see Stepper::torques; (0, 3): none.
      .def("torques",
           [](Stepper& s) {
             std::vector<double> out;
             s.torques(out);
             return array({out.size() / 3, 3}, out);
           })
      // Pairs (n, 2) of one person's shapes that may touch each other, the smaller index first.
      .def("set_self_pairs",
           [](Stepper& s, Square pairs) {
             const int n = (int)s.system.world.shapes.size();
             need(pairs.shape(0) == 0 || pairs.shape(1) == 2, "self pairs must be (n, 2)");
             std::vector<std::pair<int, int>> list;
             for (size_t k = 0; k < pairs.shape(0); k++) {
               const int i = (int)pairs.data()[2 * k], j = (int)pairs.data()[2 * k + 1];
               need(0 <= i && i < j && j < n, "self pairs: no such shapes");
               need(s.system.model.root[s.system.world.shapes[i].body] == s.system.model.root[s.system.world.shapes[j].body],
                    "self pairs: not of one tree");
               list.push_back({i, j});
             }
             s.system.world.set_self_pairs(list);
           })
      // Distances (n,) of pairs of shapes (n, 2) at a pose [m], negative where they overlap.
      .def("pair_gaps",
           [](Stepper& s, Doubles qpos, Square pairs) {
             const size_t n = s.system.world.shapes.size();
             need((int)qpos.shape(0) == s.system.model.nq, "pair_gaps: bad length of qpos");
             need(pairs.shape(0) == 0 || pairs.shape(1) == 2, "pair_gaps: pairs must be (n, 2)");
             std::vector<double> gaps;
             Poses p;  // of its own
             p.kin.resize(s.system.model);
             p.kin.update(s.system.model, qpos.data());
             s.system.world.start_poses(p);
             for (size_t k = 0; k < pairs.shape(0); k++) {
               const size_t i = (size_t)pairs.data()[2 * k], j = (size_t)pairs.data()[2 * k + 1];
               need(i < n && j < n, "pair_gaps: no such shapes");
               gaps.push_back(s.system.world.gap(p, (int)i, (int)j));
             }
             return array(gaps);
           })
      .def("person_qpos", [](Stepper& s, int p) { return s.system.drives.at(p).first_qpos(); })
      .def("person_qpos_count", [](Stepper& s, int p) { return s.system.drives.at(p).qpos_count(); })
      .def("qpos", [](Stepper& s) { return array(s.qpos()); })
      .def("qvel", [](Stepper& s) { return array(s.qvel()); })
      .def("clearance",
           [](Stepper& s) {
             nb::gil_scoped_release release;
             return s.clearance();
           })
      // Of poses (T, nq): distances (T, shapes); `nearest` (T, shapes) is filled with statics.
      .def("clearances",
           [](Stepper& s, Square qpos, double range, std::optional<Indices> nearest) {
             const size_t poses = qpos.shape(0), n = s.system.world.shapes.size();
             need((int)qpos.shape(1) == s.system.model.nq, "clearances: bad shape of qpos");
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
             touch_rows(s.result().touches, out);
             return array({s.result().touches.size(), 12}, out);
           })
      .def("diagnostics",
           [](Stepper& s) {
             const Diagnostics& d = s.result().diagnostics;
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
      // Who started inside something and is not out yet: shape, static, other shape, depth [m].
      .def("inside",
           [](Stepper& s) {
             std::vector<double> out;
             inside_rows(s.system.world, out);
             return array({out.size() / 4, 4}, out);
           })
      .def("save", [](Stepper& s) { return array(s.save()); })
      .def("load", [](Stepper& s, Doubles state) { s.load(list<double>(state)); });
  bind_probes(m, stepper);
}
