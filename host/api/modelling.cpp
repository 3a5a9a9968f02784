// SPDX-License-Identifier: Apache-2.0
#include "host/api/modelling.h"

#include "host/support/errors.h"

namespace tactel::api {

void check_precision(const std::string& precision) {
  if (!precision.empty() && precision != "fp32" && precision != "fp64")
    throw ConfigError("command line", "--precision", precision, "fp32 or fp64");
}

}  // namespace tactel::api
