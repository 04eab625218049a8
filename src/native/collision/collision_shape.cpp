#include "collision/collision_shape.h"

#include <cmath>

namespace hp {

namespace {

constexpr int kBlock = 4;  // vertices posed at once: the width of blend()'s vector loop
// Frobenius norm of the largest change of a rotation matrix: by half a turn.
const double kLargestChange = 2 * std::sqrt(2.0);

}  // namespace

// Fills blend_bounds and returns how far pose blend shapes move any vertex at most [m].
double CollisionShape::find_blend_bounds() {
  const Skin& s = *skin;
  blend_bounds.clear();
  double farthest = 0;
  if (s.pose_blend.empty()) return farthest;
  const int f = s.features(), joints = (int)s.joint.size();
  for (int j = 1; j < joints; j++) {
    double largest = 0;
    for (int v : vertex) {
      double square = 0;
      for (int c = 0; c < 3; c++)
        for (int k = 0; k < 9; k++) {
          double b = s.pose_blend[((size_t)v * 3 + c) * f + 9 * (j - 1) + k];
          square += b * b;
        }
      largest = std::max(largest, square);
    }
    if (largest == 0) continue;
    blend_bounds.push_back({j, std::sqrt(largest)});
    farthest += kLargestChange * blend_bounds.back().gain;
  }
  return farthest;
}

// Puts vertices with the same influencing joints side by side, so that weight blocks are long.
void CollisionShape::order_vertices(const std::vector<int>& joints) {
  const Skin& s = *skin;
  auto influenced_by = [&](int v) {
    std::vector<char> on(s.joint.size(), 0), mine;
    for (int e = s.first_weight[v]; e < s.first_weight[v + 1]; e++) on[s.weight_joint[e]] = 1;
    for (int j : joints) mine.push_back(on[j]);
    return mine;
  };
  std::vector<std::pair<std::vector<char>, int>> sorted;
  for (int v : vertex) sorted.push_back({influenced_by(v), v});
  std::sort(sorted.begin(), sorted.end());
  for (size_t i = 0; i < vertex.size(); i++) vertex[i] = sorted[i].second;
}

void CollisionShape::add_influence(int joint, double max_weight, double reach) {
  const Skin& s = *skin;
  const int n = (int)vertex.size(), k = (int)influences.size();
  influences.push_back(
      {s.body[joint], max_weight, {}, reach, reach, hull.center - s.joint[joint], joint});
  for (int i = 0; i < n; i++)
    for (int e = s.first_weight[vertex[i]]; e < s.first_weight[vertex[i] + 1]; e++)
      if (s.weight_joint[e] == joint) weights[(size_t)k * n + i] = s.weight[e];
  if (k == 0) weight_blocks.push_back({0, 0, n});
  for (int i = 0, end; i < n && k > 0; i = end) {
    end = std::min(n, i + kBlock);
    const double* w = &weights[(size_t)k * n];
    if (std::all_of(w + i, w + end, [](double x) { return x == 0; })) continue;
    if (!weight_blocks.empty() && weight_blocks.back().influence == k &&
        weight_blocks.back().first + weight_blocks.back().count == i)
      weight_blocks.back().count += end - i;
    else
      weight_blocks.push_back({k, i, end - i});
  }
}

void CollisionShape::finish() {
  if (finished_) return;
  finished_ = true;
  if (!skin) {
    hull.finish();
    influences = {
        {body, 1, hull.center, hull.bound, norm(hull.center) + hull.bound, hull.center, -1}};
    return;
  }
  const Skin& s = *skin;
  const int joints = (int)s.joint.size();
  std::vector<double> sum(joints, 0), most(joints, 0), reach(joints, 0);
  for (int v : vertex)
    for (int e = s.first_weight[v]; e < s.first_weight[v + 1]; e++) {
      const int j = s.weight_joint[e];
      sum[j] += s.weight[e];
      most[j] = std::max(most[j], s.weight[e]);
      reach[j] = std::max(reach[j], norm(s.rest[v] - s.joint[j]));
    }
  const double blend_reach = find_blend_bounds();
  std::vector<int> order;
  for (int j = 0; j < joints; j++)
    if (most[j] > 0) order.push_back(j);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return sum[a] > sum[b]; });
  order_vertices(order);
  hull.vertices.clear();
  for (int v : vertex) hull.vertices.push_back(s.rest[v]);
  hull.finish();
  hull.bound += blend_reach;
  influences.clear();
  weight_blocks.clear();
  weights.assign(order.size() * vertex.size(), 0);
  for (int j : order) add_influence(j, most[j], reach[j] + blend_reach);
  body = influences[0].body;
}

}  // namespace hp
