// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>

namespace tactel::fem {

/// Returns a short decimal text that reads back as exactly this number ("0.1", "1e-09", "41", "nan"), for
/// messages and cache keys.
std::string number_text(double value);

/// Returns "[0.1, 0.2]": at most `most` numbers, then "...".
std::string number_text(const double* values, std::size_t count, std::size_t most = 5);

/// Throws ValueError where a number is not good.
void require(bool good, std::string_view key, double value, const char* allowed);

}  // namespace tactel::fem
