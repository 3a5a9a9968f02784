// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/creep_history.h"

namespace tactel::fem {

CreepHistory::CreepHistory(const std::vector<std::array<double, 2>>& relaxation, int cells)
    : law_(relaxation),
      crept_(Eigen::MatrixX3d::Zero(cells, 3)),
      elastic_(crept_),
      retarded_(law_.terms().size(), crept_) {}

double CreepHistory::begin(PadContact& contact, double dt) {
  step_ = law_.step(dt);
  crept_.setZero();
  for (std::size_t k = 0; k < retarded_.size(); ++k) {
    const auto& [c, e, b] = step_.terms[k];
    crept_ += c * (e * retarded_[k] + (b - e) * elastic_);
  }
  contact.creep(crept_, step_.softer);
  return step_.softer;
}

void CreepHistory::end(PadContact& contact) {
  const Eigen::MatrixX3d w = contact.displacements() / step_.softer;
  for (std::size_t k = 0; k < retarded_.size(); ++k) {
    const auto& [c, e, b] = step_.terms[k];
    retarded_[k] = e * retarded_[k] + (b - e) * elastic_ + (1 - b) * w;
  }
  elastic_ = w;
  contact.creep(-crept_, 1 / step_.softer);
}

}  // namespace tactel::fem
