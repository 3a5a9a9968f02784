// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <string>

namespace tactel::fem {

/// FNV-1a as published: offset basis 14695981039346656037, prime 1099511628211.
inline std::uint64_t fnv(const std::string& bytes) {
  std::uint64_t hash = 14695981039346656037u;
  for (const unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211u;
  return hash;
}

/// The bytes of a cache's file with the checksum, which comes last, made right again.
inline std::string resealed(std::string bytes) {
  bytes.resize(bytes.size() - 8);
  const std::uint64_t sum = fnv(bytes);
  return bytes.append(reinterpret_cast<const char*>(&sum), 8);
}

}  // namespace tactel::fem
