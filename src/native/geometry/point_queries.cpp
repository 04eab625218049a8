#include "geometry/point_queries.h"

#include "tuning.h"

#include <atomic>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace triangles {

namespace tune = hp::tuning::geometry;

namespace {

// Calls work(begin, end) over [0, n) in blocks.
template <typename Work>
void in_blocks(size_t n, int threads, const Work& work) {
  std::atomic<size_t> next{0};
  auto run = [&] {
    for (size_t i; (i = next.fetch_add(tune::kPointBlock)) < n;)
      work(i, std::min(n, i + tune::kPointBlock));
  };
  const size_t helpers = std::min<size_t>(std::max(threads, 1) - 1, n / tune::kPointBlock);
  std::vector<std::thread> pool;
  try {
    for (size_t k = 0; k < helpers; ++k) pool.emplace_back(run);
  } catch (const std::system_error&) {  // NOLINT(bugprone-empty-catch): fewer threads do it
  }
  run();
  for (std::thread& t : pool) t.join();
}

// Bits of a number, two zeros after each.
uint64_t spread(uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// Points by threshold, then along a curve through space: neighbours stand together.
std::vector<int> in_space(const double* p, const double* threshold, size_t n) {
  double lo[3] = {p[0], p[1], p[2]}, hi[3] = {p[0], p[1], p[2]};
  for (size_t i = 0; i < 3 * n; ++i) {
    lo[i % 3] = std::min(lo[i % 3], p[i]);
    hi[i % 3] = std::max(hi[i % 3], p[i]);
  }
  const double size = std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2], 1e-300});
  std::vector<std::pair<uint64_t, int>> key(n);
  for (size_t i = 0; i < n; ++i) {
    uint64_t code = 0;
    for (int k = 0; k < 3; ++k)
      code |= spread(static_cast<uint64_t>((p[3 * i + k] - lo[k]) / size * 4095.0)) << k;
    key[i] = {code, static_cast<int>(i)};
  }
  std::sort(key.begin(), key.end(), [&](const auto& a, const auto& b) {
    const double s = threshold[a.second], t = threshold[b.second];
    return s != t ? s < t : a < b;
  });
  std::vector<int> order(n);
  for (size_t i = 0; i < n; ++i) order[i] = key[i].second;
  return order;
}

}  // namespace

void closest_points(const Tree& tree, const double* p, size_t n, int threads, double* distance,
                    int* face, double* closest) {
  in_blocks(n, threads, [&](size_t begin, size_t end) {
    int guess = -1;
    for (size_t i = begin; i < end; ++i) {
      Vec q{};
      guess = tree.closest({p[3 * i], p[3 * i + 1], p[3 * i + 2]}, guess, q, distance[i]);
      face[i] = guess < 0 ? -1 : tree.face(guess);  // of no point there is none
      closest[3 * i] = q.x;
      closest[3 * i + 1] = q.y;
      closest[3 * i + 2] = q.z;
    }
  });
}

void crossings(const Tree& tree, const double* p, size_t n, int threads, int* out) {
  in_blocks(n, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      out[i] = tree.crossings({p[3 * i], p[3 * i + 1], p[3 * i + 2]});
  });
}

void winding_numbers(const Tree& tree, const double* p, size_t n, double tolerance, int threads,
                     double* out) {
  in_blocks(n, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      out[i] = tree.winding_within({p[3 * i], p[3 * i + 1], p[3 * i + 2]}, tolerance);
  });
}

void exceeds(const Tree& tree, const double* p, size_t n, const double* threshold, int threads,
             uint8_t* out) {
  if (n == 0) return;
  std::vector<int> order = in_space(p, threshold, n);
  auto point = [p](int i) { return Vec{p[3 * i], p[3 * i + 1], p[3 * i + 2]}; };
  auto tell = [out](int i, bool yes) { out[i] = yes; };
  in_blocks(n, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin, j; i < end; i = j) {
      const double t = threshold[order[i]];
      for (j = i + 1; j < end && threshold[order[j]] == t;) ++j;
      tree.exceeds_all(point, &order[i], static_cast<int>(j - i), t, tell);
    }
  });
}

}  // namespace triangles
