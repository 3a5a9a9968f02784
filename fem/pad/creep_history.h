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
  /// The tractions n, t_x, t_y that would strain elastic rubber as far as it is at the end of the increment.
  Eigen::MatrixX3d straining(const PadContact& contact) const;
  /// Ends it: the contact then has its own tractions and heights.
  void end(PadContact& contact);

 private:
  Creep law_;
  CreepStep step_{};
  using Cells = Eigen::Matrix<double, Eigen::Dynamic, 6>;  ///< [cells] displacements, mm; tractions n, t_x, t_y
  static Cells now(const PadContact& contact);
  Cells crept_, elastic_;        ///< m and w of fem/pad/creep.h
  std::vector<Cells> retarded_;  ///< [terms] v
};

}  // namespace tactel::fem
