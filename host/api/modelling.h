// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace tactel::api {

/// Throws ConfigError for what is neither "", "fp32" nor "fp64".
void check_precision(const std::string& precision);

}  // namespace tactel::api
