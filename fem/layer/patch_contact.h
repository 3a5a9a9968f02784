// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>

#include "fem/gap/accuracy.h"
#include "fem/gap/contact_laws.h"
#include "fem/layer/patch_laws.h"

namespace tactel::fem {

/// Options of contacts on patches, for the kernel, its twin and the reference.
struct PatchOptions {
  int elements = 12;        ///< the kernel has 8, 12, 16 and 24, each its own program
  double tolerance = 1e-3;  ///< largest change of a force in the last sweep over the largest pressure force; of given
                            ///< forces, which a tenth of it serves in the sweeps
  double accept = 0;        ///< largest residual of a solved step; 0: as the kernel in fp32, of the reference 1e-10
  int pressing_increments = 0;  ///< least number of increments to each pressing target; 0: elements / 3, of the
                                ///< reference 20
  int most_sweeps = 0;          ///< an increment that needs more is not converged; 0: 2000, of the kernel 400
  int most_growths = 4;         ///< times that a patch may grow; the reference: 8
  bool entries = true;          ///< of the twin: PatchContact::extrapolate estimates where an element is touched
  bool linear = false;          ///< of the reference: linear elements also where constant ones are narrow enough

  double accepted() const { return accept > 0 ? accept : std::min(slow_on_patch * tolerance, largest_accept<float>); }
  int increments() const { return pressing_increments > 0 ? pressing_increments : (elements + 2) / 3; }
  int sweeps() const { return most_sweeps > 0 ? most_sweeps : 2000; }
};

/// The elements of a patch under one indenter, and where it is. Forces are over E, mm.
class PatchContact {
 public:
  /// `height` [elements + 2 rows_beyond] mm: profile above the surface at the places of PatchCompliance; +infinity
  /// where there is no indenter or no rubber.
  PatchContact(const PatchCompliance& compliance, Eigen::VectorXd height, double mu, const PatchOptions& options);

  double depth = 0, x = 0;  ///< mm: position of the indenter; set by the caller

  const Eigen::VectorXd& n() const { return n_; }
  const Eigen::VectorXd& t() const { return t_; }
  double first_touch() const { return first_touch_; }  ///< mm: depth at which an element's middle is touched

  /// Starts an increment: keeps the forces, and guesses new ones by going on `ratio` times the last change. While the
  /// indenter presses only, an open element whose gap would close within this increment sticks from where it would be
  /// then: with gaps g and g' and displacements u and u' at the last increment and the one before, after the part
  /// s = g / (g' - g) of the last change, at u + s (u - u').
  void extrapolate(double ratio);

  /// Starts an increment in which nothing moves.
  void hold() { extrapolate(0), held_ = true; }

  /// Drops all forces.
  void release();

  /// Sweeps until no force changes by more than the tolerance. Returns false where most_sweeps do not suffice;
  /// adds the number of sweeps to `sweeps`.
  bool solve(int& sweeps);

  /// State of the laws at elements and at the places beyond, from the forces alone: [elements + 2 rows_beyond].
  GapElements elements() const;

  /// Ends an increment. u_x of a sticking element counts as having followed the indenter, so that what the tolerance
  /// left is made good by the next increment.
  void remember();

  /// Returns u_x [elements] mm.
  Eigen::VectorXd ux() const;

 private:
  void touch_within(double ratio);
  double sweep(const PatchLaws& laws);
  const PatchLaws& laws_at(int sweep);

  const PatchCompliance& compliance_;
  Eigen::VectorXd height_, n_, t_, n_last_, t_last_, ux_last_;
  Eigen::VectorXd gap_, gap_before_, ux_, ux_before_;  ///< at the end of the last increment and of the one before
  double mu_, x_last_ = 0, first_touch_;
  bool held_ = false;
  PatchOptions options_;
  PatchLaws laws_[3];  ///< plain, damped, damped twice
};

}  // namespace tactel::fem
