// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

#include "host/commands/program.h"
#include "host/figures/plot.h"
#include "host/support/errors.h"
#include "host/support/host_limits.h"
#include "host/support/interrupt.h"
#include "host/support/terminal.h"
#include "hw/frame_source.h"

namespace tactel::host {
namespace {

constexpr const char* too_large =
    "not enough memory for what this asks; take a coarser mesh, fewer load steps, fewer rows or a smaller network";

/// An error of the device, its compiler, a sensor or rsvg-convert. Once a stop was requested it is the effect of the
/// stop: the signal also ends the programs that they start, and interrupts their calls.
int unless_stopped(ExitCode code, const std::string& message) {
  if (!Interrupt::seen()) return complain(code, message);
  const std::string first = message.substr(0, message.find('\n'));
  std::fputs(("stopped (" + first + "); a command with --resume goes on with what is done\n").c_str(), stderr);
  return interrupted;
}

}  // namespace

int complain(ExitCode code, const std::string& message) {
  print_error(message);
  return code;
}

int guarded(const Action& action) try { return action(); } catch (const ConfigError& error) {
  return complain(wrong_input, error.what());
} catch (const ValueError& error) {
  return complain(wrong_input, error.what());
} catch (const PlotError& error) {
  return unless_stopped(wrong_input, std::string("no plot: ") + error.what());
} catch (const hw::RecordingError& error) {
  return complain(wrong_input, error.what());
} catch (const Stopped& stopped) {
  std::fputs((stopped.what() + std::string("\n")).c_str(), stderr);
  return interrupted;
} catch (const std::bad_alloc&) {
  return complain(wrong_input, too_large);
} catch (const std::length_error&) {
  return complain(wrong_input, too_large);
} catch (const std::filesystem::filesystem_error& error) {
  return complain(wrong_input,
                  error.path1().string() + ": must be a path that can be used (" + error.code().message() + ")");
} catch (const std::system_error& error) {
  if (std::ferror(stdout) != 0) return wrong_input;  // lost_output says why
  const bool no_thread = error.code() == std::errc::resource_unavailable_try_again;
  return unless_stopped(device_failed,
                        error.what() + std::string(no_thread ? "; " : "") + (no_thread ? thread_advice : ""));
} catch (const std::exception& error) {
  return unless_stopped(device_failed, error.what());
}

}  // namespace tactel::host
