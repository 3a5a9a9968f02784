// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>

namespace tactel::api {

/// Throws the public exception for the one that is being handled: InputError for a value or file that cannot be used,
/// HardwareError for devices, kernels and sensors. `item` names the input where the error does not, "scenes[3]". Others
/// pass on.
[[noreturn]] void rethrow_public(const std::string& item);

/// Returns function(), with public exceptions in place of internal ones.
template <class Function>
auto with_public_errors(Function&& function, const std::string& item = {}) -> decltype(function()) {
  try {
    return std::forward<Function>(function)();
  } catch (...) {
    rethrow_public(item);
  }
}

}  // namespace tactel::api
