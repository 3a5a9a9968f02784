// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <functional>

namespace tactel::host {

/// Calls work(0) ... work(count - 1) on up to `threads` threads, the caller's among them; on fewer where the system has
/// no more. Throws what the first call that failed threw, after the calls that had begun; the others are not made. A
/// stop that the caller's StopScope asks for is such a failure.
void side_by_side(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace tactel::host
