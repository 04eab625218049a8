#include "stepping/host.h"

#include <algorithm>

namespace hp {

void Host::show(const Kinematics& kin) const {
  for (const Mirror& m : mirrors) {
    store3(mocap_pos + 3 * m.mocap, kin.xpos[m.body]);
    const Quat& q = kin.xquat[m.body];
    double* at = mocap_quat + 4 * m.mocap;
    at[0] = q.w, at[1] = q.x, at[2] = q.y, at[3] = q.z;
  }
}

void AppliedForces::add(const Host& host, int body, Vec3 centre, Vec3 at, Vec3 force) {
  double* row = host.applied + 6 * body;
  auto known =
      std::find_if(rows_.begin(), rows_.end(), [&](const Row& r) { return r.body == body; });
  if (known == rows_.end()) {
    known = rows_.insert(rows_.end(), Row{body, {}, {}});
    std::copy_n(row, 6, known->before);
  }
  store3(row, load3(row) + force);
  store3(row + 3, load3(row + 3) + cross(at - centre, force));
  std::copy_n(row, 6, known->after);
}

void AppliedForces::remove(const Host& host) {
  for (const Row& r : rows_) {
    double* row = host.applied + 6 * r.body;
    for (int i = 0; i < 6; i++)
      if (row[i] == r.after[i]) row[i] = r.before[i];
  }
  rows_.clear();
}

std::vector<double> AppliedForces::save() const {
  std::vector<double> out;
  for (const Row& r : rows_) {
    out.push_back(r.body);
    out.insert(out.end(), r.before, r.before + 6);
    out.insert(out.end(), r.after, r.after + 6);
  }
  return out;
}

void AppliedForces::load(const std::vector<double>& rows) {
  rows_.clear();
  for (size_t i = 0; i + 13 <= rows.size(); i += 13) {
    Row r{(int)rows[i], {}, {}};
    std::copy_n(&rows[i + 1], 6, r.before);
    std::copy_n(&rows[i + 7], 6, r.after);
    rows_.push_back(r);
  }
}

}  // namespace hp
