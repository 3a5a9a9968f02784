// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <variant>

#include "host/contact/pad_solve.h"
#include "host/contact/solve.h"

namespace tactel {

/// The answer that a Path or PadPath was made of.
struct Outcome {
  std::variant<host::SolveOutcome, host::PadOutcome> of;
};

}  // namespace tactel
