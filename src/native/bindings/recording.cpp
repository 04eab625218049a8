#include "bindings/recording.h"

#include <algorithm>

namespace hp {

void Recording::add(Stepper& s) {
  if (s.torques(torques)) torque_frames.push_back((double)done);
  clearance.push_back(s.clearance());
  const Diagnostics& g = s.result().diagnostics;
  lost.push_back(g.lost_time);
  numbers.insert(numbers.end(),
                 {(double)g.candidates, (double)g.contacts, (double)g.passes, (double)g.sweeps,
                  (double)g.shortened, g.residual, g.friction, g.friction_tolerances});
  touch_count.push_back((double)s.result().touches.size());
  touch_rows(s.result().touches, touches);
  const size_t before = inside.size();
  inside_rows(s.system.world, inside);
  inside_count.push_back((double)(inside.size() - before) / 4);
  soft_count.push_back((double)s.result().soft.size());
  soft_rows(s.result().soft, soft);
  breach_count.push_back((double)s.result().breaches.size());
  breach_rows(s.result().breaches, breaches);
  s.footing(footing);
  done++;
}

nb::dict Recording::dict(const Stepper& s) const {
  const size_t nq = s.system.model.nq;
  nb::dict d;
  d["frames"] = done;
  d["clearance"] = array(clearance);
  d["lost_time"] = array(lost);
  // planes, contacts, passes, sweeps, shortened, residual, friction, friction in tolerances
  d["diagnostics"] = array({done, 8}, numbers);
  d["touch_count"] = array(touch_count);
  d["touches"] = array({touches.size() / 12, 12}, touches);
  d["inside_count"] = array(inside_count);
  d["inside"] = array({inside.size() / 4, 4}, inside);
  d["breach_count"] = array(breach_count);
  d["breaches"] = array({breaches.size() / 4, 4}, breaches);
  d["soft_count"] = array(soft_count);
  d["soft"] = array({soft.size() / kSoftColumns, kSoftColumns}, soft);
  d["footing"] = array({done, s.system.drives.size(), 2}, footing);
  d["torque_frames"] = array(torque_frames);
  d["torques"] = array({torque_frames.size(), (size_t)s.system.ball_count(), 3}, torques);
  d["substeps"] = array({poses.size() / std::max<size_t>(nq, 1), nq}, poses);
  return d;
}

Frames Frames::of(const Stepper& s, const Square& targets, double dt, int substeps, bool record,
                  const Square& stiffness, const Out& qpos) {
  need((int)targets.shape(1) == target_count(s) && targets.shape(0) > 0,
       "run: bad shape of targets");
  const bool given = stiffness.shape(0) > 0;
  need(!given || (stiffness.shape(0) == targets.shape(0) &&
                  (int)stiffness.shape(1) == s.system.ball_count()),
       "run: bad shape of stiffness");
  need(qpos.shape(0) == targets.shape(0) && (int)qpos.shape(1) == s.system.model.nq,
       "run: bad shape of qpos");
  return {targets.data(),
          given ? stiffness.data() : nullptr,
          qpos.data(),
          targets.shape(0),
          dt,
          substeps,
          record};
}

void Frames::run(Stepper& s, Recording& recording) const {
  const size_t at = recording.done;
  if (stiffness) set_stiffness(s, stiffness + at * s.system.ball_count());
  s.frame(targets + at * target_count(s), dt, substeps, record ? &recording.poses : nullptr);
  std::copy(s.qpos().begin(), s.qpos().end(), qpos + at * s.qpos().size());
  recording.add(s);
}

}  // namespace hp
