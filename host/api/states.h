// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/solve.h>
#include <tactel/train.h>

#include <memory>
#include <utility>
#include <variant>

#include "host/answers/solve.h"
#include "nn/model.h"

namespace tactel {

struct Network::State {
  std::shared_ptr<const nn::Model> model;  ///< of all copies
};

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
