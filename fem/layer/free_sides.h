// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <memory>

#include "fem/layer/base_stress_table.h"
#include "fem/layer/side_difference.h"

namespace tactel::fem {

/// What the free sides of a sensor add to the compliance of an endless layer, at low rank. Displacement and force
/// are those of the surface; E = 1 MPa, mm/(N/mm):
///     u_a at x by f_b at x' = sum over the modes r of sign_r v_ra(x) v_rb(x'),   a, b = x or y,
/// the largest eigenvalues of SideDifference::compliance, both components together. A weight keeps the corner, which is
/// singular, from taking all modes. Largest error over the length 20 mm at h = 1.5 mm, relative to G_yy at 0.06 mm, nu
/// 0.3 to 0.499: 0.05 to 0.07 at the end, 0.001 to 0.008 half a mm from it, 0.0003 to 0.002 at 1 mm, 5e-5 to 2e-4 at
/// 2 mm.
class FreeSides {
 public:
  static constexpr int rank = 8;
  using Modes = Eigen::Array<double, Eigen::Dynamic, 1, 0, 2 * rank, 1>;  ///< [rank], or [2 rank] where Ends gives them

  /// Components of the modes at a place, sqrt(mm/(N/mm)).
  struct At {
    Modes y, x;
  };

  /// Sides in another form than modes of one sensor (sensor_family.h).
  struct Ends {
    virtual ~Ends() = default;
    virtual At at(double x) const = 0;
    virtual double between(const Modes& to, const Modes& by) const = 0;
  };

  /// No sides: an endless layer.
  FreeSides() = default;

  /// The sides of a sensor of this length, mm, from the block that side_block gives for it.
  FreeSides(const SideDifference& difference, double length);

  /// Of rows and signs as rows() and sign() returned them.
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  FreeSides(double length, Rows rows, Modes sign);

  /// Returns the rows of a sensor of this length, mm, by the block that side_block gives for it.
  static Eigen::Index places(const Sensor& side_block, double length);

  /// Sides in that form.
  explicit FreeSides(std::shared_ptr<const Ends> ends);

  bool endless() const { return !ends_ && rows_.rows() == 0; }

  /// Returns the modes at x, mm along the array: linear between rows; beyond them those of the last row.
  At at(double x) const;
  const Modes& sign() const { return sign_; }

  /// Returns sum of sign_r to_r by_r: displacement at one place by a unit force at another, from a component of each.
  double between(const Modes& to, const Modes& by) const;

  /// [places, 2 rank]: v_y of every mode, then v_x; the first at `left`, `step` apart.
  const Rows& rows() const { return rows_; }
  double left() const { return left_; }
  double step() const { return step_; }

 private:
  Modes sign_ = Modes::Zero(rank);
  double left_ = 0, step_ = 1;
  Rows rows_;
  std::shared_ptr<const Ends> ends_;
};

/// Adds to the table of an endless layer what the free sides change.
void add_free_sides(const SideDifference& difference, const Sensor& sensor, BaseStressTable& table);

}  // namespace tactel::fem
