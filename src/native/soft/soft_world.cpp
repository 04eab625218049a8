#include "soft/soft_world.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "tuning.h"

namespace hp {

namespace tune = tuning::soft;

namespace {

template <typename T>
const T& entry(const std::vector<T>& all, int i) {
  static const T none{};
  return i >= 0 && i < (int)all.size() ? all[i] : none;
}

}  // namespace

const SoftLayer& SoftWorld::layer_of_static(int i) const { return entry(of_static, i); }
const SoftLayer& SoftWorld::layer_of_shape(int i) const { return entry(of_shape, i); }
const SurfaceSamples& SoftWorld::samples_of(int shape) const { return entry(samples, shape); }

int SoftWorld::number(int shape, int sample) const {
  const SurfaceSamples& s = samples_of(shape);
  return s.number.empty() ? sample : s.number[sample];
}

void SoftWorld::finish(const CollisionWorld& world) {
  any_ = false;
  samples.resize(world.shapes.size());
  for (const SkinSamples& skin : skins) place_skin(world, skin);
  for (const SoftLayer& layer : of_static) any_ |= layer.soft();
  for (const SoftLayer& layer : of_shape) any_ |= layer.soft();
  for (size_t i = 0; i < samples.size(); i++) {
    SurfaceSamples& s = samples[i];
    double area = 0;
    s.half_width.clear();
    for (const double a : s.areas) area += a, s.half_width.push_back(0.5 * std::sqrt(a));
    if (s.size() > 0) s.pitch = std::sqrt(area / s.size());
    s.thickest = layer_of_shape((int)i).thickness;
    for (const SoftLayer& layer : s.layers) s.thickest = std::max(s.thickest, layer.thickness);
    any_ |= s.size() > 0 && s.thickest > 0;
  }
  if (!any_) return;
  find_carriers(world);
  build_trees(world);
  find_boxes(world);
}

void SoftWorld::find_boxes(const CollisionWorld& world) {
  static_boxes.clear(), static_ways.clear(), shape_boxes.clear();
  for (const Static& s : world.statics) {
    const FrameBox box = FrameBox::of(s.hull);
    static_boxes.push_back(box);
    static_ways.push_back(box.is ? box.way(s.posed.R, s.posed.center, s.hull.center)
                                 : FrameBox::Way{});
  }
  for (const CollisionShape& s : world.shapes)
    shape_boxes.push_back(s.skin ? FrameBox{} : FrameBox::of(s.hull));
}

// Two normals across each other give the axes; it is a box if all eight vertices are corners of it.
FrameBox FrameBox::of(const Convex& hull) {
  FrameBox box;
  if (hull.vertices.size() != 8 || hull.rim > 0 || hull.normals.size() < 2) return box;
  const Vec3 a = hull.normals[0];
  for (const Vec3& b : hull.normals) {
    if (std::fabs(dot(a, b)) > tune::kSquare) continue;
    const Vec3 c = cross(a, b);
    for (int i = 0; i < 3; i++)
      box.axes.m[3 * i] = a[i], box.axes.m[3 * i + 1] = b[i], box.axes.m[3 * i + 2] = c[i];
    Box3 around;
    for (const Vec3& v : hull.vertices) around.add(mul_t(box.axes, v));
    const Vec3 middle = 0.5 * (around.lo + around.hi);
    box.centre = box.axes * middle, box.half = 0.5 * (around.hi - around.lo);
    box.is = true;
    for (const Vec3& v : hull.vertices) {
      const Vec3 y = mul_t(box.axes, v) - middle;
      for (int i = 0; i < 3; i++)
        box.is &= std::fabs(std::fabs(y[i]) - box.half[i]) < tune::kSquare;
    }
    return box;
  }
  return box;
}

// Each sample belongs to one shape: one of its part that has the vertex, else any that has it.
void SoftWorld::place_skin(const CollisionWorld& world, const SkinSamples& skin) {
  struct Place {
    int shape, vertex;
  };
  std::map<int, std::vector<Place>> places;
  for (size_t i = 0; i < world.shapes.size(); i++) {
    const CollisionShape& shape = world.shapes[i];
    if (shape.person != skin.person || !shape.skin) continue;
    for (size_t v = 0; v < shape.vertex.size(); v++)
      places[shape.vertex[v]].push_back({(int)i, (int)v});
  }
  for (size_t k = 0; k < skin.vertices.size(); k++) {
    const auto found = places.find(skin.vertices[k]);
    if (found == places.end())
      throw std::invalid_argument("set_skin_samples: a vertex that no shape of the person has");
    const Place* at = &found->second[0];
    for (const Place& p : found->second)
      if (world.shapes[p.shape].part == skin.parts[k]) {
        at = &p;
        break;
      }
    SurfaceSamples& s = samples[at->shape];
    s.vertex.push_back(at->vertex);
    s.number.push_back((int)k);
    s.normals.push_back(skin.normals[k]);
    s.areas.push_back(skin.areas[k]);
    SoftLayer layer;
    layer.thickness = skin.thickness[k];
    layer.law.stiffness = layer.soft() ? skin.stiffness[k] : 0;
    layer.law.damping = layer.soft() ? skin.damping[k] : 0;
    s.layers.push_back(layer);
  }
}

void SoftWorld::find_carriers(const CollisionWorld& world) {
  for (size_t i = 0; i < samples.size(); i++) {
    const CollisionShape& shape = world.shapes[i];
    SurfaceSamples& s = samples[i];
    if (!shape.skin) continue;
    const Skin& skin = *shape.skin;
    s.first_carrier.assign(1, 0);
    const size_t n = shape.vertex.size();
    for (const int vertex : s.vertex) {
      const Vec3 r = skin.rest[shape.vertex[vertex]];
      s.points.push_back(r);
      for (size_t k = 0; k < shape.influences.size(); k++) {
        const double weight = shape.weights[k * n + vertex];
        const int joint = shape.influences[k].joint;
        if (weight == 0) continue;
        s.carriers.push_back({joint, skin.body[joint], (int)k, weight});
        s.weighted.push_back({weight * r.x, weight * r.y, weight * r.z, weight});
      }
      s.first_carrier.push_back((int)s.carriers.size());
    }
  }
}

void SoftWorld::build_trees(const CollisionWorld& world) {
  trees.resize(world.statics.size());
  for (size_t i = 0; i < world.statics.size(); i++) {
    const Static& s = world.statics[i];
    if (s.kind != Static::Kind::Mesh) continue;
    // In the order in which faces were given.
    std::vector<double> corners(9 * (size_t)s.tree->size());
    std::vector<int> faces(3 * (size_t)s.tree->size());
    for (int t = 0; t < s.tree->size(); t++) {
      Vec3 v[3];
      s.tree->triangle(t, v);
      for (int c = 0; c < 3; c++) {
        const size_t at = 3 * (size_t)s.tree->face(t) + c;
        store3(&corners[3 * at], v[c]);
        faces[at] = (int)at;
      }
    }
    trees[i] = std::make_shared<const triangles::Tree>(corners.data(), corners.size() / 3,
                                                       faces.data(), faces.size() / 3, false);
    const size_t given = layer_of_static((int)i).corners.size();
    if (given > 0 && given != faces.size() / 3)
      throw std::invalid_argument("set_soft_static: as many corner thicknesses as faces");
  }
}

}  // namespace hp
