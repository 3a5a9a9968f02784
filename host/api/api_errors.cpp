// SPDX-License-Identifier: Apache-2.0
#include <tactel/progress.h>

#include <algorithm>
#include <utility>

#include "host/api/conversion.h"
#include "host/support/errors.h"
#include "host/support/stop_scope.h"
#include "hw/frame_source.h"

namespace tactel {

struct CancelScope::State {
  explicit State(std::function<bool()> function) : asked(std::move(function)) {}
  host::StopScope::Asked asked;
  host::StopScope scope{&asked};
};
CancelScope::CancelScope(bool (*asked)(void*), void* with) : state_(new State([=] { return asked(with); })) {}
CancelScope::~CancelScope() { delete state_; }

Cancelled::~Cancelled() = default;
HardwareError::~HardwareError() = default;

namespace api {
namespace {

/// A line that a terminal shows as it is, without the end of a list of a million.
std::string plain(std::string text) {
  if (constexpr std::size_t most = 1000; text.size() > most) text.replace(most, std::string::npos, " ...");
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return text;
}

std::string joined(const std::string& item, const std::string& key) {
  return item.empty() || key.empty() ? item + key : item + "." + key;
}

/// An option of a command is the member of the same name: "--stop-error" is "stop_error".
std::string member_of(std::string option) {
  option.erase(0, option.find_first_not_of('-'));
  std::ranges::replace(option, '-', '_');
  return option;
}

[[noreturn]] void throw_input_error(const ConfigError& error, const std::string& item) {
  if (error.key == "--output") throw InputError(plain(error.value), "cannot be written", "must be " + error.allowed);
  std::string place = joined(item, error.key);
  if (error.file == "command line")
    place = member_of(error.key);
  else if (!error.file.empty())
    place = error.file + (error.line > 0 ? ":" + std::to_string(error.line) : "") +
            (error.key.empty() ? "" : ": " + error.key);
  throw InputError(plain(place), plain(error.value), plain("must be " + error.allowed));
}

}  // namespace

void rethrow_public(const std::string& item) {
  try {
    throw;
  } catch (const ConfigError& error) {
    throw_input_error(error, item);
  } catch (const ValueError& error) {
    throw InputError(plain(joined(item, error.key)), plain(error.value), plain("must be " + error.allowed));
  } catch (const DeviceError& error) {
    throw HardwareError(error.what());
  } catch (const KernelBuildError& error) {
    throw HardwareError(error.what());
  } catch (const hw::SourceError& error) {
    throw HardwareError(error.what());
  } catch (const Stopped& error) {
    throw Cancelled(error.what());
  }
}

}  // namespace api
}  // namespace tactel
