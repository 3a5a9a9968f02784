// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "fem/gap_system.h"
#include "fem/scene.h"

namespace tactel::fem {

/// A path that has no derivatives: its equations are singular, or its statuses are not those of a solution.
class PathError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One increment of a converged load path: its target and the status of each element.
struct PathIncrement {
  LoadStep target;
  bool asked = true;  ///< the load has it; else a part of one of its increments
  bool held = false;  ///< nothing moved: slip is 0 everywhere
  /// Of patches (PatchContact::extrapolate): an open element whose gap closes within this part of the last increment's
  /// change sticks from where it is then. 0: none.
  double entry_ratio = 0;
  std::vector<Trial> trial;  ///< [elements]
};

/// A converged load path: rubber, indenter and the statuses that a solver found.
struct ContactPath {
  Eigen::MatrixXd compliance;     ///< [2 elements, 2 elements] mm/(N/mm), E = 1 MPa, as in Condensation
  Eigen::MatrixXd tactel_stress;  ///< [2 tactels, 2 elements] 1/mm, as in Condensation
  Eigen::VectorXd height;         ///< [elements] mm: profile above the surface; +infinity where there is no indenter
  double mu = 0;                  ///< finite: largest_friction stands for a bonded contact
  double young = 1;               ///< MPa
  std::vector<PathIncrement> increments;
};

/// A change of the inputs of a path by a parameter p. Empty members are 0; units are those of ContactPath over that
/// of p.
struct PathDirection {
  Eigen::MatrixXd compliance{}, tactel_stress{};
  Eigen::VectorXd height{};  ///< [elements], 0 where the height is infinite
  double mu = 0, young = 0;
  Eigen::VectorXd normal{}, tangential{};  ///< [increments] of the targets
};

/// The answer after an asked increment, or its derivative by p.
struct PathAnswer {
  double P = 0, Q = 0;            ///< N/mm
  std::optional<double> S;        ///< none where mu P = 0; 0 where bonded
  double depth = 0, x = 0;        ///< mm: position of the indenter
  Eigen::VectorXd n, t;           ///< [elements] N/mm
  Eigen::VectorXd frame;          ///< [2 tactels] MPa: sigma_y, then tau_xy
  double distance_to_switch = 0;  ///< of the answer alone: PathDerivatives::answers()
};

/// Derivatives of a converged load path, with statuses fixed and the history carried (implicit function theorem). With
/// the touching elements A and the sticking ones K of an increment, the unknowns z = (n_A, t_K, depth, x) obey
///     u_y = h - depth on A,   u_x = u_x of the last increment + x - x of the last increment on K,
///     t = sigma mu n on slipping elements,   depth or sum n, x or sum t as the target gives them.
/// That is linear in z: one factorization an increment answers every derivative. Where a status is
/// about to change, derivatives are one-sided; distance_to_switch tells. Forces are over E inside, so that E changes
/// frames and given forces alone.
class PathDerivatives {
 public:
  /// Solves the path again with its statuses and factors it. Throws std::invalid_argument where sizes disagree, and
  /// PathError where an increment's equations are singular.
  explicit PathDerivatives(ContactPath path);

  const ContactPath& path() const { return path_; }

  /// Returns the answers after the asked increments. distance_to_switch is the smallest of n, gap, mu n - |t| and
  /// |slip| in this and all earlier increments, each over the largest of its kind (forces, displacements): the change
  /// of statuses that is nearest. Below 0 the statuses are not those of a solution.
  const std::vector<PathAnswer>& answers() const { return answers_; }

  /// Returns the derivatives of answers() along a direction. S is none where that of the answer is.
  std::vector<PathAnswer> forward(const PathDirection& direction) const;

 private:
  struct Entry {
    Eigen::Index element;
    double part;
  };
  struct Increment {
    std::vector<Eigen::Index> touching, sticking;
    std::vector<Entry> entries;
    std::vector<double> sign;                 ///< [elements] friction_sign
    bool free_depth = false, free_x = false;  ///< given by a force
    Eigen::VectorXd f, u;                     ///< [2 elements] forces over E, mm; displacement, mm
    double depth = 0, x = 0;                  ///< mm
    Eigen::PartialPivLU<Eigen::MatrixXd> equations;
  };

  /// Gap of an element at the last increment and the one before, mm, and whether it was open and closing.
  struct Closing {
    double last, before;
    bool closes;
    double closed() const { return before - last; }
    double part() const { return last / closed(); }
  };

  Closing closing(Eigen::Index i, const Increment& last, const Increment& before) const;
  Increment solve(const PathIncrement& given, const Increment& last, const Increment& before) const;
  Eigen::MatrixXd equations_of(const Increment& now, const Eigen::MatrixXd& displacement) const;
  Eigen::MatrixXd displacement_by_unknowns(const Increment& now) const;
  void spread(const Increment& now, const Eigen::VectorXd& z, Eigen::VectorXd& f) const;
  Eigen::VectorXd sliding_forces(const Increment& now) const;
  double distance(const PathIncrement& given, const Increment& now, const Increment& last,
                  const Increment& before) const;
  PathAnswer answer(const Increment& now) const;

  Eigen::Index elements() const { return path_.height.size(); }
  Increment start() const;
  /// The increments before and the one before that; of the first, the undeformed rubber.
  const Increment& back(std::size_t k, std::size_t steps) const { return k >= steps ? increments_[k - steps] : start_; }

  ContactPath path_;
  Increment start_;
  std::vector<Increment> increments_;
  std::vector<PathAnswer> answers_;
};

}  // namespace tactel::fem
