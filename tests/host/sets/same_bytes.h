// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>

#include "host/sets/set_simulator.h"

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

/// The rows of these ranges of contacts, {first, count} one behind the other, are those of the whole set, bit for bit.
inline void expect_ranges_make(const ContactSet& whole, const SetSimulator& simulator,
                               std::initializer_list<std::pair<std::uint64_t, std::size_t>> ranges) {
  EXPECT_GT(whole.rows(), 0u);
  std::map<std::string, std::string> together;
  for (const auto& [first, count] : ranges)
    for (const auto& [name, bytes] : bytes_of(simulator.simulate(first, count))) together[name] += bytes;
  for (const auto& [name, bytes] : bytes_of(whole)) EXPECT_TRUE(bytes == together[name]) << name;
}

}  // namespace tactel::host
