// SPDX-License-Identifier: Apache-2.0
#include "host/commands/kernel_line.h"

#include <memory>
#include <mutex>
#include <optional>

#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

constexpr double patience = 0.5;  // s; a kernel from the cache takes a tenth

/// Says what the outermost of nested messages says.
class KernelLine {
 public:
  void hear(std::string_view message) {
    const std::lock_guard lock(mutex_);
    if (!message.empty() && depth_++ == 0) line_.emplace(std::string(message), false, ProgressTimes{.first = patience});
    if (message.empty() && --depth_ == 0) line_.reset();
  }

 private:
  std::mutex mutex_;
  int depth_ = 0;
  std::optional<StageLine> line_;
};

}  // namespace

LogSink kernel_line() {
  return [line = std::make_shared<KernelLine>()](LogLevel level, std::string_view message) {
    if (level == LogLevel::busy) line->hear(message);
  };
}

}  // namespace tactel::host
