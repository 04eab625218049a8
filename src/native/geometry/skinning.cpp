// Forward kinematics and linear blend skinning with pose blend shapes, float64.
//
// The readable reference is src/halfphysics/skinning.py; tests hold the two equal. Every output
// value is computed by one thread, in an order that depends on nothing but its own frame and
// vertex: the bytes are the same for any number of threads, any batch and any subset.
#include "bindings/module.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nanobind/stl/optional.h>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace {

using out64 = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

constexpr int kLanes = 8;         // frames whose blend shapes are summed side by side
constexpr int kChunk = 256;       // vertices per task
constexpr int kJointFeatures = 9; // entries of one rotation matrix

void require(bool ok, const char* what) {
  if (!ok) throw std::invalid_argument(std::string("skinning: ") + what);
}

// Unit quaternion (wxyz) of an axis-angle vector [rad].
void exponential(const double* r, double* q) {
  const double angle = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  const double half = 0.5 * angle;
  const double scale = half < 1e-8 ? 0.5 : std::sin(half) / angle;
  q[0] = std::cos(half);
  for (int i = 0; i < 3; ++i) q[i + 1] = scale * r[i];
}

void product(const double* a, const double* b, double* q) {
  q[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  q[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  q[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  q[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

// Rotation matrix, row by row; `stride` between rows.
void matrix(const double* q, double* m, int stride) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  m[0] = 1 - 2 * (y * y + z * z);
  m[1] = 2 * (x * y - w * z);
  m[2] = 2 * (x * z + w * y);
  m += stride;
  m[0] = 2 * (x * y + w * z);
  m[1] = 1 - 2 * (x * x + z * z);
  m[2] = 2 * (y * z - w * x);
  m += stride;
  m[0] = 2 * (x * z - w * y);
  m[1] = 2 * (y * z + w * x);
  m[2] = 1 - 2 * (x * x + y * y);
}

void kinematics(f64<nb::shape<-1, -1, 3>> rotations, f64<nb::shape<-1, 3>> root,
                f64<nb::shape<-1, 3>> rest_joints, i32<nb::shape<-1>> parents, out64 positions,
                out64 quaternions) {
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
  for (size_t f = 0; f < frames; ++f, x += 3 * joints, q += 4 * joints, turn += 3 * joints) {
    exponential(turn, q);
    for (int i = 0; i < 3; ++i) x[i] = base[3 * f + i];
    for (size_t j = 1; j < joints; ++j) {
      const size_t p = size_t(parent[j]);
      double local[4], m[9], arm[3];
      exponential(turn + 3 * j, local);
      product(q + 4 * p, local, q + 4 * j);
      matrix(q + 4 * p, m, 3);
      for (int i = 0; i < 3; ++i) arm[i] = rest[3 * j + i] - rest[3 * p + i];
      for (int i = 0; i < 3; ++i)
        x[3 * j + i] =
            x[3 * p + i] + (m[3 * i] * arm[0] + m[3 * i + 1] * arm[1] + m[3 * i + 2] * arm[2]);
    }
  }
}

struct Skin {
  const double *rest, *joints, *weights, *posedirs;
  const int *first, *joint, *subset;
  size_t n_joints, n_out, n_features;
  // Groups of the vertices that come out: where each starts, and in which frames it is wanted.
  const int* group_first;
  const unsigned char* wanted;
  size_t n_groups;
};

constexpr size_t kAffine = 16;  // numbers of a transform: four columns of three, and one to spare

// What a block of up to kLanes frames shares: rigid transforms, and the blend-shape coefficients
// of the joints that are turned in any of its frames (the others would add exact zeros).
struct Block {
  size_t start = 0, frames = 0;
  std::vector<double> affine;     // frames x joints x columns of R | x - x_root - R j
  std::vector<double> features;   // turned joints x 9 x lanes
  std::vector<int> turned;        // column of each turned joint in posedirs
  int lanes = 1;
};

Block make_block(const Skin& s, size_t start, size_t frames, const double* rotations,
                 const double* positions, const double* quaternions) {
  Block b;
  b.start = start;
  b.frames = frames;
  b.lanes = frames > 4 ? 8 : frames > 2 ? 4 : frames > 1 ? 2 : 1;
  b.affine.resize(frames * s.n_joints * kAffine);
  for (size_t f = 0; f < frames; ++f) {
    const double* x = positions + (start + f) * s.n_joints * 3;
    const double* q = quaternions + (start + f) * s.n_joints * 4;
    for (size_t j = 0; j < s.n_joints; ++j) {
      double* a = &b.affine[(f * s.n_joints + j) * kAffine];
      const double* rest = s.joints + 3 * j;
      double m[9];
      matrix(q + 4 * j, m, 3);
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) a[4 * k + i] = m[3 * i + k];
        a[12 + i] = (x[3 * j + i] - x[i]) -
                    (m[3 * i] * rest[0] + m[3 * i + 1] * rest[1] + m[3 * i + 2] * rest[2]);
      }
    }
  }
  if (!s.posedirs) return b;
  for (size_t j = 1; j < s.n_joints; ++j) {
    bool moves = false;
    for (size_t f = 0; f < frames && !moves; ++f) {
      const double* r = rotations + ((start + f) * s.n_joints + j) * 3;
      moves = r[0] != 0.0 || r[1] != 0.0 || r[2] != 0.0;
    }
    if (!moves) continue;
    b.turned.push_back(int(j - 1) * kJointFeatures);
    const size_t at = b.features.size();
    b.features.resize(at + size_t(kJointFeatures * b.lanes), 0.0);
    for (size_t f = 0; f < frames; ++f) {
      double q[4], m[9];
      exponential(rotations + ((start + f) * s.n_joints + j) * 3, q);
      matrix(q, m, 3);
      for (int k = 0; k < kJointFeatures; ++k)
        b.features[at + size_t(k * b.lanes) + f] = m[k] - (k % 4 == 0 ? 1.0 : 0.0);
    }
  }
  return b;
}

// Doubles side by side. Said outright where the compiler can: left to itself it shuffles.
#if defined(__GNUC__)
typedef double Lanes4 __attribute__((vector_size(32), aligned(8)));
#define HP_INLINE inline __attribute__((always_inline))
#else
struct Lanes4 {
  double v[4];
  void operator+=(const Lanes4& b) {
    for (int i = 0; i < 4; ++i) v[i] += b.v[i];
  }
  friend Lanes4 operator*(double a, const Lanes4& b) {
    return {{a * b.v[0], a * b.v[1], a * b.v[2], a * b.v[3]}};
  }
  friend Lanes4 operator+(Lanes4 a, const Lanes4& b) {
    a += b;
    return a;
  }
};
#define HP_INLINE inline
#endif

// Blend-shape offsets of one vertex for Count x (lanes of V) frames: offset[c * lanes + lane].
// Summed joint by joint, so that a single lane too has independent sums for the processor to
// overlap. The order of the sums is the same for every V and Count, and so are the bits.
template <typename V, int Count>
HP_INLINE void blend(const Skin& s, const Block& b, size_t vertex, double* offset) {
  constexpr int lanes = Count * int(sizeof(V) / sizeof(double));
  V sum[3][Count] = {};
  const double* rows = s.posedirs + vertex * 3 * s.n_features;
  const double* feature = b.features.data();
  for (const int column : b.turned) {
    for (int c = 0; c < 3; ++c) {
      const double* row = rows + size_t(c) * s.n_features + size_t(column);
      V part[Count] = {};
      for (int k = 0; k < kJointFeatures; ++k) {
        for (int l = 0; l < Count; ++l) {
          V f;
          std::memcpy(&f, feature + k * lanes + l * int(sizeof(V) / sizeof(double)), sizeof(V));
          part[l] += row[k] * f;
        }
      }
      for (int l = 0; l < Count; ++l) sum[c][l] += part[l];
    }
    feature += kJointFeatures * lanes;
  }
  std::memcpy(offset, sum, sizeof(sum));
}

#if defined(__x86_64__) && defined(__GNUC__)
// The same operations, four lanes in one instruction.
__attribute__((target("avx2"))) void blend8_avx2(const Skin& s, const Block& b, size_t vertex,
                                                 double* offset) {
  blend<Lanes4, 2>(s, b, vertex, offset);
}
#endif

// One vertex in one frame: transforms blended column by column, three rows side by side.
HP_INLINE void carry(const Skin& s, const double* affine, size_t v, const double* root,
                     const double* x, double* y) {
  Lanes4 m[4] = {};
  for (int e = s.first[v]; e < s.first[v + 1]; ++e) {
    const double w = s.weights[e];
    const double* a = affine + size_t(s.joint[e]) * kAffine;
    for (int k = 0; k < 4; ++k) {
      Lanes4 column;
      std::memcpy(&column, a + 4 * k, sizeof(column));
      m[k] += w * column;
    }
  }
  const Lanes4 turned = x[0] * m[0] + x[1] * m[1] + x[2] * m[2];
  const Lanes4 moved = m[3] + turned;
  double out[4];
  std::memcpy(out, &moved, sizeof(out));
  for (int c = 0; c < 3; ++c) y[c] = root[c] + out[c];
}

template <typename Blend8>
HP_INLINE void range(const Skin& s, const Block& b, size_t from, size_t to,
                     const double* positions, double* out, const Blend8& blend8) {
  double offset[3 * kLanes] = {};
  size_t group = 0;
  for (size_t i = from; i < to; ++i) {
    bool wanted[kLanes];
    bool any = true;
    if (s.wanted) {
      while (i >= size_t(s.group_first[group + 1])) ++group;
      any = false;
      for (size_t f = 0; f < b.frames; ++f)
        any |= wanted[f] = s.wanted[(b.start + f) * s.n_groups + group] != 0;
      if (!any) {
        i = size_t(s.group_first[group + 1]) - 1;
        continue;
      }
    }
    const size_t v = s.subset ? size_t(s.subset[i]) : i;
    if (s.posedirs) {
      switch (b.lanes) {
        case 1: blend<double, 1>(s, b, v, offset); break;
        case 2: blend<double, 2>(s, b, v, offset); break;
        case 4: blend<Lanes4, 1>(s, b, v, offset); break;
        default: blend8(s, b, v, offset);
      }
    }
    const double* rest = s.rest + 3 * v;
    for (size_t f = 0; f < b.frames; ++f) {
      if (s.wanted && !wanted[f]) continue;
      double x[3];
      for (int c = 0; c < 3; ++c) x[c] = rest[c] + offset[size_t(c * b.lanes) + f];
      carry(s, &b.affine[f * s.n_joints * kAffine], v,
            positions + (b.start + f) * s.n_joints * 3, x,
            out + ((b.start + f) * s.n_out + i) * 3);
    }
  }
}

#if defined(__x86_64__) && defined(__GNUC__)
// The same operations, four lanes in one instruction.
__attribute__((target("avx2"))) void range_avx2(const Skin& s, const Block& b, size_t from,
                                                size_t to, const double* positions, double* out) {
  range(s, b, from, to, positions, out, blend8_avx2);
}
#endif

void skin_range(const Skin& s, const Block& b, size_t from, size_t to, const double* positions,
                double* out) {
#if defined(__x86_64__) && defined(__GNUC__)
  static const bool wide = __builtin_cpu_supports("avx2");
  if (wide) return range_avx2(s, b, from, to, positions, out);
#endif
  range(s, b, from, to, positions, out, blend<Lanes4, 2>);
}

void skin(f64<nb::shape<-1, 3>> rest_vertices, f64<nb::shape<-1, 3>> rest_joints,
          i32<nb::shape<-1>> first, i32<nb::shape<-1>> joint, f64<nb::shape<-1>> weights,
          f64<nb::shape<-1, 3, -1>> posedirs, f64<nb::shape<-1, -1, 3>> rotations,
          f64<nb::shape<-1, -1, 3>> positions, f64<nb::shape<-1, -1, 4>> quaternions,
          i32<nb::shape<-1>> subset, bool all, int threads, out64 out,
          std::optional<i32<nb::shape<-1>>> group_first,
          std::optional<nb::ndarray<const uint8_t, nb::c_contig, nb::device::cpu,
                                    nb::shape<-1, -1>>> wanted) {
  Skin s{};
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
  // Indices come from Python: one wrong value would read foreign memory.
  require(threads >= 1, "threads must be at least 1");
  require(first.shape(0) == vertices + 1 && joint.shape(0) == weights.shape(0) &&
              s.first[0] == 0 && size_t(s.first[vertices]) == weights.shape(0),
          "the sparse weights do not fit the vertices");
  for (size_t v = 0; v < vertices; ++v)
    require(s.first[v] <= s.first[v + 1], "the sparse weights are not sorted by vertex");
  for (size_t e = 0; e < weights.shape(0); ++e)
    require(s.joint[e] >= 0 && size_t(s.joint[e]) < s.n_joints, "a weight names no joint");
  require(!s.posedirs || (posedirs.shape(0) == vertices &&
                          s.n_features == (s.n_joints - 1) * kJointFeatures),
          "posedirs must be (vertices, 3, 9 x (joints - 1))");
  require(rotations.shape(1) == s.n_joints && positions.shape(0) == frames &&
              positions.shape(1) == s.n_joints && quaternions.shape(0) == frames &&
              quaternions.shape(1) == s.n_joints,
          "rotations, positions and quaternions must be (frames, joints, .)");
  for (size_t i = 0; s.subset && i < s.n_out; ++i)
    require(s.subset[i] >= 0 && size_t(s.subset[i]) < vertices, "a vertex index is out of range");
  require(out.size() == frames * s.n_out * 3, "wrong size of the output");
  require(group_first.has_value() == wanted.has_value(), "group_first and wanted go together");
  if (wanted) {
    s.n_groups = wanted->shape(1);
    s.group_first = group_first->data();
    s.wanted = wanted->data();
    require(wanted->shape(0) == frames && group_first->shape(0) == s.n_groups + 1 &&
                s.group_first[0] == 0 && size_t(s.group_first[s.n_groups]) == s.n_out,
            "group_first and wanted do not fit the vertices and frames");
    for (size_t g = 0; g < s.n_groups; ++g)
      require(s.group_first[g] <= s.group_first[g + 1], "group_first is out of order");
  }
  if (!frames || !s.n_out) return;
  const double *turn = rotations.data(), *x = positions.data(), *q = quaternions.data();
  double* y = out.data();

  nb::gil_scoped_release release;
  const size_t blocks = (frames + kLanes - 1) / kLanes;
  const size_t chunks = (s.n_out + kChunk - 1) / kChunk;
  const size_t workers = std::min(size_t(threads), blocks * chunks);
  // Few blocks at a time, so that memory does not grow with the length of the motion.
  const size_t wave = std::max<size_t>(workers, 1);
  for (size_t begin = 0; begin < blocks; begin += wave) {
    const size_t end = std::min(blocks, begin + wave);
    std::vector<Block> ready;
    ready.reserve(end - begin);
    for (size_t k = begin; k < end; ++k) {
      const size_t start = k * kLanes;
      ready.push_back(make_block(s, start, std::min<size_t>(kLanes, frames - start), turn, x, q));
    }
    std::atomic<size_t> next{0};
    auto work = [&] {
      for (size_t t; (t = next.fetch_add(1)) < ready.size() * chunks;) {
        const size_t from = (t % chunks) * kChunk;
        skin_range(s, ready[t / chunks], from, std::min(s.n_out, from + kChunk), x, y);
      }
    };
    std::vector<std::thread> pool;
    try {
      for (size_t w = 1; w < workers; ++w) pool.emplace_back(work);
    } catch (const std::system_error&) {
      // No more threads to be had: the ones there, and this one, do all the work.
    }
    work();
    for (std::thread& thread : pool) thread.join();
  }
}

}  // namespace

void bind_skinning(nb::module_& m) {
  m.def("kinematics", &kinematics, nb::arg("rotations"), nb::arg("root"), nb::arg("rest_joints"),
        nb::arg("parents"), nb::arg("positions"), nb::arg("quaternions"),
        "World positions (T, J, 3) and quaternions (T, J, 4) of the joints, into the last two.");
  m.def("skin", &skin, nb::arg("rest_vertices"), nb::arg("rest_joints"), nb::arg("first"),
        nb::arg("joint"), nb::arg("weights"), nb::arg("posedirs"), nb::arg("rotations"),
        nb::arg("positions"), nb::arg("quaternions"), nb::arg("subset"), nb::arg("all"),
        nb::arg("threads"), nb::arg("out"), nb::arg("group_first") = nb::none(),
        nb::arg("wanted") = nb::none(),
        "Skinned vertices (T, n, 3) into `out`; `posedirs` of zero rows: no pose blend shapes. Of "
        "vertices in groups only those in frames where their group is `wanted` (T, groups).");
}
