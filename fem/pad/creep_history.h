// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <array>
#include <vector>

#include "fem/pad/creep.h"
#include "fem/pad/pad_contact.h"

namespace tactel::fem {

/// What rubber remembers of the tractions on its cells. The contact of an increment is an elastic one on rubber that
/// lies where it has crept, whose tractions are larger by as much as the increment is softer.
class CreepHistory {
 public:
  CreepHistory(const std::vector<std::array<double, 2>>& relaxation, int cells);

  /// Begins an increment of dt s. Returns how many times softer it is.
  double begin(PadContact& contact, double dt);
  /// Ends it: the contact then has its own tractions and heights.
  void end(PadContact& contact);

 private:
  Creep law_;
  CreepStep step_{};
  Eigen::MatrixX3d crept_, elastic_;        ///< [cells] mm: m and w of fem/pad/creep.h
  std::vector<Eigen::MatrixX3d> retarded_;  ///< [terms][cells] mm: v
};

}  // namespace tactel::fem
