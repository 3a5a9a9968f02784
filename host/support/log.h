// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <functional>
#include <string_view>

namespace tactel {

/// `busy` announces work that may take seconds; an empty message ends it. Announcements nest.
enum class LogLevel { debug, info, warning, busy };

/// Sink of the messages of the library, which prints nothing itself. An empty sink is allowed. May be called from
/// any thread.
using LogSink = std::function<void(LogLevel level, std::string_view message)>;

/// Progress of a long job: `done` of `total`, in a unit of the job. Called from the thread that started the job;
/// false cancels.
using Progress = std::function<bool(std::size_t done, std::size_t total)>;

}  // namespace tactel
