// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/creep_history.h"

namespace tactel::fem {

CreepHistory::CreepHistory(const std::vector<std::array<double, 2>>& relaxation, int cells)
    : law_(relaxation), crept_(Cells::Zero(cells, 6)), elastic_(crept_), retarded_(law_.terms().size(), crept_) {}

double CreepHistory::begin(PadContact& contact, double dt) {
  step_ = law_.step(dt);
  crept_.setZero();
  for (std::size_t k = 0; k < retarded_.size(); ++k) {
    const auto& [c, e, b] = step_.terms[k];
    crept_ += c * (e * retarded_[k] + (b - e) * elastic_);
  }
  contact.creep(crept_.leftCols<3>(), step_.softer);
  return step_.softer;
}

CreepHistory::Cells CreepHistory::now(const PadContact& contact) {
  Cells cells(contact.n().size(), 6);
  cells << contact.displacements(), contact.n(), contact.t();
  return cells;
}

Eigen::MatrixX3d CreepHistory::straining(const PadContact& contact) const {
  return (now(contact) + crept_).rightCols<3>();
}

void CreepHistory::end(PadContact& contact) {
  const Cells w = now(contact) / step_.softer;
  for (std::size_t k = 0; k < retarded_.size(); ++k) {
    const auto& [c, e, b] = step_.terms[k];
    retarded_[k] = e * retarded_[k] + (b - e) * elastic_ + (1 - b) * w;
  }
  elastic_ = w;
  contact.creep(-crept_.leftCols<3>(), 1 / step_.softer);
}

}  // namespace tactel::fem
