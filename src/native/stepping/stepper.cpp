#include "stepping/stepper.h"

#include <stdexcept>

namespace hp {

namespace {

// What is stepped through may stray this far from what it would do by itself before those who
// follow their motion are asked again [m].
constexpr double kStray = 0.03;
// A thing that turns farther than this in a substep makes it in parts, as many as it takes to turn
// less than a quarter of that in each, within bounds [rad].
constexpr double kTurn = 1.0;
constexpr int kMostParts = 32;

}  // namespace

void Stepper::finish(const std::vector<int>& person_roots) {
  model.finish();
  drives_.clear();
  person_.assign(model.nbody, 0);
  for (int root : person_roots) {
    if (root <= 0 || root >= model.nbody) throw std::invalid_argument("bad root body");
    drives_.emplace_back(model, root);
    person_[root] = 1;
  }
  find_carried();
  objects_.clear();
  std::vector<int> tree_size(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) tree_size[model.root[b]]++;
  for (int b = 1; b < model.nbody; b++)
    if (!person_[b] && model.jnt_count[b] == 1 && tree_size[b] == 1 &&
        model.jnt_type[model.jnt_first[b]] == Joint::Free)
      objects_.push_back(b);
  std::vector<char> others = person_;
  for (int b : objects_) others[b] = 1;
  articulations.finish(model, others);
  for (CollisionShape& m : world.shapes) {
    if (m.body <= 0 || m.body >= model.nbody) throw std::invalid_argument("bad body of a shape");
    m.finish();
  }
  way_out_.assign(model.nbody, 0);
  joint_reach_.assign(model.nbody, 0);
  for (const CollisionShape& m : world.shapes)
    for (const CollisionShape::Tie& t : m.ties) {
      double far = norm(t.anchor) + t.reach;
      for (int b = t.body; b > 0; far += norm(model.pos[b]), b = model.parent[b])
        joint_reach_[b] = std::max(joint_reach_[b], far);
    }
  qpos_.assign(model.nq, 0);
  touched_.assign(model.nbody, 0);
  pushed_now_.assign(model.nbody, 0);
  holds_.assign(drives_.size(), 1);
  for (auto* v : {&qvel_, &v_free_, &v_, &spin_, &extra_, &torque_, &moved_, &pull_, &resist_, &change_,
                  &pushed_, &exerted_, &stiff_, &softer_, &load_})
    v->assign(model.nv, 0);
  overcome_.assign(drives_.size(), 0);
  share_.assign(model.nv, 1);
  world.standing.assign(model.nbody, 0);
  scale_.assign(model.nv, 1);
  world.asleep.assign(model.nbody, 0);
  world.pace.assign(model.nbody, 1);
  world.squeezed.assign(model.nbody, 0);
  push_.assign(model.nbody, {});
  for (const Track& t : tracks_) model.held[t.body] = 1;
  behind_.assign(model.nbody, 0);
  clock_.assign(tracks_.size(), 0);
  pace_.assign(tracks_.size(), {});
  start_.kin.resize(model);
  end_.kin.resize(model);
}

void Stepper::reset(const double* qpos, const double* qvel) {
  qpos_.assign(qpos, qpos + model.nq);
  qvel_.assign(qvel, qvel + model.nv);
  for (Drive& d : drives_) d.reset(&qpos_[d.first_qpos()], qvel_.data());
  warm_.clear();
  touches_.clear();
  solve_times.clear();
  world.forget();
  pose_known_ = false;
  start_pose();
  world.asleep.assign(model.nbody, 0);  // what they rest on is known when they wake
  world.pace.assign(model.nbody, 1);
  world.squeezed.assign(model.nbody, 0);
  push_.assign(model.nbody, {});
  if (forced != Forced::No) leave_people();
  world.reset(model, start_);
  for (int b : start_asleep_) world.asleep[b] = 1;
  clock_.assign(tracks_.size(), 0);
  pace_.assign(tracks_.size(), {});
  behind_.assign(model.nbody, 0);
  way_out_.assign(model.nbody, 0);
  for (const Inside& in : world.inside())
    for (int b = world.shapes[in.shape].body; b > 0 && !way_out_[b]; b = model.parent[b])
      way_out_[b] = 1;
  for (Drive& d : drives_)
    if (comes_out(d)) d.go_gently(kGentle, joint_reach_);
}

bool Stepper::comes_out(const Drive& d) const {
  for (const Inside& in : world.inside())
    if (tree(in.shape) == d.body(0)) return true;
  return false;
}

void Stepper::start_pose() {
  if (pose_known_) return;
  world.active.assign(model.nbody, 1);
  start_.kin.update(model, qpos_.data());
  world.start_poses(start_);
  pose_known_ = true;
}

const std::vector<double>& Stepper::qvel() {
  for (Drive& d : drives_) d.velocity(qvel_.data());
  return qvel_;
}

// How the parts of a person who follows the motion move. Joint rates are constant in the child's
// frame, so that angular velocities add up along the chain and turn with it: with W the sum of
// their bounds, B that of the turning, a point at r has speed <= V + W r and acceleration
// <= A + (W^2 + B) r, and stays within dt^2/8 times that of the line between its ends.
void Stepper::sweep_of(const Drive& d, double dt, const std::vector<char>& busy) {
  if (busy[d.body(0)]) return;
  Vec3 root;
  d.speeds(angular_, root);
  spin_bound_.resize(model.nbody);
  turn_bound_.resize(model.nbody);
  speed_bound_.resize(model.nbody);  // accelerations of the frames' origins
  for (size_t i = 0; i < angular_.size(); i++) {
    int b = d.body((int)i), p = model.parent[b];
    double w = angular_[i];
    if (i == 0) {
      spin_bound_[b] = w, turn_bound_[b] = 0, speed_bound_[b] = 0;
      continue;
    }
    double arm = norm(model.pos[b]);
    spin_bound_[b] = spin_bound_[p] + w;
    turn_bound_[b] = turn_bound_[p] + spin_bound_[p] * w;
    speed_bound_[b] =
        speed_bound_[p] + (spin_bound_[p] * spin_bound_[p] + turn_bound_[p]) * arm;
  }
  for (size_t i = 0; i < world.shapes.size(); i++) {
    const CollisionShape& m = world.shapes[i];
    if (model.root[m.body] != model.root[d.body(0)]) continue;
    double bulge = m.most_of([&](const CollisionShape::Tie& t) {
      const int b = t.body;
      return speed_bound_[b] +
             (spin_bound_[b] * spin_bound_[b] + turn_bound_[b]) * (norm(t.anchor) + t.reach);
    });
    if (!m.stretches.empty()) {
      // Blend shapes move the points in frames that turn.
      double speed = 0, rate = 0, spin = 0;
      for (const CollisionShape::Stretch& s : m.stretches) {
        const int b = m.skin->body[s.joint];
        const double w = spin_bound_[b] - spin_bound_[model.parent[b]];
        speed += std::sqrt(2.0) * s.most * w, rate += std::sqrt(2.0) * s.most * w * w;
      }
      for (const CollisionShape::Tie& t : m.ties) spin = std::max(spin, spin_bound_[t.body]);
      bulge += rate + 2 * spin * speed;
    }
    sweep_.bulge[i] = 0.125 * dt * dt * bulge;
    sweep_.way[i] = sweep_.straight[i] + sweep_.bulge[i];
  }
}

// People who are where the motion has them and meet nothing on their whole way to its next frame
// need no steps: they arrive there.
void Stepper::find_busy(double dt, std::vector<char>& busy) {
  busy.assign(model.nbody, 1);
  q_free_ = qpos_;
  bool any = false;
  for (const Drive& d : drives_) {
    if (carries(d) || !d.settled(drive_settings, qpos_.data())) continue;
    busy[d.body(0)] = 0;
    d.follow(1, q_free_.data());
    any = true;
  }
  if (!any) return;
  world.active.assign(model.nbody, 0);
  for (int b = 1; b < model.nbody; b++) world.active[b] = !busy[model.root[b]];
  end_.kin.update(model, q_free_.data(), world.active.data());
  world.start_poses(end_);
  const size_t n = world.shapes.size();
  sweep_.way.assign(n, 0);
  sweep_.bulge.assign(n, 0);
  assumed_.assign(n, 0);
  // Whoever is stepped through is assumed not to get much farther than it would by itself.
  bool stepped = false;
  for (size_t i = 0; i < n; i++) {
    int b = world.shapes[i].body;
    if (!busy[model.root[b]]) continue;
    if (!stepped) {
      start_.kin.update_dofs(model, qpos_.data());
      body_twists(model, start_.kin, qvel().data(), twists_);
      stepped = true;
    }
    double fall = norm(gravity) * dt * dt;
    sweep_.way[i] = 1.5 * dt * speed_bound(world.shapes[i], twists_) + fall + kStray;
    assumed_[i] = world.travelled((int)i) + sweep_.way[i];
  }
  ways(world.shapes, start_, end_, world.active, sweep_.straight);
  world.inner_ways(model, start_, end_, sweep_.inner);
  for (const Drive& d : drives_) sweep_of(d, dt, busy);
  world.active.assign(model.nbody, 1);
  world.list(model, start_, sweep_.way);
  world.find_busy(model, start_, end_, sweep_, busy);
}

void Stepper::frame(const double* targets, double dt, int n, std::vector<double>* poses) {
  if (forced != Forced::No) return force_frame(targets, dt, n, poses);
  touches_.clear();
  diagnostics_ = {};
  disturbed_.assign(model.nbody, 0);
  start_pose();
  settled_.clear();
  for (Drive& d : drives_) {
    d.aim(drive_settings, targets, dt, qpos_.data());
    settled_.push_back(d.settled(drive_settings, qpos_.data()));
    targets += d.qpos_count();
  }
  const size_t first_row = poses ? poses->size() : 0;
  q_start_ = qpos_;
  if (keep_pieces)
    busy_.assign(model.nbody, 1);
  else
    find_busy(dt, busy_);
  record_ = keep_pieces ? poses : nullptr;
  bool any_busy = false, any_free = false;
  for (int b = 1; b < model.nbody; b++)
    if (model.root[b] == b) (busy_[b] ? any_busy : any_free) = true;
  if (any_busy && any_free) {
    followed_ = start_;
    std::vector<double> before = save();
    std::vector<Drive> drives = drives_;
    substeps(dt, n, poses);
    bool strayed = false;
    for (size_t i = 0; i < world.shapes.size(); i++)
      strayed |= busy_[model.root[world.shapes[i].body]] &&
                 world.travelled((int)i) > assumed_[i];
    if (strayed) {  // they got farther after all: again, step by step for everybody
      restore(before);
      drives_ = drives;
      if (poses) poses->resize(first_row);
      diagnostics_ = {};
      touches_.clear();
      disturbed_.assign(model.nbody, 0);
      busy_.assign(model.nbody, 1);
      any_free = false;
      substeps(dt, n, poses);
    }
  } else if (any_busy) {
    substeps(dt, n, poses);
  } else if (poses) {
    for (int k = 0; k < n; k++) poses->insert(poses->end(), qpos_.begin(), qpos_.end());
  }
  for (Drive& d : drives_)
    if (d.gentle()) d.stay_gentle(comes_out(d), dt, qpos_.data());
  // Whom nothing touched has arrived, stepped through or not: the same bits either way.
  for (size_t i = 0; i < drives_.size(); i++) {
    Drive& d = drives_[i];
    if (!settled_[i] || disturbed_[d.body(0)]) continue;
    const int first = d.first_qpos(), count = d.qpos_count();
    auto arrive = [&](double share, double* q) {
      std::copy_n(&q_start_[first], count, q + first);
      d.follow(share, q);
    };
    if (poses && !keep_pieces)
      for (int k = 0; k < n; k++)
        arrive((k + 1.0) / n, &(*poses)[first_row + (size_t)k * model.nq]);
    arrive(1, qpos_.data());
    d.followed(carries(d));
    if (busy_[d.body(0)]) pose_known_ = false;  // the last step ended a rounding away
  }
  if (!any_free) return;
  if (any_busy) {
    // Who followed has travelled too.
    for (int b = 1; b < model.nbody; b++) world.active[b] = !busy_[model.root[b]];
    end_.kin.update(model, qpos_.data());
    world.start_poses(end_);
    ways(world.shapes, followed_, end_, world.active, way_);
    world.inner_ways(model, followed_, end_, sweep_.inner);
    world.travel(way_, sweep_.inner);
  } else {
    world.travel(sweep_.straight, sweep_.inner);
  }
  std::swap(start_, end_);
  world.active.assign(model.nbody, 1);
}

// A contact is a straight line where what turns goes in a circle: things that turn far in a substep
// make it in parts, or contacts would add energy.
int Stepper::parts_of(double h) const {
  double fastest = articulations.fastest(model, world.active, qvel_.data());
  for (int b : objects_)
    if (world.active[b]) fastest = std::max(fastest, norm(load3(&qvel_[model.dof_first[b] + 3])));
  if (fastest * h <= kTurn) return 1;
  return std::min(kMostParts, (int)std::ceil(4 * fastest * h / kTurn));
}

void Stepper::substeps(double dt, int n, std::vector<double>* poses) {
  for (int b = 1; b < model.nbody; b++) world.active[b] = busy_[model.root[b]];
  for (Drive& d : drives_)
    if (busy_[d.body(0)]) d.begin_frame(drive_settings, qpos_.data(), qvel_.data());
  for (int k = 0; k < n; k++) {
    const int parts = parts_of(dt / n);
    for (int i = 0; i < parts; i++) substep(k * parts + i, dt / n / parts);
    if (poses && !keep_pieces) poses->insert(poses->end(), qpos_.begin(), qpos_.end());
  }
}

double Stepper::clearance() {
  start_pose();
  double smallest = world.clearance(model, start_, clearance_range);
  // Who is inside a mesh may be far from all of its triangles.
  for (const Inside& in : world.inside())
    if (in.other_static >= 0 && world.shapes[in.shape].person >= 0)
      smallest = std::min(smallest, -in.depth());
  return smallest;
}

std::vector<double> Stepper::save() {
  qvel();
  std::vector<double> out(qpos_);
  out.insert(out.end(), qvel_.begin(), qvel_.end());
  for (const Drive& d : drives_) d.save(out);
  world.save(out);
  out.insert(out.end(), way_out_.begin(), way_out_.end());
  out.insert(out.end(), world.asleep.begin(), world.asleep.end());
  out.insert(out.end(), clock_.begin(), clock_.end());
  for (const Pace& p : pace_)
    out.insert(out.end(), {p.share, (double)p.wait, (double)p.patience});
  for (int b = 0; b < model.nbody && forced != Forced::No; b++)
    out.insert(out.end(), {world.pace[b], push_[b].wait, push_[b].patience});
  out.push_back((double)warm_.size());
  for (const CachedContact& w : warm_) {
    out.insert(out.end(), {(double)(w.key >> 32), (double)(w.key & 0xffffffff), (double)w.feature,
                           (double)w.point.vertex, (double)w.other.vertex});
    for (Vec3 v : {w.point.local, w.other.local, w.normal, w.impulse})
      out.insert(out.end(), {v.x, v.y, v.z});
  }
  out.push_back((double)out.size());  // so that what was cut off is seen
  return out;
}

void Stepper::load(const std::vector<double>& state) {
  if (state.size() < 2 || state.back() != (double)(state.size() - 1))
    throw std::invalid_argument("the state is not whole");
  restore(state);
  touches_.clear();
}

void Stepper::restore(const std::vector<double>& state) {
  pose_known_ = false;
  const double* in = state.data();
  std::copy(in, in + model.nq, qpos_.begin());
  in += model.nq;
  std::copy(in, in + model.nv, qvel_.begin());
  in += model.nv;
  for (Drive& d : drives_) in = d.load(in);
  in = world.load(in);
  way_out_.assign(in, in + model.nbody);
  in += model.nbody;
  world.asleep.assign(in, in + model.nbody);
  in += model.nbody;
  clock_.assign(in, in + clock_.size());
  in += clock_.size();
  for (Pace& p : pace_) {
    p = {in[0], (int)in[1], (int)in[2]};
    in += 3;
  }
  for (int b = 0; b < model.nbody && forced != Forced::No; b++, in += 3)
    world.pace[b] = in[0], push_[b] = {in[1], in[2]};
  for (Drive& d : drives_)
    if (d.gentle()) d.go_gently(kGentle, joint_reach_);
  warm_.clear();
  for (int n = (int)*in++; n > 0; n--, in += 17)
    warm_.push_back({((int64_t)in[0] << 32) | (int64_t)in[1], (int)in[2], {(int)in[3], load3(in + 5)},
                     {(int)in[4], load3(in + 8)}, load3(in + 11), load3(in + 14), false});
  start_pose();
}

}  // namespace hp
