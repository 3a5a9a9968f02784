#pragma once
#include <Eigen/Dense>

namespace tactel::fem {

/// What the free sides of a sensor add to the compliance of an endless layer, at low rank. Displacement and force
/// are those of the surface; E = 1 MPa, mm/(N/mm):
///     u_a at x by f_b at x' = sum over the modes r of sign_r v_ra(x) v_rb(x'),   a, b = x or y.
class FreeSides {
 public:
  static constexpr int rank = 8;
  using Modes = Eigen::Array<double, rank, 1>;

  /// Components of the modes at a place.
  struct At {
    Modes y = Modes::Zero(), x = Modes::Zero();
  };

  /// No sides: an endless layer.
  FreeSides() = default;

  /// Rows [rows, 2 rank] at equal distances from `left` to `right`, v_y of every mode, then v_x; linear between.
  FreeSides(double left, double right, Eigen::MatrixXd rows, const Modes& sign);

  bool endless() const { return rows_.rows() == 0; }
  At at(double x) const;  ///< x in mm along the array; its first or last row beyond them
  const Modes& sign() const { return sign_; }

  double left() const { return left_; }
  double step() const { return step_; }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Rows& rows() const { return rows_; }

 private:
  double left_ = 0, step_ = 1;
  Rows rows_;
  Modes sign_ = Modes::Zero();
};

}  // namespace tactel::fem
