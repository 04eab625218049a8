// Numbers of several samples at once (math/lanes.h): places in the columns of samples from i on.
#pragma once
#include "math/lanes.h"
#include "soft/near_samples.h"

namespace hp {

struct SampleLanes {
  NearSamples& near;
  int i;
  HP_INLINE Lanes& operator()(int column, int component = 0) const {
    return lanes(near[(NearSamples::Column)(column + component)] + i);
  }
};

struct ConstSampleLanes {
  const NearSamples& near;
  int i;
  HP_INLINE const Lanes& operator()(int column, int component = 0) const {
    return lanes(near[(NearSamples::Column)(column + component)] + i);
  }
};

}  // namespace hp
