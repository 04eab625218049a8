#include "geometry/skinning.h"

#include "math/simd.h"
#include "tuning.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <system_error>
#include <thread>
#include <vector>

namespace hp {

namespace tune = tuning::geometry;

namespace {

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

// What a block of up to tune::kSkinFrames frames shares: rigid transforms, and the blend-shape
// coefficients of the joints that are turned in any of its frames (the others would add exact
// zeros).
struct Block {
  // Numbers of a transform: four columns of three, each with one to spare.
  static constexpr size_t affine_size = 16;
  size_t start = 0, frames = 0;
  std::vector<double> affine;    // frames x joints x columns of R | x - x_root - R j
  std::vector<double> features;  // turned joints x 9 x lanes
  std::vector<int> turned;       // column of each turned joint in posedirs
  int lanes = 1;
};

// Column by column R | x - x_root - R j of every joint in the frames of a block.
void fill_transforms(const SkinnedMesh& s, const JointPoses& poses, Block& b) {
  for (size_t f = 0; f < b.frames; ++f) {
    const double* x = poses.positions + (b.start + f) * s.n_joints * 3;
    const double* q = poses.quaternions + (b.start + f) * s.n_joints * 4;
    for (size_t j = 0; j < s.n_joints; ++j) {
      double* a = &b.affine[(f * s.n_joints + j) * Block::affine_size];
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
}

Block make_block(const SkinnedMesh& s, size_t start, size_t frames, const JointPoses& poses) {
  Block b;
  b.start = start;
  b.frames = frames;
  b.lanes = frames > 4 ? 8 : frames > 2 ? 4 : frames > 1 ? 2 : 1;
  b.affine.resize(frames * s.n_joints * Block::affine_size);
  fill_transforms(s, poses, b);
  if (!s.posedirs) return b;
  for (size_t j = 1; j < s.n_joints; ++j) {
    bool moves = false;
    for (size_t f = 0; f < frames && !moves; ++f) {
      const double* r = poses.rotations + ((start + f) * s.n_joints + j) * 3;
      moves = r[0] != 0.0 || r[1] != 0.0 || r[2] != 0.0;
    }
    if (!moves) continue;
    b.turned.push_back(int(j - 1) * SkinnedMesh::joint_features);
    const size_t at = b.features.size();
    b.features.resize(at + size_t(SkinnedMesh::joint_features * b.lanes), 0.0);
    for (size_t f = 0; f < frames; ++f) {
      double q[4], m[9];
      exponential(poses.rotations + ((start + f) * s.n_joints + j) * 3, q);
      matrix(q, m, 3);
      for (int k = 0; k < SkinnedMesh::joint_features; ++k)
        b.features[at + size_t(k * b.lanes) + f] = m[k] - (k % 4 == 0 ? 1.0 : 0.0);
    }
  }
  return b;
}

// Doubles side by side. Said outright where the compiler can: left to itself it shuffles.
#if HP_VECTORS > 0 && defined(__GNUC__)
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
HP_INLINE void blend(const SkinnedMesh& s, const Block& b, size_t vertex, double* offset) {
  constexpr int width = int(sizeof(V) / sizeof(double));  // NOLINT(bugprone-sizeof-expression)
  constexpr int lanes = Count * width;
  V sum[3][Count] = {};
  const double* rows = s.posedirs + vertex * 3 * s.n_features;
  const double* feature = b.features.data();
  for (const int column : b.turned) {
    for (int c = 0; c < 3; ++c) {
      const double* row = rows + size_t(c) * s.n_features + size_t(column);
      V part[Count] = {};
      for (int k = 0; k < SkinnedMesh::joint_features; ++k) {
        for (int l = 0; l < Count; ++l) {
          V f;
          std::memcpy(&f, feature + k * lanes + l * width, sizeof(V));
          part[l] += row[k] * f;
        }
      }
      for (int l = 0; l < Count; ++l) sum[c][l] += part[l];
    }
    feature += SkinnedMesh::joint_features * lanes;
  }
  std::memcpy(offset, sum, sizeof(sum));
}

#if HP_VECTORS > 1 && defined(__x86_64__) && defined(__GNUC__)
// The same operations, four lanes in one instruction.
__attribute__((target("avx2"))) void blend8_avx2(const SkinnedMesh& s, const Block& b,
                                                 size_t vertex, double* offset) {
  blend<Lanes4, 2>(s, b, vertex, offset);
}
#endif

// One vertex in one frame: transforms blended column by column, three rows side by side.
HP_INLINE void carry(const SkinnedMesh& s, const double* affine, size_t v, const double* root,
                     const double* x, double* y) {
  Lanes4 m[4] = {};
  for (int e = s.first[v]; e < s.first[v + 1]; ++e) {
    const double w = s.weights[e];
    const double* a = affine + size_t(s.joint[e]) * Block::affine_size;
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
HP_INLINE void range(const SkinnedMesh& s, const Block& b, size_t from, size_t to,
                     const double* positions, double* out, const Blend8& blend8) {
  double offset[3 * tune::kSkinFrames] = {};
  size_t group = 0;
  for (size_t i = from; i < to; ++i) {
    bool wanted[tune::kSkinFrames];
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
        case 1:
          blend<double, 1>(s, b, v, offset);
          break;
        case 2:
          blend<double, 2>(s, b, v, offset);
          break;
        case 4:
          blend<Lanes4, 1>(s, b, v, offset);
          break;
        default:
          blend8(s, b, v, offset);
      }
    }
    const double* rest = s.rest + 3 * v;
    for (size_t f = 0; f < b.frames; ++f) {
      if (s.wanted && !wanted[f]) continue;
      double x[3];
      for (int c = 0; c < 3; ++c) x[c] = rest[c] + offset[size_t(c * b.lanes) + f];
      carry(s, &b.affine[f * s.n_joints * Block::affine_size], v,
            positions + (b.start + f) * s.n_joints * 3, x, out + ((b.start + f) * s.n_out + i) * 3);
    }
  }
}

#if HP_VECTORS > 1 && defined(__x86_64__) && defined(__GNUC__)
// The same operations, four lanes in one instruction.
__attribute__((target("avx2"))) void range_avx2(const SkinnedMesh& s, const Block& b, size_t from,
                                                size_t to, const double* positions, double* out) {
  range(s, b, from, to, positions, out, blend8_avx2);
}
#endif

void skin_range(const SkinnedMesh& s, const Block& b, size_t from, size_t to,
                const double* positions, double* out) {
#if HP_VECTORS > 1 && defined(__x86_64__) && defined(__GNUC__)
  static const bool wide = __builtin_cpu_supports("avx2");
  if (wide) return range_avx2(s, b, from, to, positions, out);
#endif
  range(s, b, from, to, positions, out, blend<Lanes4, 2>);
}

}  // namespace

void joint_frames(const double* rotations, const double* root, const double* rest_joints,
                  const int* parents, size_t frames, size_t joints, double* positions,
                  double* quaternions) {
  double *x = positions, *q = quaternions;
  const double* turn = rotations;
  for (size_t f = 0; f < frames; ++f, x += 3 * joints, q += 4 * joints, turn += 3 * joints) {
    exponential(turn, q);
    for (int i = 0; i < 3; ++i) x[i] = root[3 * f + i];
    for (size_t j = 1; j < joints; ++j) {
      const size_t p = size_t(parents[j]);
      double local[4], m[9], arm[3];
      exponential(turn + 3 * j, local);
      product(q + 4 * p, local, q + 4 * j);
      matrix(q + 4 * p, m, 3);
      for (int i = 0; i < 3; ++i) arm[i] = rest_joints[3 * j + i] - rest_joints[3 * p + i];
      for (int i = 0; i < 3; ++i)
        x[3 * j + i] =
            x[3 * p + i] + (m[3 * i] * arm[0] + m[3 * i + 1] * arm[1] + m[3 * i + 2] * arm[2]);
    }
  }
}

void skin(const SkinnedMesh& s, const JointPoses& poses, int threads, double* out) {
  const size_t frames = poses.frames;
  if (!frames || !s.n_out) return;
  const size_t blocks = (frames + tune::kSkinFrames - 1) / tune::kSkinFrames;
  const size_t chunks = (s.n_out + tune::kSkinChunk - 1) / tune::kSkinChunk;
  const size_t workers = std::min(size_t(threads), blocks * chunks);
  // Few blocks at a time, so that memory does not grow with the length of the motion.
  const size_t wave = std::max<size_t>(workers, 1);
  for (size_t begin = 0; begin < blocks; begin += wave) {
    const size_t end = std::min(blocks, begin + wave);
    std::vector<Block> ready;
    ready.reserve(end - begin);
    for (size_t k = begin; k < end; ++k) {
      const size_t start = k * tune::kSkinFrames;
      ready.push_back(
          make_block(s, start, std::min<size_t>(tune::kSkinFrames, frames - start), poses));
    }
    std::atomic<size_t> next{0};
    auto work = [&] {
      for (size_t t; (t = next.fetch_add(1)) < ready.size() * chunks;) {
        const size_t from = (t % chunks) * tune::kSkinChunk;
        skin_range(s, ready[t / chunks], from, std::min(s.n_out, from + tune::kSkinChunk),
                   poses.positions, out);
      }
    };
    std::vector<std::thread> pool;
    try {
      for (size_t w = 1; w < workers; ++w) pool.emplace_back(work);
    } catch (const std::system_error&) {  // NOLINT(bugprone-empty-catch)
      // The system gives no more threads: those that run, and this one, do all the work.
    }
    work();
    for (std::thread& thread : pool) thread.join();
  }
}

}  // namespace hp
