// Convex collision shapes that bodies carry: rigid parts, objects, and hulls of a person's skin.
//
// A rigid shape is one hull in the frame of one body. A skin hull is the hull of some vertices of a
// skin *where skinning has them*: its vertices are posed one by one (poses.h), and it deforms.
//
// All bounds on a shape's movement come from its joint influences: every point of it is a weighted
// mean of points carried by the influencing bodies, so that for any convex function f of a point's
// displacement (a speed, a distance travelled, a second derivative)
//
//     f(point) <= f_0 + sum_k max_weight_k max(0, f_k - f_0)   and   f(point) <= max_k f_k,
//
// with f_k the largest value for points carried by body k within `reach` of its anchor. The first
// influence carries most of the shape. A rigid shape has one influence, and the bound is exact for
// its bounding sphere.
#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "collision/skin.h"
#include "geometry/convex.h"

namespace hp {

struct CollisionShape {
  // A body that carries part of the shape.
  struct Influence {
    int body;
    double max_weight;  // of any vertex
    Vec3 anchor;        // body's frame
    double reach;       // no point that the body carries is farther from the anchor [m]
    double far;         // nor farther than this from the body's origin [m]
    Vec3 center;        // where the body carries the shape's centre; body's frame
    int joint = -1;     // of a skin: the joint that the body is of
  };
  Convex hull;  // in the body's frame; of a skin: at rest
  int body = 0;
  int name = 0;     // index into the names of material pairs
  int person = -1;  // -1: an object
  int part = -1;    // joint index, -1: an object
  // How far the hull sticks out of the surface that it approximates [m]: objects whose hulls
  // overlap by no more than that at the start are not parted.
  double slack = 0;
  double layer = 0;  // thickness of its soft layer where that is thickest [m]; 0: it is hard
  std::vector<Influence> influences;

  // Of skin hulls.
  std::shared_ptr<const Skin> skin;
  std::vector<int> vertex;      // of the skin
  std::vector<double> weights;  // influences x vertices
  // Vertices in a row that an influence moves; the others have weight zero and are passed over, but
  // by the first influence, which has one block.
  struct WeightBlock {
    int influence, first, count;
  };
  std::vector<WeightBlock> weight_blocks;  // influence after influence
  // Pose blend shapes: a change of the joint's local rotation matrix by dR moves no vertex farther
  // than gain |dR| [m], |.| the Frobenius norm.
  struct BlendBound {
    int joint;
    double gain;
  };
  std::vector<BlendBound> blend_bounds;

  // Derives everything from hull (rigid) or from skin and vertex (skin hulls), once: copies of a
  // finished shape are finished.
  void finish();

  // Upper bound for every point of the shape of what `of(influence)` bounds for the points that one
  // body carries; see above.
  template <typename Of>
  double weighted_bound(Of of) const {
    const double first = of(influences[0]);
    double most = first, sum = first;
    for (size_t k = 1; k < influences.size(); k++) {
      const double d = of(influences[k]);
      if (d > first) sum += influences[k].max_weight * (d - first);
      most = std::max(most, d);
    }
    return std::min(most, sum);
  }

 private:
  bool finished_ = false;
  double find_blend_bounds();
  void order_vertices(const std::vector<int>& joints);
  void add_influence(int joint, double max_weight, double reach);
};

}  // namespace hp
