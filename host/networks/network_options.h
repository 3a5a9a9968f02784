// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace tactel::host {

/// Options of the commands that train and use networks.
struct NetworkOptions {
  std::string device, precision = "fp32";
  bool quiet = false;
};

}  // namespace tactel::host
