// What footing knows of a person's body.
#pragma once
#include <vector>

#include "footing/leg.h"
#include "footing/skin_point.h"

namespace hp {

struct FootingModel {
  std::vector<Leg> legs;
  std::vector<SkinPoint> skin;   // all over the body, but feet and hands
  std::vector<SkinPoint> hands;  // they reach, and carry nobody
};

}  // namespace hp
