#include "compiled/labels.h"

#include <algorithm>
#include <cmath>

namespace hp {

int Labels::find(std::string_view name) const {
  const auto at = std::find(everything.begin(), everything.end(), name);
  return at == everything.end() ? -1 : (int)(at - everything.begin());
}

int Labels::substeps_for(double dt) const {
  return substeps > 0 ? substeps : std::max(1, (int)std::ceil(240.0 * dt - 1e-9));
}

}  // namespace hp
