#include "stepping/person_dofs.h"

#include <stdexcept>

namespace hp {

PersonDofs::PersonDofs(const Model& m, int root_body) {
  auto need = [](bool ok) {
    if (!ok) throw std::invalid_argument("a person needs a free root and ball joints below it");
  };
  need(m.jnt_count[root_body] == 1 && m.jnt_type[m.jnt_first[root_body]] == Joint::Free);
  const int j = m.jnt_first[root_body];
  qpos0_ = m.jnt_qpos[j];
  dof0_ = m.jnt_dof[j];
  nq_ = 7, nv_ = 6;
  balls_.push_back({3, 3, root_body});
  for (int b = root_body + 1; b < m.nbody && m.root[b] == root_body; b++)
    for (int i = m.jnt_first[b]; i < m.jnt_first[b] + m.jnt_count[b]; i++) {
      need(m.jnt_type[i] == Joint::Ball);
      balls_.push_back({m.jnt_qpos[i] - qpos0_, m.jnt_dof[i] - dof0_, b});
      nq_ += 4, nv_ += 3;
    }
}

}  // namespace hp
