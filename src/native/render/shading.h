// Software z-buffer: lights, shadow maps and the colour of one point.
#pragma once
#include "render/raster.h"

namespace raster {

struct Light {
  Vec towards;      // unit vector from the scene to the light
  double strength;  // of white light
  double softness;  // width over which a shadow's edge blurs [m]
  double wrap;      // 0: Lambert; 1: a hemisphere of light
};

struct Look {
  Vec top, bottom;  // background, linear
  Vec sky, ground;  // ambient light from above and below
  Vec focus;        // centre of fading floors (world)
  std::vector<Light> lights;
};

// Heights of the casters above a plane square to the light, on a regular grid.
class ShadowMap {
 public:
  ShadowMap(const Light& light, const Meshes& m);

  // Share of the light that reaches a point of a surface with this normal, 0 to 1: a box of
  // 2 kShadowTaps + 1 texels that slides continuously, each texel compared with the surface's own
  // tangent plane (otherwise a slope would shade itself).
  double lit(Vec p, Vec normal) const;

 private:
  void draw(const Meshes& m, const std::array<int, 3>& face);

  Vec u, v, w;  // grid axes and the direction towards the light
  double u0 = 0, v0 = 0, texel = 1;
  int width = 0, height = 0;
  std::vector<float> top;
};

class Shader {
 public:
  Shader(const Meshes& m, const Camera& cam, const Look& look);

  // Of the row of pixels v from the top.
  Vec background(double v) const { return mix(look_.top, look_.bottom, clamp01(v / cam_.height)); }
  // Linear colour and alpha of face f where the ray through picture point (u, v) meets it.
  Vec shade(int f, double u, double v, double& alpha) const;

 private:
  // A face in camera space: a corner, two edges from it, and their cross product.
  struct Plane {
    Vec a, e1, e2, n;
    double nn, height;
  };
  void meet(const Plane& face, double u, double v, double& s, double& t) const;
  Vec board(const Style& style, const Plane& face, double u, double v, Vec p) const;
  Vec light_at(const Style& style, Vec p, Vec normal) const;

  const Meshes& m_;
  const Camera& cam_;
  const Look& look_;
  std::vector<ShadowMap> shadows_;
};

}  // namespace raster
