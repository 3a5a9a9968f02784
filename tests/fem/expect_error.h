// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gmock/gmock.h>

#include "fem/numbers/value_error.h"

namespace tactel {

/// The call must throw a ValueError for this key whose printed value and allowed text hold these words.
template <class Call>
void expect_value_error(Call call, const std::string& key, const std::string& value, const std::string& allowed) {
  try {
    call();
    ADD_FAILURE() << "accepted, where " << key << " = " << value << " should be an error";
  } catch (const ValueError& error) {
    EXPECT_EQ(error.key, key) << error.what();
    EXPECT_THAT(error.value, testing::HasSubstr(value));
    EXPECT_THAT(error.allowed, testing::HasSubstr(allowed));
  }
}

}  // namespace tactel
