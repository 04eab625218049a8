#include "compiled/label_calls.h"

#include <algorithm>
#include <stdexcept>

namespace hp {

namespace {

Vec3 three(const Doubles& v) {
  need(v.shape(0) == 3, "world file: a vector of another length than 3");
  return load3(v.data());
}

Mat3 matrix(const Square& v) {
  need(v.shape(0) == 3 && v.shape(1) == 3, "world file: a matrix of another shape than (3, 3)");
  Mat3 out;
  std::copy_n(v.data(), 9, out.m);
  return out;
}

template <typename T, typename View>
std::array<T, kJoints> joints(const View& v) {
  need(v.shape(0) == kJoints, "world file: a person of another number of joints than 55");
  std::array<T, kJoints> out;
  std::copy_n(v.data(), kJoints, out.begin());
  return out;
}

}  // namespace

// NOLINTNEXTLINE(performance-unnecessary-value-param): arguments of calls are values
void label_everything(Labels& labels, std::string names, std::vector<int> shape_name,
                      std::vector<int> shape_part, std::vector<int> static_name) {
  labels.everything.clear();
  for (size_t at = 0; at < names.size();) {
    const size_t end = names.find('\0', at);
    need(end != std::string::npos, "world file: a name has no end");
    labels.everything.push_back(names.substr(at, end - at));
    at = end + 1;
  }
  labels.shape_name = std::move(shape_name), labels.shape_part = std::move(shape_part);
  labels.static_name = std::move(static_name);
}

void label_person(Labels& labels, std::string name, int root, int qpos, Ints joint_qpos, Ints body,
                  Ints ball, Doubles rest_pelvis, Square axes, Doubles pelvis, Doubles stiffness) {
  PersonPlace p;
  p.name = std::move(name), p.root = root, p.qpos = qpos;
  p.joint_qpos = joints<int>(joint_qpos), p.body = joints<int>(body), p.ball = joints<int>(ball);
  p.rest_pelvis = three(rest_pelvis), p.axes = matrix(axes), p.pelvis = three(pelvis);
  p.stiffness = joints<double>(stiffness);
  labels.people.push_back(std::move(p));
}

void label_object(Labels& labels, std::string name, int body, int qpos, int dof, Doubles com,
                  Square inertia, bool pushable) {
  ObjectPlace o;
  o.name = std::move(name), o.body = body, o.qpos = qpos, o.dof = dof;
  o.com = three(com), o.inertia = matrix(inertia), o.pushable = pushable;
  labels.objects.push_back(std::move(o));
}

void label_link(Labels& labels, std::string name, int body) {
  labels.links.push_back({std::move(name), body});
}

void label_joint(Labels& labels, std::string name, int qpos, int width) {
  labels.joints.push_back({std::move(name), qpos, width});
}

void label_start(Labels& labels, Doubles qpos, Doubles qvel, int substeps) {
  labels.start_qpos = list<double>(qpos), labels.start_qvel = list<double>(qvel);
  labels.substeps = substeps;
}

void label_friction(Labels& labels, Doubles own, std::vector<int> pair) {
  labels.own_friction = list<double>(own), labels.own_pair = std::move(pair);
}

}  // namespace hp
