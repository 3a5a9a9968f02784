// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/processor.h"

#if defined(__x86_64__) || defined(__i386__)
#include <cpuid.h>
#endif

#include <Eigen/Core>
#include <cstring>

namespace tactel::fem {
namespace {

/// "Intel(R) Xeon(R) ..."; empty where the processor does not say.
std::string model_name() {
#if defined(__x86_64__) || defined(__i386__)
  constexpr unsigned first = 0x80000002, last = 0x80000004;  // leaves with 16 letters each
  unsigned words[12] = {};
  if (static_cast<unsigned>(__get_cpuid_max(0x80000000, nullptr)) < last) return "";
  for (unsigned leaf = first; leaf <= last; ++leaf) {
    unsigned* at = words + 4 * (leaf - first);
    __get_cpuid(leaf, &at[0], &at[1], &at[2], &at[3]);
  }
  char letters[sizeof words + 1] = {};
  std::memcpy(letters, words, sizeof words);
  return letters;
#else
  return "";
#endif
}

}  // namespace

std::string processor_text() {
  return model_name() + ", caches " + std::to_string(Eigen::l1CacheSize()) + " " +
         std::to_string(Eigen::l2CacheSize()) + " " + std::to_string(Eigen::l3CacheSize());
}

}  // namespace tactel::fem
