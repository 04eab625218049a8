#include "assembly/soft_calls.h"

#include <algorithm>
#include <cmath>

namespace hp::assembly {

namespace {

SoftLayer layer(const std::string& law, double thickness, double stiffness, double damping,
                double densification, double arm, double relaxation) {
  need(law == "linear" || law == "foam", "a soft layer: the law must be linear or foam");
  need(thickness > 0 && thickness < 10, "a soft layer: the thickness must be over 0, under 10 m");
  need(stiffness > 0 && stiffness < 1e13, "a soft layer: the stiffness must be over 0");
  need(damping >= 0 && damping < 1e13, "a soft layer: the damping must be 0 or more");
  need(densification >= 0 && densification <= 1e4 && arm >= 0 && arm <= 1e4 && relaxation > 0,
       "a soft layer: densification, arm or relaxation out of range");
  SoftLayer out;
  out.thickness = thickness;
  out.law.stiffness = stiffness, out.law.damping = damping;
  if (law == "foam")
    out.law.densification = densification, out.law.arm = arm, out.law.relaxation = relaxation;
  return out;
}

void check_normals(const Rows3& normals) {
  for (size_t i = 0; i < normals.shape(0); i++)
    need(std::fabs(norm(load3(normals.data() + 3 * i)) - 1) < 1e-3,
         "samples: normals must be unit vectors");
}

void check_areas(const Doubles& areas) {
  for (size_t i = 0; i < areas.shape(0); i++)
    need(areas.data()[i] >= 0 && areas.data()[i] < 1e6, "samples: areas must be 0 or more");
}

}  // namespace

void set_soft_static(Stepper& s, const std::string& law, double thickness, double stiffness,
                     double damping, double densification, double arm, double relaxation,
                     Rows3 corners) {
  const size_t n = s.system.world.statics.size();
  need(n > 0, "set_soft_static: no static");
  SoftLayer soft = layer(law, thickness, stiffness, damping, densification, arm, relaxation);
  soft.corners = vectors(corners);
  for (const Vec3& c : soft.corners)
    need(std::min({c.x, c.y, c.z}) > 0 && std::max({c.x, c.y, c.z}) <= 1.001 * thickness,
         "set_soft_static: thicknesses at corners must be over 0 and at most the thickness");
  s.system.soft.of_static.resize(n);
  s.system.soft.of_static.back() = std::move(soft);
}

void set_soft_shape(Stepper& s, const std::string& law, double thickness, double stiffness,
                    double damping, double densification, double arm, double relaxation) {
  const size_t n = s.system.world.shapes.size();
  need(n > 0, "set_soft_shape: no shape");
  s.system.soft.of_shape.resize(n);
  s.system.soft.of_shape.back() =
      layer(law, thickness, stiffness, damping, densification, arm, relaxation);
}

void set_samples(Stepper& s, Rows3 points, Rows3 normals, Doubles areas) {
  const size_t n = s.system.world.shapes.size(), count = points.shape(0);
  need(n > 0 && !s.system.world.shapes.back().skin, "set_samples: the last shape is not rigid");
  need(normals.shape(0) == count && areas.shape(0) == count,
       "set_samples: as many normals and areas as points");
  check_normals(normals);
  check_areas(areas);
  s.system.soft.samples.resize(n);
  SurfaceSamples& samples = s.system.soft.samples.back();
  samples = {};
  samples.points = vectors(points);
  samples.normals = vectors(normals);
  samples.areas = list<double>(areas);
}

void set_skin_samples(Stepper& s, int person, Ints vertices, Doubles areas, Rows3 normals,
                      Ints parts, Doubles thickness, Doubles stiffness, Doubles damping) {
  const size_t n = vertices.shape(0);
  need(areas.shape(0) == n && normals.shape(0) == n && parts.shape(0) == n &&
           thickness.shape(0) == n && stiffness.shape(0) == n && damping.shape(0) == n,
       "set_skin_samples: arrays of one length");
  check_normals(normals);
  check_areas(areas);
  for (size_t i = 0; i < n; i++)
    need(thickness.data()[i] >= 0 && thickness.data()[i] < 1 && damping.data()[i] >= 0 &&
             (thickness.data()[i] == 0 || stiffness.data()[i] > 0),
         "set_skin_samples: thickness, stiffness or damping out of range");
  SkinSamples skin;
  skin.person = person;
  skin.vertices = list<int>(vertices), skin.parts = list<int>(parts);
  skin.areas = list<double>(areas), skin.normals = vectors(normals);
  skin.thickness = list<double>(thickness), skin.stiffness = list<double>(stiffness);
  skin.damping = list<double>(damping);
  s.system.soft.skins.push_back(std::move(skin));
}

}  // namespace hp::assembly
