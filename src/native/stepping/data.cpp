#include "stepping/data.h"

#include "tuning.h"

namespace hp {

void State::update_pose(System& system) {
  if (pose_known) return;
  system.world.active.assign(system.model.nbody, 1);
  pose.kin.update(system.model, qpos.data());
  system.world.start_poses(pose);
  pose_known = true;
}

void Step::find_end(const System& system, const State& state, const std::vector<double>& vel,
                    double h) {
  end_qpos = state.qpos;
  integrate(system.model, end_qpos.data(), vel.data(), h, system.world.active.data());
  end.placed = 0;  // what it was before is paid for
}

void Step::pose_end(const System& system, const std::vector<double>& vel, double h) {
  const char* active = system.world.active.data();
  end.kin.update(system.model, end_qpos.data(), active);
  system.world.start_poses(end);
  end.way.resize(vel.size());
  for (size_t i = 0; i < vel.size(); i++)
    end.way[i] = active[system.model.dof_body[i]] ? h * vel[i] : 0;
}

const std::vector<double>& Step::way(const System& system, const State& state) {
  if (way_stamp_ != end.stamp)
    travel_bounds(system.world.shapes, state.pose, end, system.world.active, way_);
  way_stamp_ = end.stamp;
  return way_;
}

void FrameResult::clear(int nbody) {
  touches.clear();
  soft.clear();
  points.clear();
  breaches.clear();
  diagnostics = {};
  disturbed.assign(nbody, 0);
}

void FrameResult::add(const ContactCandidate& candidate, const Contact& contact) {
  if (keep_points)
    points.push_back({candidate.shape, candidate.other_static, candidate.other_shape,
                      contact.position, contact.n, contact.impulse, contact.dist});
  Touch* t = nullptr;
  for (Touch& o : touches)
    if (o.shape == candidate.shape && o.other_static == candidate.other_static &&
        o.other_shape == candidate.other_shape &&
        dot(o.normal, contact.n) > tuning::stepping::kSameNormal * norm(o.normal))
      t = &o;
  if (!t) {
    touches.push_back(
        {candidate.shape, candidate.other_static, candidate.other_shape, {}, {}, {}, 0});
    t = &touches.back();
  }
  const double p = dot(contact.impulse, contact.n);
  t->position += p * contact.position;
  t->normal += p * contact.n;
  t->impulse += contact.impulse;
  t->weight += p;
}

void FrameResult::add(const Breach& breach) {
  for (Breach& b : breaches)
    if (pair_key(b.pair) == pair_key(breach.pair)) {
      b.depth = std::max(b.depth, breach.depth);
      return;
    }
  breaches.push_back(breach);
}

void Data::finish(const System& system) {
  const Model& m = system.model;
  state.qpos.assign(m.nq, 0);
  state.exit_path.assign(m.nbody, 0);
  for (auto* v : {&state.qvel, &step.v_free, &step.v, &step.spin, &step.joint_pull})
    v->assign(m.nv, 0);
  step.pushed.assign(m.nbody, 0);
  step.yielded.assign(m.nbody, 0);
  step.yielded_before = step.yielded;
  step.resistance.finish(m, system.drives.size());
  inertia.finish(m);
  state.pose.kin.resize(m);
  step.end.kin.resize(m);
}

double approach(const Model& m, const Kinematics& k, const Contact& c,
                const std::vector<Twist>& twists, const std::vector<double>& v) {
  return dot(c.n, endpoint_velocity(m, k, twists, v.data(), c.a) -
                      endpoint_velocity(m, k, twists, v.data(), c.b));
}

}  // namespace hp
