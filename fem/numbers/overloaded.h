// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace tactel::fem {

/// One function of several, for std::visit.
template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;  // clang 14 does not deduce it

}  // namespace tactel::fem
