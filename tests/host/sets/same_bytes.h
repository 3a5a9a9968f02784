// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "host/sets/contact_set.h"

namespace tactel::host {

/// The bytes of each dataset with rows.
inline std::map<std::string, std::string> bytes_of(const ContactSet& set) {
  std::map<std::string, std::string> bytes;
  each_dataset(set, [&](const char* name, const auto& values, int, const char*) {
    bytes[name].assign(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  });
  return bytes;
}

inline void expect_same_bytes(const ContactSet& found, const ContactSet& expected) {
  const auto wanted = bytes_of(expected);
  EXPECT_GT(wanted.size(), 10u);
  for (const auto& [name, bytes] : bytes_of(found)) EXPECT_TRUE(bytes == wanted.at(name)) << name;
}

}  // namespace tactel::host
