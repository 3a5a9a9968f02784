// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>

#include "host/commands/program.h"
#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::duration<double> patience(0.5);  // a kernel from the cache takes a tenth

/// Says what the outermost of nested messages says. A log has one line for all compilations, and one each half minute
/// for tables that are counted; a terminal shows one at a time.
class KernelLine {
 public:
  void hear(std::string_view message) {
    const std::lock_guard lock(mutex_);
    if (!message.empty() && depth_++ == 0) begin(message);
    if (message.empty() && --depth_ == 0) end();
  }

 private:
  void begin(std::string_view message) {
    begun_ = Clock::now();
    compiling_ = message.starts_with("compiling ");
    text_ = message;
    if (compiling_) text_ = "compiling kernels for this device (once)";
    if (compiling_ && terminal_) text_ += fmt::format(", number {}", compiled_ + 1);
    const bool again = compiling_ ? compiled_ > 0 : counted() == said_ && begun_ < again_;
    if (terminal_ || !again) line_.emplace(text_, false, ProgressTimes{.first = patience.count()});
  }
  void end() {
    const bool said = Clock::now() - begun_ >= patience;
    if (line_ && said) said_ = counted(), again_ = begun_ + std::chrono::seconds(30);
    line_.reset();
    if (compiling_ && said) ++compiled_;
  }

  std::string counted() const { return text_.substr(0, text_.find(',')); }

  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  std::mutex mutex_;
  int depth_ = 0;
  bool compiling_ = false;
  int compiled_ = 0;         ///< that took longer than the patience
  std::string text_, said_;  ///< of now; up to its comma that of the last line
  Clock::time_point begun_, again_;
  std::optional<StageLine> line_;
};

}  // namespace

LogSink kernel_line() {
  return [line = std::make_shared<KernelLine>()](LogLevel level, std::string_view message) {
    if (level == LogLevel::busy) line->hear(message);
  };
}

}  // namespace tactel::host
