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

  // The body that point i of those that can carry is on: soles, leg by leg, then skin.
  int bearing_body(size_t i) const {
    for (const Leg& leg : legs) {
      if (i < leg.sole.size()) return leg.sole[i].body[0];
      i -= leg.sole.size();
    }
    return i < skin.size() ? skin[i].body[0] : 0;
  }
};

}  // namespace hp
