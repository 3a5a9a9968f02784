// SPDX-License-Identifier: Apache-2.0
#include "host/support/checksum.h"

#include <fmt/format.h>
#define XXH_STATIC_LINKING_ONLY  // the members of a state
#include <xxhash.h>

#include <cstring>
#include <stdexcept>

namespace tactel::host {
namespace {

std::string digits(std::uint64_t sum) { return fmt::format("{:016x}", sum); }

struct Free {
  void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
};

}  // namespace

std::uint64_t checksum(std::string_view bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::string checksum_text(std::string_view bytes) { return digits(checksum(bytes)); }

struct RunningChecksum::State {
  std::unique_ptr<XXH3_state_t, Free> sum{XXH3_createState()};
};

RunningChecksum::RunningChecksum() : state_(std::make_unique<State>()) { XXH3_64bits_reset(state_->sum.get()); }
RunningChecksum::~RunningChecksum() = default;
RunningChecksum::RunningChecksum(RunningChecksum&&) noexcept = default;

void RunningChecksum::add(std::string_view bytes) { XXH3_64bits_update(state_->sum.get(), bytes.data(), bytes.size()); }

std::uint64_t RunningChecksum::value() const { return XXH3_64bits_digest(state_->sum.get()); }
std::string RunningChecksum::text() const { return digits(value()); }

std::string RunningChecksum::state() const {
  return {reinterpret_cast<const char*>(state_->sum.get()), sizeof *state_->sum};
}

void RunningChecksum::go_on(std::string_view& bytes) {
  XXH3_state_t& sum = *state_->sum;
  if (bytes.size() < sizeof sum) throw std::length_error("state of a checksum");
  const auto* const secret = sum.extSecret;  // of the library, where this process has it
  std::memcpy(&sum, bytes.data(), sizeof sum);
  sum.extSecret = secret;
  bytes.remove_prefix(sizeof sum);
}

}  // namespace tactel::host
