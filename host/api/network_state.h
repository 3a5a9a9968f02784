// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/train.h>

#include <memory>

#include "nn/model.h"

namespace tactel {

struct Network::State {
  std::shared_ptr<const nn::Model> model;  ///< of all copies
};

}  // namespace tactel
