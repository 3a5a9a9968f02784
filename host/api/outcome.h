// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/solve.h>

#include <memory>
#include <utility>
#include <variant>

#include "host/answers/solve.h"

namespace tactel {

/// The answer that a Path or PadPath was made of.
struct Outcome::State {
  std::shared_ptr<const std::variant<host::SolveOutcome, host::PadOutcome>> of;
};

template <class Kind>
Outcome outcome_of(Kind&& answer) {
  return Outcome(new Outcome::State{
      std::make_shared<const std::variant<host::SolveOutcome, host::PadOutcome>>(std::forward<Kind>(answer))});
}

}  // namespace tactel
