// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/contact/lines/patch_contact.h"

// What answers of lanes are worth, and the way back of those that do not hold.
namespace tactel::host {

/// Returns true where every step of a solution has converged.
bool every_step_converged(const fem::ContactSolution& solution);

/// What the certificate of a lane says of its contact.
struct PatchCertificate {
  bool solved = true;                          ///< every step
  bool linear = false;                         ///< its elements are too wide for its rubber: linear elements solve it
  std::optional<PatchContactExtent> larger{};  ///< the contact that the patch must cover next, where it was too small
  bool holds() const { return solved && !linear && !larger; }
};
PatchCertificate patch_certificate(const LaneAnswer& answer, int elements);

/// What became of the scenes of a solve_patch_contact.
struct PatchContactReport {
  std::size_t grown = 0;      ///< scenes whose patch the search found too small
  std::size_t fell_back = 0;  ///< scenes that sweeps of the kernel did not solve, or that need linear elements
  std::size_t unsolved = 0;   ///< scenes with a step that missed its tolerance all the same
};

/// Solves scenes that a launcher takes, of any kinds, in their order. A patch that is too small grows, and its
/// scene is solved again. A scene with a step over tolerance after that is solved in fp64, exactly on the same elements
/// (fem/layer/patch_exact.h) or by the twin with more sweeps, and has fell_back = true. So has a scene whose elements
/// are too wide for its rubber: linear elements solve it (fem/layer/linear_elements.h). Steps that still miss their
/// tolerance have converged = false. `known`: what a launch before said of the scenes; empty: there was none.
template <class Real>
std::vector<fem::ContactSolution> solve_patch_contact(const PatchContact<Real>& contact,
                                                      std::span<const fem::Scene> scenes,
                                                      std::vector<PatchCertificate> known = {},
                                                      PatchContactReport* report = nullptr);

/// Friction from which on a contact is known to have several solutions: wide flats at nu >= 0.499, driven by force.
inline constexpr double several_solutions_from = 1.4;

/// Solves scenes of one kind on the launcher's sensor, which must write forces of nodes and base for a certificate in
/// fp64. A contact with a step over tolerance is solved again from its first step, exactly, on the host
/// (fem/gap/gap_condensed.h, fp64), and has fell_back = true. Steps that still miss their tolerance have converged =
/// false. With second_opinion, contacts for which the exact solver certifies other forces have several = true; of
/// "bonded" contacts its answer is returned, which is the reference's.
template <class Real>
std::vector<fem::ContactSolution> solve_gap_sweep(const GapSweep<Real>& sweep, std::span<const fem::Scene> scenes);

}  // namespace tactel::host
