// Skinning of arrays (geometry/skinning.h). Releases the GIL.
#include "geometry/skinning.h"

#include <nanobind/stl/optional.h>

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "bindings/module.h"

namespace {

using out64 = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using Vertices = f64<nb::shape<-1, 3>>;
using Indices = i32<nb::shape<-1>>;
using Mask = nb::ndarray<const uint8_t, nb::c_contig, nb::device::cpu, nb::shape<-1, -1>>;

void require(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(std::string("skinning: ") + what);
}

void kinematics(f64<nb::shape<-1, -1, 3>> rotations, Vertices root, Vertices rest_joints,
                Indices parents, out64 positions, out64 quaternions) {
  const size_t frames = rotations.shape(0), joints = rotations.shape(1);
  require(root.shape(0) == frames, "root has another number of frames than rotations");
  require(rest_joints.shape(0) == joints && parents.shape(0) == joints,
          "rest_joints and parents must have one row per joint");
  require(positions.size() == frames * joints * 3 && quaternions.size() == frames * joints * 4,
          "wrong size of an output");
  const int* parent = parents.data();
  for (size_t j = 0; j < joints; ++j)
    require(parent[j] < int(j) && (parent[j] >= 0) == (j > 0), "parents must precede children");
  const double *turn = rotations.data(), *base = root.data(), *rest = rest_joints.data();
  double *x = positions.data(), *q = quaternions.data();
  nb::gil_scoped_release release;
  hp::joint_frames(turn, base, rest, parent, frames, joints, x, q);
}

// Indices come from Python: one wrong value would read foreign memory.
void check(const hp::SkinnedMesh& s, size_t vertices, size_t n_weights) {
  require(s.first[0] == 0 && size_t(s.first[vertices]) == n_weights,
          "the sparse weights do not fit the vertices");
  for (size_t v = 0; v < vertices; ++v)
    require(s.first[v] <= s.first[v + 1], "the sparse weights are not sorted by vertex");
  for (size_t e = 0; e < n_weights; ++e)
    require(s.joint[e] >= 0 && size_t(s.joint[e]) < s.n_joints, "a weight names no joint");
  for (size_t i = 0; s.subset && i < s.n_out; ++i)
    require(s.subset[i] >= 0 && size_t(s.subset[i]) < vertices, "a vertex index is out of range");
}

void set_groups(hp::SkinnedMesh& s, size_t frames, const std::optional<Indices>& group_first,
                const std::optional<Mask>& wanted) {
  require(group_first.has_value() == wanted.has_value(), "group_first and wanted go together");
  if (!wanted) return;
  s.n_groups = wanted->shape(1);
  s.group_first = group_first->data();
  s.wanted = wanted->data();
  require(wanted->shape(0) == frames && group_first->shape(0) == s.n_groups + 1 &&
              s.group_first[0] == 0 && size_t(s.group_first[s.n_groups]) == s.n_out,
          "group_first and wanted do not fit the vertices and frames");
  for (size_t g = 0; g < s.n_groups; ++g)
    require(s.group_first[g] <= s.group_first[g + 1], "group_first is out of order");
}

void pose_skin(Vertices rest_vertices, Vertices rest_joints, Indices first, Indices joint,
               f64<nb::shape<-1>> weights, f64<nb::shape<-1, 3, -1>> posedirs,
               f64<nb::shape<-1, -1, 3>> rotations, f64<nb::shape<-1, -1, 3>> positions,
               f64<nb::shape<-1, -1, 4>> quaternions, Indices subset, bool all, int threads,
               out64 out, std::optional<Indices> group_first, std::optional<Mask> wanted) {
  hp::SkinnedMesh s{};
  const size_t vertices = rest_vertices.shape(0), frames = rotations.shape(0);
  s.n_joints = rest_joints.shape(0);
  s.n_features = posedirs.shape(2);
  s.rest = rest_vertices.data();
  s.joints = rest_joints.data();
  s.first = first.data();
  s.joint = joint.data();
  s.weights = weights.data();
  s.posedirs = posedirs.shape(0) ? posedirs.data() : nullptr;
  s.subset = all ? nullptr : subset.data();
  s.n_out = all ? vertices : subset.shape(0);
  require(threads >= 1, "threads must be at least 1");
  require(first.shape(0) == vertices + 1 && joint.shape(0) == weights.shape(0),
          "the sparse weights do not fit the vertices");
  check(s, vertices, weights.shape(0));
  require(!s.posedirs || (posedirs.shape(0) == vertices &&
                          s.n_features == (s.n_joints - 1) * hp::SkinnedMesh::joint_features),
          "posedirs must be (vertices, 3, 9 x (joints - 1))");
  require(rotations.shape(1) == s.n_joints && positions.shape(0) == frames &&
              positions.shape(1) == s.n_joints && quaternions.shape(0) == frames &&
              quaternions.shape(1) == s.n_joints,
          "rotations, positions and quaternions must be (frames, joints, .)");
  require(out.size() == frames * s.n_out * 3, "wrong size of the output");
  set_groups(s, frames, group_first, wanted);
  const hp::JointPoses poses{frames, rotations.data(), positions.data(), quaternions.data()};
  double* y = out.data();
  nb::gil_scoped_release release;
  hp::skin(s, poses, threads, y);
}

}  // namespace

void bind_skinning(nb::module_& m) {
  m.def("kinematics", &kinematics, nb::arg("rotations"), nb::arg("root"), nb::arg("rest_joints"),
        nb::arg("parents"), nb::arg("positions"), nb::arg("quaternions"),
        "World positions (T, J, 3) and quaternions (T, J, 4) of the joints, into the last two.");
  m.def("skin", &pose_skin, nb::arg("rest_vertices"), nb::arg("rest_joints"), nb::arg("first"),
        nb::arg("joint"), nb::arg("weights"), nb::arg("posedirs"), nb::arg("rotations"),
        nb::arg("positions"), nb::arg("quaternions"), nb::arg("subset"), nb::arg("all"),
        nb::arg("threads"), nb::arg("out"), nb::arg("group_first") = nb::none(),
        nb::arg("wanted") = nb::none(),
        "Skinned vertices (T, n, 3) into `out`; `posedirs` of zero rows: no pose blend shapes. Of "
        "vertices in groups only those in frames where their group is `wanted` (T, groups).");
}
