#pragma once
#include <cstddef>
#include <functional>
#include <string_view>

namespace tactel {

enum class LogLevel { debug, info, warning };

/// Where the library says what it does; it prints nothing itself. An empty sink is allowed. May be called from any
/// thread.
using LogSink = std::function<void(LogLevel level, std::string_view message)>;

/// How far a long job is: `done` of `total` (the job says of what). Called from the thread that started the job; false
/// cancels.
using Progress = std::function<bool(std::size_t done, std::size_t total)>;

}  // namespace tactel
