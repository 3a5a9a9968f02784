// SPDX-License-Identifier: Apache-2.0

// JSON text: what a user's file names may hold.
#include "host/support/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace tactel::host::json_text_test {

// A name in Latin-1 is no UTF-8. It must not end a training that has just learnt for hours.
TEST(JsonText, BytesThatAreNoUtf8) {
  const nlohmann::ordered_json value = {{"set",
                                         "gr\xfc\xdf"
                                         "e.h5"},
                                        {"names", {"\xff"}},
                                        {"\xfe", 1}};
  const auto read = nlohmann::json::parse(json_text(value));
  EXPECT_EQ(read["set"],
            "gr\xef\xbf\xbd\xef\xbf\xbd"
            "e.h5");
  EXPECT_EQ(read["names"][0], "\xef\xbf\xbd");
}

}  // namespace tactel::host::json_text_test
