// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

namespace tactel {

/// How a contact is modelled and computed.
struct SolveOptions {
  std::optional<double> accuracy{};  ///< largest error in S: the planner chooses the rung
  std::string rung{};                ///< "patch-12", "mesh-81", "paper", "reference", ...; empty: the scene's own model
  std::string solver = "batched";    ///< or, of solve() alone, "full-mesh" of a line, "twin" of a pad
  std::string precision{};  ///< "fp32", "fp64"; empty: of solve() fp64 where the device has it, else the rung's
  std::string device{};     ///< name or index of an OpenCL device; empty: the default device
  std::optional<double> tolerance{};  ///< largest relative residual that counts as converged; none: the solver's own
  bool estimate_error = false;        ///< of solve(): also solve a finer model, for Path::error
};

}  // namespace tactel
